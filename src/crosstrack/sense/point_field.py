"""Distances to many points at the points of a lattice: each point lowers what lies within reach of it."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Field
from crosstrack.types import Array


@compiled
def span(x: float, reach: float, cell: float, count: int) -> tuple[int, int]:
    """Return the first lattice coordinate within reach (m) of a coordinate, and how many are."""
    first = int(max(math.ceil((x - reach) / cell), 0.0))
    return first, int(max(min(math.floor((x + reach) / cell) + 1.0, 1.0 * count) - first, 0.0))


@compiled
def lattice_distances(points: Array, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
    """Return the distance (counts) m at the points of a lattice to the nearest of points (n, 3), at most reach (m)."""
    nx, ny, nz = counts
    most = np.float32(reach * reach)
    squares = np.full(nx * ny * nz, most, dtype=np.float32)
    for p in range(len(points)):
        x, y, z = points[p, 0] - low[0], points[p, 1] - low[1], points[p, 2] - low[2]
        first_x, many_x = span(x, reach, cell, nx)
        first_y, many_y = span(y, reach, cell, ny)
        first_z, many_z = span(z, reach, cell, nz)
        lift, step = np.float32(first_z * cell - z), np.float32(cell)
        for i in range(first_x, first_x + many_x):
            dx = i * cell - x
            for j in range(first_y, first_y + many_y):
                dy = j * cell - y
                flat = np.float32(dx * dx + dy * dy)
                if flat >= most:
                    continue
                row = np.uint64((i * ny + j) * nz + first_z)  # unsigned, so that no index counts from the end
                for k in range(many_z):
                    dz = lift + step * np.float32(k)
                    at = row + np.uint64(k)
                    squares[at] = min(squares[at], flat + dz * dz)
    return np.sqrt(squares).reshape(counts)
