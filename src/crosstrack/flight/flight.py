"""What a flight leaves behind."""

from dataclasses import dataclass
from functools import cached_property

from crosstrack.flight.metrics import Metrics, cross_track, measure, tracking
from crosstrack.flight.plan import Plan
from crosstrack.flight.record import Record
from crosstrack.types import Array, Outcome


@dataclass(frozen=True)
class Flight:
    """A flown mission: the plan, how it ended, and the record."""

    plan: Plan
    outcome: Outcome
    record: Record
    wall_time: float
    """s, of the machine, spent flying"""

    @cached_property
    def cross_track(self) -> Array:
        """(n,) m, distance of every position to the route near the progress; NaN where not finite"""
        return cross_track(self.plan, self.record)

    @cached_property
    def tracking(self) -> Array:
        """(n,) m, distance of every position to where the trajectory is by then; NaN without a trajectory"""
        return tracking(self.plan, self.record)

    @cached_property
    def metrics(self) -> Metrics:
        """How well it went, in numbers."""
        return measure(self.plan, self.outcome, self.record, self.wall_time)
