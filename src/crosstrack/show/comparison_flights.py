"""The flights of a comparison, as read from the results of a campaign, grouped by what they flew."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from crosstrack.campaign.words import CALM, OWN
from crosstrack.types import Array

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#1E293B")
"""told apart by the colour-blind (Okabe and Ito 2008), without the yellow that is too light for white paper"""
DASHES = ("solid", "dash", "dot", "dashdot")
"""once all colours are taken they come again in the next of these"""


@dataclass(frozen=True)
class Look:
    """How a tracker is drawn, the same everywhere."""

    index: int
    name: str
    color: str
    dash: str


@dataclass(frozen=True)
class Flown:
    """One flight of a comparison, thinned."""

    mission: str
    tracker: str
    wind: str
    seed: int
    summary: Mapping[str, Any] = field(repr=False)
    """outcome and metrics"""
    time: Array = field(repr=False)
    """(n,) s, since the first sample"""
    position: Array = field(repr=False)
    """(n, 3) m"""
    cross_track: Array = field(repr=False)
    """(n,) m"""
    tracking: Array | None = field(repr=False)
    """(n,) m; None without a trajectory"""
    speed: Array = field(repr=False)
    """(n,) m/s"""
    route: Array = field(repr=False)
    """(m, 3) m"""

    @property
    def arrived(self) -> bool:
        """Whether it got to the last waypoint."""
        return bool(self.summary["arrived"])

    @property
    def labels(self) -> dict[str, Any]:
        """What it is filed under."""
        return {"mission": self.mission, "tracker": self.tracker, "wind": self.wind, "seed": self.seed}

    @property
    def end(self) -> Array:
        """The last finite position, (3,) m."""
        finite = self.position[np.isfinite(self.position).all(axis=1)]
        return np.asarray(finite[-1] if len(finite) else self.route[0])

    @property
    def case(self) -> str:
        """The wind and the seed, as a text."""
        return f"{weather(self.wind)}, seed {self.seed}"


def weather(wind: str) -> str:
    """Return the word for a wind as a text."""
    return "its own wind" if wind == OWN else wind if wind == CALM else f"wind {wind}"


@dataclass(frozen=True)
class Group:
    """The flights of one mission in one wind."""

    mission: str
    wind: str
    flights: tuple[Flown, ...]

    def of(self, tracker: str) -> list[Flown]:
        """Return the flights of one tracker, in order of their seeds."""
        return [flight for flight in self.flights if flight.tracker == tracker]

    def median(self, tracker: str) -> Flown | None:
        """Return the flight in the middle from best to worst, those that did not arrive last; None without any.

        The better one of two middle ones; so what is drawn is a flight that failed where more than half did.
        """
        ordered = sorted(self.of(tracker), key=badness)
        return ordered[(len(ordered) - 1) // 2] if ordered else None


def badness(flight: Flown) -> tuple[bool, float, int]:
    """Return what flights are ordered by: arrival, then the error once captured or else of the whole flight."""
    error = flight.summary["cross_track_rms_captured_m"]
    return not flight.arrived, flight.summary["cross_track_rms_m"] if error is None else error, flight.seed


def flown(results: Sequence[Mapping[str, Any]]) -> list[Flown]:
    """Return the flights that results tell of; None in them, where a number is not finite, is NaN here."""
    return [one(result) for result in results]


def one(result: Mapping[str, Any]) -> Flown:
    """Return the flight that a result tells of."""
    labels, trace = result["labels"], result["trace"]
    return Flown(
        mission=str(labels["mission"]),
        tracker=str(labels["tracker"]),
        wind=str(labels["wind"]),
        seed=int(labels["seed"]),
        summary=result["summary"],
        time=np.array(trace["time"], float),
        position=np.array(trace["position"], float).reshape(-1, 3),
        cross_track=np.array(trace["cross_track"], float),
        tracking=None if trace["tracking"] is None else np.array(trace["tracking"], float),
        speed=np.array(trace["speed"], float),
        route=np.array(result["route"], float).reshape(-1, 3),
    )


def looks(trackers: Sequence[str]) -> dict[str, Look]:
    """Return the look of every tracker, in the order in which they come up."""
    names = dict.fromkeys(trackers)
    pairs = [(color, dash) for dash, color in product(DASHES, COLORS)]
    return {name: Look(index, name, *pairs[index % len(pairs)]) for index, name in enumerate(names)}


def groups(flights: Sequence[Flown]) -> list[Group]:
    """Return the flights by mission and wind, in the order in which these come up."""
    found: dict[tuple[str, str], list[Flown]] = {}
    for flight in flights:
        found.setdefault((flight.mission, flight.wind), []).append(flight)
    missions = list(dict.fromkeys(flight.mission for flight in flights))
    ordered = sorted(found.items(), key=lambda item: missions.index(item[0][0]))
    return [Group(mission, wind, tuple(members)) for (mission, wind), members in ordered]
