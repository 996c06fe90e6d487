"""A flight in a few lines of JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import finite_or_none
from crosstrack.types import Outcome


def summary(flight: Flight) -> dict[str, Any]:
    """Return the outcome and the metrics as JSON has them: null where there is nothing to measure."""
    metrics = {
        name: finite_or_none(value) if isinstance(value, float) else value
        for name, value in asdict(flight.metrics).items()
    }
    return {
        "outcome": flight.outcome.name.lower(),
        "outcome_text": flight.outcome.value,
        "arrived": flight.outcome is Outcome.ARRIVED,
        "collided": flight.outcome is Outcome.COLLIDED,
    } | metrics


def summary_together(flights: Sequence[Flight]) -> dict[str, Any]:
    """Return the outcomes and the metrics of several vehicles that flew at once, as JSON has them.

    Each vehicle has an entry with its name; what stands above them is true of all, the least separation of any two.
    """
    separations = [flight.metrics.min_separation_m for flight in flights]
    known = [separation for separation in separations if separation is not None]
    return {
        "arrived": all(flight.outcome is Outcome.ARRIVED for flight in flights),
        "collided": any(flight.outcome is Outcome.COLLIDED for flight in flights),
        "min_separation_m": min(known, default=None),
        "flight_time_s": max(flight.metrics.flight_time_s for flight in flights),
        "vehicles": [{"name": flight.plan.name} | summary(flight) for flight in flights],
    }
