"""What avoiding did to a flight: where avoiders stepped in, the courses planned again, what the sensors saw."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.flight import Flight
from crosstrack.flight.plan import Plan
from crosstrack.show.style import AVOIDERS, INK
from crosstrack.types import Array

SEEN_IN_SPACE, SEEN_FROM_ABOVE = 10_000, 4_000
"""points that the sensors saw, drawn at most"""
SIGHTED = "seen by the sensors"
"""what they are called in a legend"""
OFF_GROUND = 0.1
"""m, above the ground, from which on what was seen is drawn"""


@dataclass(frozen=True)
class Intervention:
    """One avoider of the chain, and when it changed the command."""

    name: str
    color: str
    guards: bool
    """whether it is there for safety alone: then it is marked on the path, others as a band along it"""
    rows: NDArray[np.bool_]
    """(n,) whether the command flown until each sample was changed by it"""

    def band(self, positions: Array) -> Array:
        """Return positions (n, 3) m with NaN for those where it did not step in."""
        return np.where(self.rows[:, None], positions, np.nan)


def interventions(flight: Flight) -> list[Intervention]:
    """Return what each avoider of the chain did; nothing without any."""
    mask = flight.record.interventions.astype(np.int64)
    plan = flight.plan
    looks = zip(names(plan), colors(plan), plan.avoiders, strict=True)
    return [
        Intervention(name, color, avoider.guards, (mask >> k & 1).astype(bool))
        for k, (name, color, avoider) in enumerate(looks)
    ]


def names(plan: Plan) -> list[str]:
    """Return what the avoiders are called; a second one of a kind is numbered."""
    kinds = [type(avoider).__name__.lower() for avoider in plan.avoiders]
    return [kind if kinds.count(kind) == 1 else f"{kind} {kinds[: k + 1].count(kind)}" for k, kind in enumerate(kinds)]


def colors(plan: Plan) -> list[str]:
    """Return the colours of the avoiders: those that are there for safety alone are black."""
    guards = [avoider.guards for avoider in plan.avoiders]
    return [INK if guard else AVOIDERS[guards[:k].count(False) % len(AVOIDERS)] for k, guard in enumerate(guards)]


def replanned(flight: Flight) -> Array:
    """Return the courses planned in flight as one line with gaps, (n, 3) m."""
    gap = np.full((1, 3), np.nan)
    return np.concatenate([np.empty((0, 3)), *(part for each in flight.replans for part in (each.points, gap))])


def seen(flight: Flight, box: Array, most: int) -> Array:
    """Return what the sensors saw above the ground within a box (2, 3) m, (n, 3) m, at most `most` points."""
    points: Array = flight.seen
    if not len(points):
        return points
    inside = ((points >= box[0]) & (points <= box[1])).all(axis=1)
    points = points[inside & (points[:, 2] > flight.plan.scenario.world.ground + OFF_GROUND)]
    thinned: Array = points[:: max(1, -(-len(points) // most))]
    return thinned
