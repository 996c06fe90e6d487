"""From a way over a lattice to one that keeps the clearance everywhere."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.protocols import Map
from crosstrack.search.window import OUTSIDE, Window
from crosstrack.types import Array

ASIDE = 0.004
"""m, that points are pushed farther than they must, so that the straight lines between them are clear too"""
ROUNDING = 1e-3
"""m, that a way may be closer than the clearance"""
PUSHES = 20
SPLITS = 4
AROUND = (0.5, 0.5, 3.0)
"""m, within which points around a place that is too narrow are looked at: where things are upright, at any height"""


def pushed(world: Map, points: Array, clearance: float, low: Array, high: Array) -> Array:
    """Return points (n, 3) moved up the distance until they have the clearance, within boxes (n, 3) or one (3,)."""
    points = points.copy()
    near = np.arange(len(points))
    low, high = np.broadcast_to(low, points.shape), np.broadcast_to(high, points.shape)
    for attempt in range(PUSHES):
        distance = world.distance(points[near])
        near, distance = near[distance < clearance], distance[distance < clearance]
        if not near.size:
            break
        step = clearance - distance if attempt < PUSHES // 2 else 0.5 * (clearance - distance)
        moved = points[near] + step[:, None] * world.gradient(points[near])
        points[near] = np.clip(moved, low[near], high[near])
    return points


def repaired(world: Map, points: Array, clearance: float, box: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return a way whose legs keep the clearance, less `ROUNDING`, and which of the points given have no room for it.

    Where there are such points, the way is not complete.

    Args:
        world: what is in the way
        points: (n, 3) m; the first and the last stay where they are
        clearance: m
        box: (2, 3) m, to stay in
    """
    inner = pushed(world, points[1:-1], clearance + ASIDE, *box)
    stuck = np.zeros(len(points), dtype=bool)
    stuck[1:-1] = world.distance(inner) < clearance - ROUNDING
    if stuck.any():
        return points, stuck
    way = np.concatenate([points[:1], inner, points[-1:]])
    legs = [way[:1]]
    for i in range(len(way) - 1):
        leg = joined(world, way[i], way[i + 1], clearance, box, SPLITS)
        if leg is None:
            stuck[i : i + 2] = True
        else:
            legs.append(leg)
    return np.concatenate(legs), stuck


def joined(world: Map, start: Array, end: Array, clearance: float, box: Array, splits: int) -> Array | None:
    """Return the points (n, 3) after `start` of a way to `end`, split and pushed aside; None where there is none."""
    if world.swept(start, end) >= clearance - ROUNDING:
        return end[None]
    if splits == 0:
        return None
    middle = pushed(world, 0.5 * (start + end)[None], clearance + ASIDE, *box)[0]
    first = joined(world, start, middle, clearance, box, splits - 1)
    second = None if first is None else joined(world, middle, end, clearance, box, splits - 1)
    return None if first is None or second is None else np.concatenate([first, second])


def block(world: Map, window: Window, places: NDArray[np.int32], clearance: float) -> None:
    """Take points that have no room for a way off a window: some, and those around that turn out the same.

    Args:
        world: what is in the way
        window: whose values are changed
        places: (n,) indices of points that have no room
        clearance: m
    """
    shape = np.array(window.values.shape)
    reach = np.ceil(np.array(AROUND) / window.cell).astype(int)
    near = np.zeros(window.values.shape, dtype=bool)
    for at in np.stack(np.unravel_index(places, window.values.shape), axis=1):
        low, high = np.maximum(at - reach, 1), np.minimum(at + reach + 1, shape - 1)
        near[low[0] : high[0], low[1] : high[1], low[2] : high[2]] = True
    near &= (window.values < clearance) & (window.values >= 0.0)
    doubtful = np.argwhere(near)
    points, half = window.low + doubtful * window.cell, 0.6 * window.cell
    best = pushed(world, points, clearance, points - half, points + half)
    window.values[tuple(doubtful[world.distance(best) < clearance - ROUNDING].T)] = OUTSIDE
    window.values.reshape(-1)[places] = OUTSIDE
