"""Distances known at the corners of a grid's cells, at any point between and beyond them.

Between the corners they are interpolated. Beyond the grid the point is clamped to the grid's surface, at a
distance o: no obstacle is nearer than √(o² + v²) with v the value there, because the angle at the clamped
point is at least a right one; nor nearer than the box around the obstacles. The larger of the two is taken.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.solids import Flat, Sample, extruded, rectangle


@compiled
def bilinear(values: Array, first: int, ny: int, i: int, j: int, u: float, v: float) -> Flat:
    """Interpolate in cell (i, j) at (u, v) in [0, 1]²: value and its gradient per cell."""
    at = first + i * ny + j
    a, b, c, d = values[at], values[at + 1], values[at + ny], values[at + ny + 1]
    low, high = a + (b - a) * v, c + (d - c) * v
    return low + (high - low) * u, high - low, (b - a) * (1.0 - u) + (d - c) * u


@compiled
def cell(x: float, count: int) -> tuple[int, float, float]:
    """Return the cell of a lattice coordinate, where in it (0 to 1), and how far beyond the lattice."""
    inside = min(max(x, 0.0), count - 1.0)
    i = min(int(inside), count - 2)
    return i, inside - i, x - inside


@compiled
def relief(x: float, y: float, numbers: Array, box: Array, values: Array) -> Flat:
    """Return the distance from a plane point to the obstacles of a plane grid, and its gradient.

    Args:
        x: m
        y: m
        numbers: first value, corners along x and y, cell (m), origin (x, y) (m), heights
        box: around the obstacles
        values: (corners) m, row-major
    """
    first, nx, ny, size = int(numbers[0]), int(numbers[1]), int(numbers[2]), numbers[3]
    i, u, ox = cell((x - numbers[4]) / size, nx)
    j, v, oy = cell((y - numbers[5]) / size, ny)
    d, gx, gy = bilinear(values, first, ny, i, j, u, v)
    ox, oy = ox * size, oy * size
    beyond = ox * ox + oy * oy
    if beyond == 0.0:
        return d, gx / size, gy / size
    far = math.sqrt(beyond + d * d)
    outside = rectangle(x, y, box[0], box[1], box[3], box[4])
    if outside[0] >= far:
        return outside
    gx = ox if ox != 0.0 else gx / size * d
    gy = oy if oy != 0.0 else gy / size * d
    return far, gx / far, gy / far


@compiled
def voxels(x: float, y: float, z: float, numbers: Array, box: Array, values: Array) -> Sample:
    """Return the distance from a point to the obstacles of a grid in space, and its gradient.

    Args:
        x: m
        y: m
        z: m
        numbers: first value, corners along x, y and z, cell (m), origin (x, y, z) (m)
        box: around the obstacles
        values: (corners) m, row-major
    """
    first, nx, ny, nz, size = int(numbers[0]), int(numbers[1]), int(numbers[2]), int(numbers[3]), numbers[4]
    i, u, ox = cell((x - numbers[5]) / size, nx)
    j, v, oy = cell((y - numbers[6]) / size, ny)
    k, w, oz = cell((z - numbers[7]) / size, nz)
    low = bilinear(values, first + i * ny * nz, nz, j, k, v, w)
    high = bilinear(values, first + (i + 1) * ny * nz, nz, j, k, v, w)
    d, gx = low[0] + (high[0] - low[0]) * u, high[0] - low[0]
    gy, gz = low[1] + (high[1] - low[1]) * u, low[2] + (high[2] - low[2]) * u
    ox, oy, oz = ox * size, oy * size, oz * size
    beyond = ox * ox + oy * oy + oz * oz
    if beyond == 0.0:
        return d, gx / size, gy / size, gz / size
    far = math.sqrt(beyond + d * d)
    outside = extruded(rectangle(x, y, box[0], box[1], box[3], box[4]), z, box[2], box[5])
    if outside[0] >= far:
        return outside
    gx = ox if ox != 0.0 else gx / size * d
    gy = oy if oy != 0.0 else gy / size * d
    gz = oz if oz != 0.0 else gz / size * d
    return far, gx / far, gy / far, gz / far
