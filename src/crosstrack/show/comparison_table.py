"""The ranked tables of a comparison, written out."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from crosstrack.show.comparison_flights import Flown
from crosstrack.show.words import NOTHING
from crosstrack.types import Outcome

COLUMNS = (
    ("cross_track_rms_captured_m", "cross-track RMS, captured (m)", ".3f"),
    ("cross_track_max_captured_m", "largest error, captured (m)", ".3f"),
    ("tracking_rms_m", "tracking RMS (m)", ".3f"),
    ("time_ratio", "flight time over planned", ".3f"),
    ("rms_jerk_mps3", "jerk, RMS (m/s³)", ".1f"),
)
"""metric, heading and number format"""
SHORT = {Outcome.TIMED_OUT: "out of time", Outcome.LEFT_BOUNDS: "out of bounds", Outcome.FAILED: "program error"}


@dataclass(frozen=True)
class Standing:
    """One tracker's row of a table."""

    rank: int
    tracker: str
    arrived: str
    failures: str
    """how many did not arrive, and why; empty where all did"""
    numbers: tuple[tuple[str, str], ...]
    """of every column: median, and least to greatest where they differ"""


def standings(flights: Sequence[Flown]) -> list[Standing]:
    """Return the trackers from best to worst: by arrivals, then by the median error once captured."""
    names = list(dict.fromkeys(flight.tracker for flight in flights))
    by = {name: [flight for flight in flights if flight.tracker == name] for name in names}
    ordered = sorted(names, key=lambda name: worth(by[name]))
    return [standing(rank, name, by[name]) for rank, name in enumerate(ordered, 1)]


def worth(mine: Sequence[Flown]) -> tuple[float, float]:
    """Return what trackers are ordered by."""
    errors = values(mine, "cross_track_rms_captured_m")
    return -sum(flight.arrived for flight in mine) / len(mine), median(errors) if errors else float("inf")


def standing(rank: int, name: str, mine: Sequence[Flown]) -> Standing:
    """Write out the row of a tracker."""
    lost = Counter(str(flight.summary["outcome"]) for flight in mine if not flight.arrived)
    return Standing(
        rank=rank,
        tracker=name,
        arrived=f"{len(mine) - lost.total()} of {len(mine)}",
        failures=", ".join(f"{count} {short(outcome)}" for outcome, count in lost.most_common()),
        numbers=tuple(spread(values(mine, metric), style) for metric, _, style in COLUMNS),
    )


def short(outcome: str) -> str:
    """Return the key of an outcome in a word or two."""
    return SHORT.get(Outcome[outcome.upper()], outcome.replace("_", " "))


def values(mine: Sequence[Flown], metric: str) -> list[float]:
    """Return a metric of the flights that arrived and have it."""
    return [flight.summary[metric] for flight in mine if flight.arrived and flight.summary[metric] is not None]


def spread(found: Sequence[float], style: str) -> tuple[str, str]:
    """Write the median, and the least and the greatest where there are several."""
    if not found:
        return NOTHING, ""
    low, high = format(min(found), style), format(max(found), style)
    return format(median(found), style), "" if low == high else f"{low} to {high}"
