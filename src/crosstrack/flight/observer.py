"""Who watches a flight, and what they are shown."""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Protocol

import numpy as np

from crosstrack.flight.effort import Effort
from crosstrack.flight.plan import Plan
from crosstrack.flight.record import Record
from crosstrack.types import Array, Outcome

NOTHING = np.empty((0, 3))
"""no points"""


@dataclass(frozen=True, slots=True)
class Sample:
    """One row of a record. Its arrays are not changed afterwards."""

    time: float
    """s"""
    position: Array
    """(3,) m, true"""
    velocity: Array
    """(3,) m/s, true"""
    attitude: Array
    """(4,) xyzw, true"""
    rate: Array
    """(3,) rad/s, true, body"""
    rotor_speeds: Array
    """(rotors,) rad/s; as many on every row"""
    estimate: Array
    """(3,) m, position as the tracker saw it"""
    command_velocity: Array
    """(3,) m/s; NaN where left to the vehicle"""
    command_acceleration: Array
    """(3,) m/s²; NaN where left to the vehicle"""
    command_attitude: Array
    """(4,) xyzw; NaN where left to the vehicle"""
    command_rate: Array
    """(3,) rad/s, body; NaN where left to the vehicle"""
    command_thrust: float
    """m/s², thrust over mass; NaN where left to the vehicle"""
    aim: Array
    """(3,) m, the point chased"""
    progress: float
    """m, arc length along the course"""
    wind: Array
    """(3,) m/s at the vehicle"""
    clearance: float
    """m, least swept distance to an obstacle since the row before; inf without obstacles"""
    separation: float
    """m, least distance to the centre of another vehicle since the row before; inf alone"""
    interventions: float
    """sum of 2^k over the avoiders k of the chain that changed the command flown until this row"""
    seen: Array = field(default_factory=lambda: NOTHING)
    """(m, 3) m, world, where rays of its sensors ended since the row before, as the vehicle takes it"""
    course: Array | None = None
    """(m, 3) m, the new course, where it was planned again since the row before"""


class Observer(Protocol):
    """Something that watches a flight while it is flown."""

    def begin(self, plan: Plan) -> None:
        """Take note of the plan, before the first sample."""

    def sample(self, row: Sample) -> None:
        """Take note of one row, in order of time."""

    def end(self, outcome: Outcome, effort: Effort) -> None:
        """Take note of how it ended and what it took of the machine."""


def collect(rows: Sequence[Sample]) -> Record:
    """Stack samples into a record; there must be at least one."""
    return Record(*(np.array([getattr(row, column.name) for row in rows]) for column in fields(Record)))
