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
    nearby: NDArray[np.float32]
    """(6, 84, 84) m, least distance that any ray of a cell and the eight around it on its face went; inf without any"""
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
    return View(scan.time, origin, _least_nearby(least), rays, beams, gap)


def surprises(points: Array, views: Sequence[View], margin: float) -> Array:
    """Return those of the points (n, 3) m, world, hit now, that were free in an earlier view by a margin (m) around."""
    free = np.zeros(len(points), dtype=np.bool_)
    for view in views or (UNSEEN,):
        _saw_through(view.nearby, view.rays, view.origin, view.gap, points, margin, free)
    return points[free]


UNSEEN = View(
    time=-math.inf,
    origin=np.zeros(3),
    nearby=np.zeros((6, CELLS, CELLS), dtype=np.float32),
    rays=np.zeros((6, CELLS, CELLS), dtype=np.uint8),
    beams=0,
    gap=0.0,
)
"""before the first: nothing was free. The first scan is compared too, so that all is compiled by then"""


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
            scale = half / depth
            i, j = int(u * scale + EXTENT * half), int(v * scale + EXTENT * half)
            least[face, i, j] = min(least[face, i, j], reached)
            rays[face, i, j] = min(rays[face, i, j] + 1, 255)
    return least, rays


@compiled
def _least_nearby(least: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the least of each cell and the eight around it, on its face alone."""
    beside, out = least.copy(), np.empty_like(least)
    for face in range(6):
        for i in range(CELLS):
            for j in range(1, CELLS - 1):
                beside[face, i, j] = min(least[face, i, j - 1], least[face, i, j], least[face, i, j + 1])
            beside[face, i, 0] = min(least[face, i, 0], least[face, i, 1])
            beside[face, i, CELLS - 1] = min(least[face, i, CELLS - 2], least[face, i, CELLS - 1])
        for i in range(CELLS):
            below, above = max(i - 1, 0), min(i + 1, CELLS - 1)
            for j in range(CELLS):
                out[face, i, j] = min(beside[face, below, j], beside[face, i, j], beside[face, above, j])
    return out


@compiled
def _saw_through(
    nearby: NDArray[np.float32],
    rays: NDArray[np.uint8],
    then: Array,
    gap: float,
    points: Array,
    margin: float,
    free: NDArray[np.bool_],
) -> None:
    """Set `free` where all rays that came near a point once, from `then`, went past it."""
    half, pictured = 0.5 * CELLS / EXTENT, nearby.ravel()
    asked, found = np.empty(len(points), dtype=np.int64), 0
    for k in range(len(points)):  # most were not: found without branches
        cell, far, _depth = _cell(points[k, 0] - then[0], points[k, 1] - then[1], points[k, 2] - then[2])
        asked[found] = k
        found += (pictured[cell] > far + margin) & (not free[k])
    for n in range(found):
        k = asked[n]
        cell, far, depth = _cell(points[k, 0] - then[0], points[k, 1] - then[1], points[k, 2] - then[2])
        wide = 1 + int(min((margin + gap * far * far / depth) / depth * half, 1e3))
        if wide <= WIDEST:
            face, row, column = cell // CELLS**2, (cell // CELLS) % CELLS, cell % CELLS
            free[k] = _all_past(nearby[face], rays[face], row, column, wide, far + margin)


@compiled
def _cell(x: float, y: float, z: float) -> tuple[int, float, float]:
    """Return the cell of the picture that a vector (m) points to, of all one after the other, its length and depth."""
    ax, ay, az = abs(x), abs(y), abs(z)
    second, third = ay > ax, az > max(ax, ay)
    depth = max(ax, ay, az, 1e-3)
    ahead = z if third else (y if second else x)
    u, v = (x if third else (z if second else y)), (y if third else (x if second else z))
    face = (4 if third else (2 if second else 0)) + (1 if ahead < 0.0 else 0)
    scale = 0.5 * CELLS / EXTENT
    row, column = int((u / depth + EXTENT) * scale), int((v / depth + EXTENT) * scale)
    return (face * CELLS + row) * CELLS + column, math.sqrt(x * x + y * y + z * z), depth


@compiled
def _all_past(
    nearby: NDArray[np.float32], rays: NDArray[np.uint8], row: int, column: int, wide: int, beyond: float
) -> bool:
    """Return whether all rays around a cell went beyond a distance (m), and enough of them close to it.

    A cell of `nearby` answers for the nine around it, so every third is asked, and the last.
    """
    for i in range(-wide + 1, wide + 2, 3):
        for j in range(-wide + 1, wide + 2, 3):
            p, q = row + min(i, wide - 1), column + min(j, wide - 1)
            if nearby[min(max(p, 0), CELLS - 1), min(max(q, 0), CELLS - 1)] <= beyond:
                return False
    near = 0
    for i in range(max(row - 1, 0), min(row + 2, CELLS)):
        for j in range(max(column - 1, 0), min(column + 2, CELLS)):
            near += rays[i, j]
    return near >= FEWEST_RAYS
