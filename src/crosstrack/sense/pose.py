"""Where a sensor is and which way it looks."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array


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
def turned_to(turned: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector of the body in the world, by the matrix of `axes`."""
    return (
        turned[0, 0] * x + turned[0, 1] * y + turned[0, 2] * z,
        turned[1, 0] * x + turned[1, 1] * y + turned[1, 2] * z,
        turned[2, 0] * x + turned[2, 1] * y + turned[2, 2] * z,
    )


@compiled
def turned_back(turned: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector of the world in the body, by the matrix of `axes`."""
    return (
        turned[0, 0] * x + turned[1, 0] * y + turned[2, 0] * z,
        turned[0, 1] * x + turned[1, 1] * y + turned[2, 1] * z,
        turned[0, 2] * x + turned[1, 2] * y + turned[2, 2] * z,
    )


def mounting(yaw: float, pitch: float) -> Array:
    """Return the matrix (3, 3) that turns vectors of a sensor into the body: first pitched (rad, nose down), then yawed."""
    a, b, c, d = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([[a * c, -b, a * d], [b * c, a, b * d], [-d, 0.0, c]])
