"""Everything a flight needs, built and checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Avoider, Course, Map, Planner, PlanningTask, Scenario, Tracker, Vehicle


@dataclass(frozen=True)
class Replanning:
    """How a course is planned again in flight."""

    planner: Planner
    """one that replans"""
    task: PlanningTask
    """what to ask it for; waypoints, motion and world are those of the moment"""
    blocked: bool
    """whether a course that leads too close to an obstacle is planned again, not only one that leads nowhere"""


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
    avoiders: tuple[Avoider[Any], ...] = ()
    told: Map | None = None
    """what the vehicle is told of the obstacles that stand still; None for all of them"""
    warned: bool = True
    """whether it is told where the moving obstacles are, and how fast; else it must see them"""
    replanning: Replanning | None = None
    """how the course is planned again in flight; None where it is not"""
    planning_time: float = 0.0
    """s of the machine, that the first plan took"""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """the files that the document names, by that name: the log keeps them, so that a replay needs nothing else"""
