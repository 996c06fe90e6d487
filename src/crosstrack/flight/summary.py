"""A flight in a few lines of JSON."""

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
