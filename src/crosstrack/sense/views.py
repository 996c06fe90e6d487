"""What past scans saw: how far space was free along every direction.

A view is a picture on the six faces of a cube around the sensor, with axes of the world: for every cell of it, the
least distance that any ray of the cell went. A point that later turns out to be occupied, though all rays near its
direction once went well past it, was free before: something has moved there. What stands still is never so, from
wherever it is looked at. Source: G. Kim and A. Kim, "Remove, then Revert", IROS 2020, compare scans so in range images.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array, Scan

EXTENT = 1.3
"""half the width of a face over its distance: neighbouring faces overlap, so that what is near an edge is whole"""
CELLS = 84
"""of a face along each side: 1.8° in its middle, 0.9° where the next begins"""
WIDEST = 9
"""cells to either side that are looked at"""
FEWEST_RAYS = 3
"""that must have gone past a point, within a cell of it, for it to have been free"""


@dataclass(frozen=True, eq=False)
class View:
    """One scan, as it limits what was occupied then."""

    time: float
    """s"""
    origin: Array
    """(3,) m, world, of the sensor"""
    least: NDArray[np.float32]
    """(6, 84, 84) m, least distance that any ray of a cell went; inf without any"""
    rays: NDArray[np.uint8]
    """(6, 84, 84) of each cell, at most 255"""
    beams: int
    """rays of the scan, by which the sensors of a vehicle are told apart"""
    gap: float
    """rad, between two rays that are neighbours in the picture that they form"""


def view_of(scan: Scan, origin: Array, directions: Array) -> View:
    """Return the view of a scan, in which NaN says that a ray measured nothing.

    Args:
        scan: as it was made
        origin: (3,) m, world, of the sensor
        directions: (rays, 3) of its rays, in the world
    """
    least, rays = _painted(directions, scan.ranges, scan.max_range)
    beams = len(directions)
    beside = [step for step in (1, beams // scan.rows) if scan.rows > 1 and step < beams]
    gap = max((float(np.linalg.norm(directions[step] - directions[0])) for step in beside), default=0.0)
    return View(scan.time, origin, least, rays, beams, gap)


def surprises(scan: Scan, origin: Array, directions: Array, views: Sequence[View], margin: float) -> Array:
    """Return the points (n, 3) m, world, hit by a scan that were free in an earlier view by a margin (m) around."""
    free = np.zeros(len(directions), dtype=bool)
    for view in views:
        _saw_through(view.least, view.rays, view.origin, view.gap, origin, directions, scan.ranges, margin, free)
    points: Array = origin + scan.ranges[free, None] * directions[free]
    return points


@compiled
def _painted(directions: Array, ranges: Array, unhit: float) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Return the picture of rays; those near the edge of a face are on the next one too."""
    least = np.full((6, CELLS, CELLS), np.inf, dtype=np.float32)
    rays = np.zeros((6, CELLS, CELLS), dtype=np.uint8)
    half = 0.5 * CELLS / EXTENT
    for k in range(len(directions)):
        if math.isnan(ranges[k]):
            continue
        reached = min(ranges[k], unhit)
        for axis in range(3):
            depth = directions[k, axis]
            face = 2 * axis + (1 if depth < 0.0 else 0)
            depth = abs(depth)
            u, v = directions[k, (axis + 1) % 3], directions[k, (axis + 2) % 3]
            if max(abs(u), abs(v)) >= EXTENT * depth:
                continue
            i, j = int((u / depth + EXTENT) * half), int((v / depth + EXTENT) * half)
            least[face, i, j] = min(least[face, i, j], reached)
            rays[face, i, j] = min(rays[face, i, j] + 1, 255)
    return least, rays


@compiled
def _saw_through(
    least: NDArray[np.float32],
    rays: NDArray[np.uint8],
    then: Array,
    gap: float,
    now: Array,
    directions: Array,
    ranges: Array,
    margin: float,
    free: NDArray[np.bool_],
) -> None:
    """Set `free` where all rays that came near a point once, from `then`, went past what is hit now, from `now`."""
    half = 0.5 * CELLS / EXTENT
    away = np.empty(3)
    for k in range(len(directions)):
        if free[k] or not ranges[k] < math.inf:
            continue
        axis = 0
        for i in range(3):
            away[i] = now[i] + ranges[k] * directions[k, i] - then[i]
            if abs(away[i]) > abs(away[axis]):
                axis = i
        depth = abs(away[axis])
        face = 2 * axis + (1 if away[axis] < 0.0 else 0)
        far = math.sqrt(away[0] ** 2 + away[1] ** 2 + away[2] ** 2)
        spread = (margin + gap * far * far / max(depth, 1e-3)) / max(depth, 1e-3)
        wide = 1 + int(min(spread * half, 1e3))
        if wide > WIDEST:
            continue
        row = int((away[(axis + 1) % 3] / depth + EXTENT) * half)
        column = int((away[(axis + 2) % 3] / depth + EXTENT) * half)
        if least[face, row, column] > far + margin:
            free[k] = _all_past(least[face], rays[face], row, column, wide, far + margin)


@compiled
def _all_past(
    least: NDArray[np.float32], rays: NDArray[np.uint8], row: int, column: int, wide: int, beyond: float
) -> bool:
    """Return whether all rays around a cell went beyond a distance (m), and enough of them close to it."""
    near = 0
    for i in range(max(row - wide, 0), min(row + wide + 1, CELLS)):
        for j in range(max(column - wide, 0), min(column + wide + 1, CELLS)):
            if least[i, j] <= beyond:
                return False
            if abs(i - row) <= 1 and abs(j - column) <= 1:
                near += rays[i, j]
    return near >= FEWEST_RAYS
