"""Distances to many points at all points of a lattice at once.

Every point of the lattice learns from its neighbours which point is nearest to them, and keeps the nearest of these:
vector propagation (P.-E. Danielsson, "Euclidean distance mapping", CGIP 14, 1980) in space, with the points where they
are rather than on the lattice. What it returns is the distance to some point held, so never less than the least one; it is
more only where no neighbour shares the nearest point, and then by a small part of a cell.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

Names = NDArray[np.int32]
Squares = NDArray[np.float32]
Row = tuple[int, int, float, float, float, float]
"""points of the lattice along z: where the first is kept, how many, the coordinates of the first (m), from one to the next (m)"""


@compiled
def plant(points: Array, low: Array, cell: float, counts: tuple[int, int, int], names: Names, squares: Squares) -> None:
    """Offer each point to the corners of the cell that it is in, or to those of the lattice's cell nearest to it."""
    nx, ny, nz = counts
    for name in range(len(points)):
        i = int(min(max(math.floor((points[name, 0] - low[0]) / cell), 0.0), max(nx - 2.0, 0.0)))
        j = int(min(max(math.floor((points[name, 1] - low[1]) / cell), 0.0), max(ny - 2.0, 0.0)))
        k = int(min(max(math.floor((points[name, 2] - low[2]) / cell), 0.0), max(nz - 2.0, 0.0)))
        for a in range(i, min(i + 2, nx)):
            for b in range(j, min(j + 2, ny)):
                for c in range(k, min(k + 2, nz)):
                    at = (a * ny + b) * nz + c
                    dx, dy = points[name, 0] - low[0] - a * cell, points[name, 1] - low[1] - b * cell
                    dz = points[name, 2] - low[2] - c * cell
                    square = dx * dx + dy * dy + dz * dz
                    if square < squares[at]:
                        squares[at], names[at] = square, name


@compiled
def learn(points: Array, row: Row, offset: int, names: Names, squares: Squares) -> None:
    """Let the points of a row along z take over what is nearest to the points at an offset, if that is nearer."""
    first, count, x, y, z, step = row
    for k in range(count):
        at = first + k
        name = names[at + offset]
        if name >= 0 and name != names[at]:
            dx, dy, dz = points[name, 0] - x, points[name, 1] - y, points[name, 2] - z - k * step
            square = dx * dx + dy * dy + dz * dz
            if square < squares[at]:
                squares[at], names[at] = square, name


@compiled
def learn_within(points: Array, row: Row, names: Names, squares: Squares) -> None:
    """Let the points of a row along z learn from those before them, then from those behind them."""
    first, count, x, y, z, step = row
    for turn in range(2 * count - 2):
        k, back = (turn + 1, 1) if turn < count - 1 else (2 * count - 3 - turn, -1)
        at = first + k
        name = names[at - back]
        if name >= 0 and name != names[at]:
            dx, dy, dz = points[name, 0] - x, points[name, 1] - y, points[name, 2] - z - k * step
            square = dx * dx + dy * dy + dz * dz
            if square < squares[at]:
                squares[at], names[at] = square, name


@compiled
def lattice_distances(
    points: Array, low: Array, cell: float, counts: tuple[int, int, int], reach: float
) -> Squares:
    """Return the distance (counts) m at the points of a lattice to the nearest of points (n, 3), at most reach (m)."""
    nx, ny, nz = counts
    plane = ny * nz
    names = np.full(nx * plane, -1, dtype=np.int32)
    squares = np.full(nx * plane, reach * reach, dtype=np.float32)
    plant(points, low, cell, counts, names, squares)
    for way in (1, -1):
        for turn in range(nx):
            i = turn if way > 0 else nx - 1 - turn
            x = low[0] + i * cell
            for j in range(ny):
                row = (i * plane + j * nz, nz, x, low[1] + j * cell, low[2], cell)
                if turn > 0:
                    learn(points, row, -way * plane, names, squares)
                if j > 0:
                    learn(points, row, -nz, names, squares)
                learn_within(points, row, names, squares)
            for j in range(ny - 2, -1, -1):
                row = (i * plane + j * nz, nz, x, low[1] + j * cell, low[2], cell)
                learn(points, row, nz, names, squares)
                learn_within(points, row, names, squares)
    return np.sqrt(squares).reshape(counts)
