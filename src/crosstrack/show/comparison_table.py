"""The ranked tables of a comparison, written out."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from crosstrack.campaign.ranking import Loss, Row, Spread, ranking, spread
from crosstrack.show.comparison_flights import Flown
from crosstrack.show.words import NOTHING
from crosstrack.types import Outcome

HEADINGS = (
    "cross-track RMS, captured (m)",
    "largest error, captured (m)",
    "tracking RMS (m)",
    "flight time over planned",
    "jerk, RMS (m/s³)",
)
SHORT = {Outcome.TIMED_OUT: "out of time", Outcome.LEFT_BOUNDS: "out of bounds"}
BROKEN = "broken by an error"
LETTERS = 500
"""of an error that are shown"""


@dataclass(frozen=True)
class Standing:
    """One tracker's row of a table."""

    rank: int
    tracker: str
    arrived: str
    failures: str
    """how many did not arrive, and why; empty where all did"""
    numbers: tuple[tuple[str, str], ...]
    """of every heading: median, and least to greatest where they differ"""


@dataclass(frozen=True)
class Failure:
    """A flight that did not arrive."""

    labels: Mapping[str, Any]
    """mission, tracker, wind, seed"""
    outcome: str
    """key of the outcome"""
    ended: str
    """the same in words, or the error"""
    after: str
    """time of flight with its unit; empty where that is not known"""


def standings(flights: Sequence[Flown], losses: Sequence[Loss] = ()) -> list[Standing]:
    """Return the trackers from best to worst, see `campaign.ranking`."""
    results = [{"labels": {"tracker": flight.tracker}, "summary": flight.summary} for flight in flights]
    return [standing(rank, row, flights) for rank, row in enumerate(ranking(results, losses), 1)]


def standing(rank: int, row: Row, flights: Sequence[Flown]) -> Standing:
    """Write out the row of a tracker."""
    mine = [flight for flight in flights if flight.tracker == row.tracker]
    failed = Counter(short(flight.summary["outcome"]) for flight in mine if not flight.arrived)
    failed += Counter({BROKEN: row.lost})
    jerks = [flight.summary["rms_jerk_mps3"] for flight in mine if flight.summary["rms_jerk_mps3"] is not None]
    return Standing(
        rank=rank,
        tracker=row.tracker,
        arrived=f"{row.arrived} of {row.flights}",
        failures=", ".join(f"{count} {outcome}" for outcome, count in failed.most_common()),
        numbers=(
            written(row.cross_track_rms),
            (NOTHING if row.cross_track_max is None else number(row.cross_track_max), ""),
            written(row.tracking_rms),
            written(row.time_ratio),
            written(spread(jerks), ".1f"),
        ),
    )


def short(outcome: str) -> str:
    """Return the key of an outcome in a word or two."""
    return SHORT.get(Outcome[outcome.upper()], outcome.replace("_", " "))


def written(found: Spread | None, style: str = ".3f") -> tuple[str, str]:
    """Write the median, and the least and the greatest where they differ."""
    if found is None:
        return NOTHING, ""
    low, high = number(found.least, style), number(found.greatest, style)
    return number(found.median, style), "" if low == high else f"{low} to {high}"


def number(value: float, style: str = ".3f") -> str:
    """Write a number; what is infinite was never reached."""
    return format(value, style) if math.isfinite(value) else "never"


def failures(flights: Sequence[Flown], losses: Sequence[Loss]) -> list[Failure]:
    """Return the flights that did not arrive, and those of which there is only an error."""
    ended = [(flight, flight.summary["outcome"]) for flight in flights if not flight.arrived]
    return [
        *(Failure(one.labels, key, short(key), f"{one.summary['flight_time_s']:.1f} s") for one, key in ended),
        *(Failure(loss.labels, "failed", loss.error[:LETTERS], "") for loss in losses),
    ]
