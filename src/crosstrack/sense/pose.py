"""Where a sensor is and which way it looks."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

Triple = tuple[float, float, float]
Turn = tuple[float, float, float, float, float, float, float, float, float]
"""from the body to the world: the matrix of `axes`, row by row"""


@compiled
def axes(attitude: Array) -> Array:
    """Return the matrix (3, 3) that turns vectors of the body into the world, from a unit quaternion xyzw."""
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    out = np.empty((3, 3))
    out[0, 0], out[0, 1], out[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[1, 0], out[1, 1], out[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[2, 0], out[2, 1], out[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    return out


@compiled
def entries(matrix: Array) -> Turn:
    """Return a matrix (3, 3) as numbers, which are quicker to pass on."""
    one = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    return one + (matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[2, 0], matrix[2, 1], matrix[2, 2])


@compiled
def turned_to(turn: Turn, x: float, y: float, z: float) -> Triple:
    """Return a vector of the body in the world."""
    a, b, c, d, e, f, g, h, i = turn
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


@compiled
def turned_back(turn: Turn, x: float, y: float, z: float) -> Triple:
    """Return a vector of the world in the body."""
    a, b, c, d, e, f, g, h, i = turn
    return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


@compiled
def turned_all(turned: Array, directions: Array) -> Array:
    """Return vectors (n, 3) of the body in the world, by the matrix of `axes`."""
    turn, out = entries(turned), np.empty((len(directions), 3))
    for i in range(len(directions)):
        out[i, 0], out[i, 1], out[i, 2] = turned_to(turn, directions[i, 0], directions[i, 1], directions[i, 2])
    return out


@compiled
def hits(ranges: Array, directions: Array, origin: Array, above: float) -> Array:
    """Return where rays hit something above a height, (n, 3) m.

    Args:
        ranges: (rays,) m; inf where nothing was hit, NaN where nothing was measured
        directions: (rays, 3) world
        origin: (3,) m, world
        above: m, -inf for all
    """
    out, count = np.empty((len(ranges), 3)), 0
    for i in range(len(ranges)):
        r = ranges[i]
        if r < math.inf and origin[2] + r * directions[i, 2] > above:
            for k in range(3):
                out[count, k] = origin[k] + r * directions[i, k]
            count += 1
    return out[:count].copy()


def mounting(yaw: float, pitch: float) -> Array:
    """Return the matrix (3, 3) that turns vectors of a sensor into the body: pitched (rad, nose down), then yawed."""
    a, b, c, d = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([[a * c, -b, a * d], [b * c, a, b * d], [-d, 0.0, c]])
