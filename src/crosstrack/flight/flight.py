"""What a flight leaves behind."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from crosstrack.flight.effort import NO_EFFORT, Effort
from crosstrack.flight.metrics import Metrics, cross_track, measure, tracking
from crosstrack.flight.observer import NOTHING, Sample, collect
from crosstrack.flight.plan import Plan
from crosstrack.flight.record import Record
from crosstrack.types import Array, Outcome

GRAIN = 0.1
"""m, edge of the cubes of which one point seen is kept each"""


@dataclass(frozen=True)
class Replan:
    """A course that was planned in flight."""

    time: float
    """s"""
    points: Array
    """(n, 3) m, along it"""


@dataclass(frozen=True)
class Flight:
    """A flown mission: the plan, how it ended, and the record."""

    plan: Plan
    outcome: Outcome
    record: Record
    effort: Effort = NO_EFFORT
    """what it took of the machine"""
    replans: tuple[Replan, ...] = ()
    """the courses planned in flight, in order of time"""
    seen: Array = field(default_factory=lambda: NOTHING)
    """(n, 3) m, what the sensors saw: one point of every 0.1 m"""

    @cached_property
    def cross_track(self) -> Array:
        """(n,) m, distance of every position to the route near the progress; NaN where not finite"""
        return cross_track(self.plan, self.record)

    @cached_property
    def tracking(self) -> Array:
        """(n,) m, distance of every position to where the trajectory is by then; NaN without a trajectory"""
        return tracking(self.plan, self.record, bool(self.replans))

    @cached_property
    def metrics(self) -> Metrics:
        """How well it went, in numbers."""
        return measure(self.plan, self.outcome, self.record, self.effort, len(self.replans))


def flight_of(plan: Plan, outcome: Outcome, rows: Sequence[Sample], effort: Effort) -> Flight:
    """Return the flight of at least one sample."""
    replans = [Replan(row.time, row.course) for row in rows if row.course is not None]
    return Flight(plan, outcome, collect(rows), effort, tuple(replans), thinned([row.seen for row in rows]))


def thinned(clouds: Sequence[Array]) -> Array:
    """Return one point of every cube of `GRAIN` of clouds of points (n, 3) m, the first."""
    points = np.concatenate([NOTHING, *clouds])
    if not len(points):
        return points
    cells = np.floor(points / GRAIN).astype(np.int64)
    cells -= cells.min(axis=0)
    _, first = np.unique(np.ravel_multi_index(cells.T, cells.max(axis=0) + 1), return_index=True)
    return points[np.sort(first)]
