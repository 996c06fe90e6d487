"""Everything a flight needs, built and checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Avoider, Course, Scenario, Tracker, Vehicle


@dataclass(frozen=True)
class Plan:
    """A mission made into objects, ready to fly."""

    name: str
    document: Mapping[str, Any]
    """the resolved mission as JSON has it: what the log and the report keep"""
    route: Polyline
    """the path as asked for; cross-track errors are measured against it"""
    course: Course
    """the path as flown: smooth, with its speed, and the trajectory where a planner made one"""
    vehicle: Vehicle
    tracker: Tracker[Any]
    scenario: Scenario
    timeout: float
    """s"""
    avoiders: tuple[Avoider, ...] = ()
    files: Mapping[str, bytes] = field(default_factory=dict)
    """the files that the document names, by that name: the log keeps them, so that a replay needs nothing else"""
