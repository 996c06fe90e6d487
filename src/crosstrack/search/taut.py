"""Pull a way taut: straight where nothing is in the way, along obstacles at the clearance where something is."""

import numpy as np

from crosstrack.protocols import Map
from crosstrack.types import Array

ROUNDS = 12
HALVINGS = 6
ENOUGH = 2e-4
"""relative, the gain of a round below which it is the last"""
SHORT = 0.02
"""m, what a corner is not cut by any more"""


def taut(world: Map, way: Array, clearance: float) -> Array:
    """Return a way (n, 3) that is shorter, with the same ends, each leg of which keeps the clearance.

    Points are left out while the straight line is clear; then each is drawn towards the line between its neighbours,
    and its corner is cut, as far as the lines stay clear. What is left runs along tangents and around obstacles.

    Args:
        world: what is in the way
        way: (m, 3) m, whose legs keep the clearance
        clearance: m
    """
    way = direct(world, way, clearance)
    before = length(way)
    for _ in range(ROUNDS):
        way = drawn(world, way, clearance)
        way = direct(world, cut(world, way, clearance), clearance)
        after = length(way)
        if after > (1 - ENOUGH) * before:
            break
        before = after
    return way


def length(way: Array) -> float:
    """Return the length of a polyline (n, 3), m."""
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def direct(world: Map, way: Array, clearance: float) -> Array:
    """Return a way without the points between two that see one another, far ahead as far as doubling steps reach."""
    kept, last = [0], len(way) - 1
    while kept[-1] < last:
        here = kept[-1]
        seen, step = 1, 2
        while here + seen < last:
            ahead = min(step, last - here)
            if world.swept(way[here], way[here + ahead]) < clearance:
                break
            seen, step = ahead, 2 * ahead
        blocked = min(step, last - here)
        while blocked - seen > 1:
            middle = (seen + blocked) // 2
            if world.swept(way[here], way[here + middle]) < clearance:
                blocked = middle
            else:
                seen = middle
        kept.append(here + seen)
    return way[kept]


def drawn(world: Map, way: Array, clearance: float) -> Array:
    """Return a way whose inner points are drawn towards the line between their neighbours."""
    way = way.copy()
    for i in range(1, len(way) - 1):
        before, here, after = way[i - 1], way[i], way[i + 1]
        line = after - before
        share = np.clip((here - before) @ line / max(line @ line, 1e-12), 0.0, 1.0)
        off = before + share * line - here
        if off @ off < SHORT**2 / 16:
            continue
        clear, blocked = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (clear + blocked)
            at = here + middle * off
            if world.swept(before, at) >= clearance and world.swept(at, after) >= clearance:
                clear = middle
            else:
                blocked = middle
        way[i] = here + clear * off
    return way


def cut(world: Map, way: Array, clearance: float) -> Array:
    """Return a way whose corners are cut as far as the chord is clear; each becomes two."""
    points = [way[0]]
    for i in range(1, len(way) - 1):
        here, before, after = way[i], points[-1], way[i + 1]
        back, ahead = float(np.linalg.norm(before - here)), 0.5 * float(np.linalg.norm(after - here))
        if i == len(way) - 2:
            ahead *= 2.0
        most = min(back, ahead)
        if most < SHORT or straight(before, here, after):
            points.append(here)
            continue
        inward, outward = (before - here) / back, (after - here) / np.linalg.norm(after - here)
        clear, blocked = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = 0.5 * (clear + blocked)
            if world.swept(here + middle * most * inward, here + middle * most * outward) >= clearance:
                clear = middle
            else:
                blocked = middle
        if clear * most < SHORT:
            points.append(here)
        else:
            points += [here + clear * most * inward, here + clear * most * outward]
    return np.array([*points, way[-1]])


def straight(before: Array, here: Array, after: Array) -> bool:
    """Return whether a corner is too flat to be worth a cut."""
    one, two = here - before, after - here
    detour = np.linalg.norm(one) + np.linalg.norm(two) - np.linalg.norm(one + two)
    return bool(detour < 1e-4)
