"""How a vehicle comes to rest: its motion under a command, then under an escape, as a chain of short segments.

With the velocity w that it is bound for (see `safety_motion`), braking asks for

    u = -w/|w| min(b, k |w|),

the greatest deceleration b that is counted on, and in proportion at the end; since dw/dt = u it does not overshoot.
An escape from an obstacle with the normal n (away from it) asks for b along n, or between n and braking, until
n·w >= 0, and brakes then.
"""

import math
from typing import NamedTuple

import numpy as np

from crosstrack.avoid.safety_motion import STEP, Ability, Motion, bound_for, move, strength
from crosstrack.compiled import compiled
from crosstrack.types import Array

LONGEST = 1.0
"""m, of a segment"""
SHORTEST = 0.02
"""m, of a segment that ends because the motion turns"""
TURN = math.cos(math.radians(4.0))
"""cosine of the most that the motion may turn within a segment"""
MOST = 128
"""segments"""
LONGEST_TIME = 20.0
"""s, after which what does not rest is taken never to"""
REST = 0.02
"""m/s, speed below which a vehicle rests but for the last millimetres, which are added"""


class Escape(NamedTuple):
    """How to come to rest."""

    normal: Array
    """(3,) unit vector away from what is in the way, where it turns away first; zero where it brakes at once"""
    blend: float
    """how much it brakes while it turns away"""


class Stop(NamedTuple):
    """A way to rest."""

    points: Array
    """(n, 3) m, ends of its segments, the first here"""
    times: Array
    """(n,) s, from now"""
    rests: bool
    """whether it ends at rest"""
    length: float
    """m"""
    asked: Array
    """(3,) m/s², acceleration to ask for first"""
    velocity: Array
    """(3,) m/s, velocity a period from now"""


@compiled
def brake(w: Array, able: Ability, out: Array) -> None:
    """Put the acceleration (3,) m/s² that brakes a velocity bound for (3,) m/s into an array."""
    size = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    scale = 0.0
    if size > 1e-9:
        scale = -min(strength(w[0] / size, w[1] / size, w[2] / size, able), able.gain * size) / size
    for k in range(3):
        out[k] = scale * w[k]


@compiled
def turn_away(w: Array, normal: Array, blend: float, able: Ability, out: Array) -> None:
    """Put the acceleration (3,) m/s² of an escape at a velocity bound for (3,) m/s into an array."""
    approach = -(normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2])
    size = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if approach <= 1e-2 or size < 1e-2:
        brake(w, able, out)
        return
    # Of all accelerations in the ellipsoid this direction has the most along the normal.
    x, y, z = able.sideways**2 * normal[0], able.sideways**2 * normal[1], able.vertical**2 * normal[2]
    norm = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / norm - blend * w[0] / size, y / norm - blend * w[1] / size, z / norm - blend * w[2] / size
    norm = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / norm, y / norm, z / norm
    along = max(1e-3, x * normal[0] + y * normal[1] + z * normal[2])
    # The end is proportional too, so that the turn does not overshoot.
    scale = min(strength(x, y, z, able), able.gain * approach / along)
    out[0], out[1], out[2] = scale * x, scale * y, scale * z


@compiled
def stopping(
    begun: Motion, command: Array, hold: float, normal: Array, blend: float, able: Ability
) -> tuple[Array, Array, bool, float, Array, Array]:
    """Return the way to rest, as the fields of `Stop`: a command first, then an escape.

    Args:
        begun: motion now
        command: (3,) m/s², acceleration that the command asks for; NaN where the escape begins at once
        hold: s, how long the command is held: a period
        normal: (3,) of the escape
        blend: of the escape
        able: what it brakes with
    """
    motion = begun.copy()
    points, moments = np.empty((MOST + 1, 3)), np.empty(MOST + 1)
    asked, after, facing = np.zeros(3), motion[1].copy(), motion[1].copy()
    u, q, w = np.zeros(3), np.empty(3), np.empty(3)
    points[0], moments[0] = motion[0], 0.0
    turns = normal[0] != 0.0 or normal[1] != 0.0 or normal[2] != 0.0
    parts = max(1, math.ceil(hold / STEP - 1e-9))
    holding = 0 if math.isnan(command[0]) else parts
    h = hold / parts
    count, k, length, rests = 1, 0, 0.0, False
    while k * h < LONGEST_TIME and count < MOST:
        bound_for(motion, able, q, w)
        v = motion[1]
        if k >= holding:
            if k >= parts and w[0] * w[0] + w[1] * w[1] + w[2] * w[2] < REST * REST:
                rests = True
                break
            if turns:
                turn_away(w, normal, blend, able, u)
            else:
                brake(w, able, u)
        else:
            u[0], u[1], u[2] = command[0], command[1], command[2]
        if k == 0:
            asked[0], asked[1], asked[2] = u[0], u[1], u[2]
        move(motion, u, h, able)
        k += 1
        if k == parts:
            after[0], after[1], after[2] = v[0], v[1], v[2]
        gone = apart(points[count - 1], motion[0])
        if gone >= LONGEST or (gone >= SHORTEST and bent(facing, v)):
            points[count], moments[count] = motion[0], k * h
            facing[0], facing[1], facing[2] = v[0], v[1], v[2]
            length += gone
            count += 1
    bound_for(motion, able, q, w)
    for i in range(3):
        points[count, i] = q[i] + w[i] / able.gain
    moments[count] = k * h
    length += apart(points[count - 1], points[count])
    return points[: count + 1], moments[: count + 1], rests, length, asked, after


@compiled
def apart(a: Array, b: Array) -> float:
    """Return the distance between two points (3,) m."""
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@compiled
def bent(a: Array, b: Array) -> bool:
    """Return whether two velocities (3,) m/s differ in direction by more than a segment may turn."""
    along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    sizes = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2])
    return bool(along < TURN * math.sqrt(sizes))


def way_to_rest(motion: Motion, command: Array, hold: float, escape: Escape, able: Ability) -> Stop:
    """Return the way to rest after a command (3,) m/s² held for a period (s), NaN for none, by an escape."""
    return Stop(*stopping(motion, command, hold, escape.normal, escape.blend, able))
