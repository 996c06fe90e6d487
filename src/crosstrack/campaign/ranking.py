"""Which tracker flew best."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any


@dataclass(frozen=True)
class Spread:
    """A quantity over several flights; infinite where it was not reached."""

    median: float
    least: float
    greatest: float


@dataclass(frozen=True)
class Row:
    """How one tracker did over all its flights."""

    tracker: str
    flights: int
    """how many there are of it, those that were lost to errors too"""
    arrived: int
    collided: int
    lost: int
    """flights of which there is only an error"""
    cross_track_rms: Spread | None
    """m, from capture on, over the flights flown; infinite for one that never came within 0.05 m of the route"""
    cross_track_max: float | None
    """m, from capture on, the greatest of all flights; infinite likewise"""
    tracking_rms: Spread | None
    """m; None without a trajectory"""
    time_ratio: Spread | None
    """flight time over planned time, of the flights that arrived"""

    @property
    def rate(self) -> float:
        """Return the share of flights that arrived."""
        return self.arrived / self.flights

    def order(self, timed: bool) -> tuple[float, ...]:
        """Return what rows are ranked by, least first; tracking errors come first where flights are `timed`."""
        spreads = (self.cross_track_rms, self.tracking_rms)
        errors = [spread.median if spread else math.inf for spread in (reversed(spreads) if timed else spreads)]
        return (-self.rate, *errors)


@dataclass(frozen=True)
class Loss:
    """A flight of which there is only an error."""

    labels: Mapping[str, Any]
    """mission, tracker, wind, seed"""
    error: str


def ranking(results: Sequence[Mapping[str, Any]], losses: Sequence[Loss] = ()) -> list[Row]:
    """Return a row for each tracker, the best first; equally good ones in the order in which they come.

    More arrivals are better; then a smaller median over its flights of the RMS of the cross-track error from capture
    on; then a smaller median of the RMS of the tracking error. Where every flight has a trajectory the tracking error
    comes before the cross-track error, which is then mostly the planner's: how far the trajectory is from the route.

    Args:
        results: what `flights.fly` returned
        losses: flights of which there is only an error; they did not arrive
    """
    everyone = [*(result["labels"]["tracker"] for result in results), *(loss.labels["tracker"] for loss in losses)]
    rows = [
        row_of(
            tracker,
            [result["summary"] for result in results if result["labels"]["tracker"] == tracker],
            sum(loss.labels["tracker"] == tracker for loss in losses),
        )
        for tracker in dict.fromkeys(everyone)
    ]
    timed = all(result["summary"]["tracking_rms_m"] is not None for result in results)
    return sorted(rows, key=lambda row: row.order(timed))


def row_of(tracker: str, flown: Sequence[Mapping[str, Any]], lost: int) -> Row:
    """Return the row of one tracker from the summaries of its flights."""
    largest = spread(_or_never(numbers["cross_track_max_captured_m"] for numbers in flown))
    return Row(
        tracker=tracker,
        flights=len(flown) + lost,
        arrived=sum(numbers["arrived"] for numbers in flown),
        collided=sum(numbers["collided"] for numbers in flown),
        lost=lost,
        cross_track_rms=spread(_or_never(numbers["cross_track_rms_captured_m"] for numbers in flown)),
        cross_track_max=largest.greatest if largest else None,
        tracking_rms=spread(_there(numbers["tracking_rms_m"] for numbers in flown)),
        time_ratio=spread(_there(numbers["time_ratio"] for numbers in flown)),
    )


def spread(values: Sequence[float]) -> Spread | None:
    """Return the spread of values, None without any."""
    return Spread(median(values), min(values), max(values)) if values else None


def _or_never(values: Iterable[float | None]) -> list[float]:
    return [math.inf if value is None else value for value in values]


def _there(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]
