"""Barriers: how fast a vehicle may approach what it must not reach, and the nearest command that none forbids.

A double integrator dq/dt = w, dw/dt = u that brakes by u = -min(b, k |w|) from the speed w comes to rest within

    w/k  where w <= b/k,      w²/(2 b) + b/(2 k²)  beyond.

Solved for the speed, that is the greatest approach W(d) with the room d. Commands that keep h = n·w + W(d) >= 0 are

    dh/dt = n·u + W'(d) n·w >= -α h

(a control barrier function, Ames et al. 2017): a half-space for each obstacle. The one nearest to what was asked for is
a projection onto their intersection, here by the method of Hildreth (1957): one multiplier after the other.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

SWEEPS = 1000
"""over all half-spaces"""


@compiled
def least_acceleration(room: float, speed: float, deceleration: float, gain: float) -> float:
    """Return the least acceleration n·u (m/s²) away from an obstacle: -α h - W'(d) n·w.

    Args:
        room: m, d, below zero where the vehicle is too close
        speed: m/s, n·w: away from the obstacle, relative to it
        deceleration: m/s², b
        gain: 1/s, k, which is α too
    """
    end = deceleration / (gain * gain)
    if room <= end:
        return -gain * (2.0 * speed + gain * room)
    most = math.sqrt(2.0 * deceleration * (room - 0.5 * end))
    return -gain * (speed + most) - deceleration / most * speed


@compiled
def nearest(asked: Array, normals: Array, least: Array) -> Array:
    """Return the vector nearest to the one asked for with normals · u >= least.

    Where nothing satisfies them all, some vector is returned, which violates some.

    Args:
        asked: (3,)
        normals: (n, 3) unit vectors
        least: (n,)
    """
    u = asked.copy()
    multipliers = np.zeros(len(least))
    for _ in range(SWEEPS):
        moved = 0.0
        for i in range(len(least)):
            short = least[i] - (normals[i, 0] * u[0] + normals[i, 1] * u[1] + normals[i, 2] * u[2])
            more = max(-multipliers[i], short)
            multipliers[i] += more
            for k in range(3):
                u[k] += more * normals[i, k]
            moved = max(moved, abs(more))
        if moved < 1e-9:
            break
    return u
