"""A way through free space between two points, as short as the obstacles allow."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import Problem, Unreachable
from crosstrack.protocols import Map
from crosstrack.search.astar import FOUND, search
from crosstrack.search.departure import departure
from crosstrack.search.remaining import remaining
from crosstrack.search.repair import ROUNDING, block, repaired
from crosstrack.search.taut import length, taut
from crosstrack.search.window import HALF, SOUND, Window, look
from crosstrack.types import Array

DOUBT = 3.0
"""what a metre costs more where the lattice cannot tell whether there is room"""
REPAIRS = 200
PAD = 6.0
"""m, that a window reaches beyond the two points at least"""
FEW_POINTS = 1_500_000
"""of a lattice over the whole box, up to which it is one window"""
GROWTH = 2.5
"""times as wide is the next window, when there is no way in one or a longer one may be shorter outside"""


class Found(NamedTuple):
    """What a search over a window has found."""

    way: Array | None
    """(n, 3) m; None where there is none"""
    closed: bool
    """whether a window that is wider would not change that"""


def find_way(
    world: Map, start: Array, goal: Array, clearance: float, box: Array, reach: float = 0.4, repairs: int = REPAIRS
) -> Array:
    """Return the way from start to goal, (n, 3) m: taut, with the clearance but where its ends have less.

    Args:
        world: what is in the way
        start: (3,) m
        goal: (3,) m
        clearance: m, to keep from obstacles
        box: (2, 3) m, lowest and highest corner of the space that may be flown; may be infinite
        reach: m, how far distances are needed
        repairs: ways over the lattice that may turn out too narrow before it counts as that there is none

    Raises:
        Unreachable: an end has no room, or there is no way between them.
    """
    if (inside := float(world.distance(goal))) <= 0.0:
        raise Unreachable("search", [Problem("goal", f"is inside an obstacle, {-inside:.3g} m deep")])
    out = departure(world, start, clearance, box, "start")
    into = departure(world, goal, clearance, box, "goal")[::-1]
    first, last = out[-1], into[0]
    way = np.array([first, last])
    if not np.array_equal(first, last) and world.swept(first, last) < clearance - ROUNDING:
        way = taut(world, wide_search(world, first, last, clearance, box, reach, repairs), clearance - ROUNDING)
    way = np.concatenate([out[:-1], way, into[1:]])
    return np.asarray(way[np.concatenate([[True], (np.diff(way, axis=0) != 0.0).any(axis=1)])])


def wide_search(
    world: Map, first: Array, last: Array, clearance: float, box: Array, reach: float, repairs: int
) -> Array:
    """Return a way (n, 3) m from a window that is wide enough to hold the shortest one.

    Raises:
        Unreachable: there is none.
    """
    span = float(np.linalg.norm(last - first))
    pad, best = max(PAD, 0.25 * span), None
    if np.prod(box[1] - box[0]) < FEW_POINTS * (SOUND * clearance) ** 3:
        pad = np.inf
    while True:
        part = np.array([np.minimum(first, last) - pad, np.maximum(first, last) + pad]).clip(*box)
        window = look(world, part, clearance, reach)
        coarse = window.cell > 1.01 * SOUND * clearance
        found = search_window(world, window, first, last, clearance, box, repairs)
        if found.way is not None:
            best = found.way
            needed = 0.5 * max(length(best) ** 2 - span**2, 0.0) ** 0.5
            if found.closed or needed <= pad or coarse:
                return best
            pad = 1.1 * needed
        elif best is not None:
            return best
        elif found.closed or coarse:
            raise Unreachable("search", [Problem("goal", narrow(clearance, window.cell))])
        else:
            pad *= GROWTH


def narrow(clearance: float, cell: float) -> str:
    """Say that there is no way, and with what clearance there is none for certain."""
    certain = max(clearance, cell * (0.5 + HALF))
    return f"obstacles enclose it, or leave no gap that is {2 * certain:.3g} m wide"


def search_window(
    world: Map, window: Window, first: Array, last: Array, clearance: float, box: Array, repairs: int
) -> Found:
    """Return the way within a window, repaired where the lattice could not tell; blocked places are searched around."""
    start, goal = window.index(first), window.index(last)
    heights = window.values.shape[2]
    closed = np.array_equal(window.box, box)
    for _ in range(repairs):
        freest = np.ascontiguousarray(window.values.max(axis=2))
        column = goal // heights
        left = remaining(freest, window.cell, clearance, DOUBT, column)
        status, places, _ = search(window.values, left, window.cell, clearance, DOUBT, start, goal)
        if status != FOUND:
            return Found(None, closed or within(window, places, box))
        points = window.points(places)
        points[0], points[-1] = first, last
        way, stuck = repaired(world, points, clearance, window.box)
        if not stuck.any():
            return Found(way, closed)
        stuck[[0, -1]] = False
        block(world, window, places[stuck], clearance)
    return Found(None, True)


def within(window: Window, places: NDArray[np.int32], box: Array) -> bool:
    """Return whether places do not reach a side of a window that is not a side of the box."""
    at = np.stack(np.unravel_index(places, window.values.shape), axis=1)
    inner = np.array(window.values.shape) - 2
    touched = np.array([(at <= 1).any(axis=0), (at >= inner).any(axis=0)])
    return not bool((touched & (window.box != box)).any())
