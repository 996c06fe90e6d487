"""Turning forces along obstacles, and going on along them: the geometry of the ways out of a local minimum."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.vectors import across, direction, dot, norm

HEAD_ON = 0.1
"""sine of the angle between the attraction and the way to an obstacle, under which neither side is nearer"""
BLOCKS = -0.5
"""cosine between the way along an obstacle and the direction away from another that is in the way"""


@compiled
def continued(axis: Array, foot: Array, position: Array, gaps: Array, away: Array, narrow: float) -> int:
    """Return which of the obstacles near is the one followed: that at `foot`, or what blocks the way along it.

    Args:
        axis: (3,) that is gone around
        foot: (3,) m, point of the obstacle that was followed last
        position: (3,) m
        gaps: (n,) m
        away: (n, 3)
        narrow: m, gap to what blocks the way
    """
    index, least = 0, math.inf
    for i in range(len(gaps)):
        square = 0.0
        for k in range(3):
            square += (position[k] - gaps[i] * away[i, k] - foot[k]) ** 2
        if square < least:
            index, least = i, square
    for _turn in range(len(gaps)):
        along = cross(axis, away[index])
        ahead, worst = index, 0.0
        for i in range(len(gaps)):
            if i != index and gaps[i] < narrow and dot(along, away[i]) < min(worst, BLOCKS):
                ahead, worst = i, dot(along, away[i])
        if ahead == index:
            break
        index = ahead
    return index


@compiled
def cross(a: Array, b: Array) -> Array:
    """Return the vector product."""
    out = np.empty(3)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k] = a[i] * b[j] - a[j] * b[i]
    return out


@compiled
def rotated(vector: Array, axis: Array, angle: float) -> Array:
    """Return a vector (3,) turned by an angle (rad) about a unit axis (3,), counter-clockwise (Rodrigues)."""
    cosine, sine = math.cos(angle), math.sin(angle)
    along = dot(axis, vector) * (1.0 - cosine)
    side, out = cross(axis, vector), np.empty(3)
    for k in range(3):
        out[k] = cosine * vector[k] + sine * side[k] + along * axis[k]
    return out


@compiled
def turned(push: Array, away: Array, way: Array, axis: Array, angle: float, chosen: bool) -> Array:
    """Return the repulsion (3,) of one obstacle turned along it.

    Args:
        push: (3,) the repulsion
        away: (3,) unit, from the obstacle
        way: (3,) unit, where the attraction goes
        axis: (3,) unit, to turn about where the side is not chosen, or the attraction leads straight into the obstacle
        angle: rad
        chosen: whether the side is that on which the attraction passes the obstacle
    """
    if not chosen:
        return rotated(push, axis, angle)
    if dot(way, away) >= 0.0:
        return push
    side = across(way, away)
    if norm(side) < HEAD_ON:
        return rotated(push, axis, angle)
    return rotated(push, cross(away, direction(side)), angle)


@compiled
def along(axis: Array, away: Array, gap: float, held: float) -> Array:
    """Return the direction (3,) to follow an obstacle in, about an axis, at a gap to hold (m).

    It is t + n (held - gap)/held, where t = axis x n goes along the obstacle; shortened to 1.
    """
    out = direction(cross(axis, away))
    pull = min(1.0, max(-1.0, (held - gap) / held))
    for k in range(3):
        out[k] += pull * away[k]
    return direction(out)


@compiled
def turned_all(pushes: Array, away: Array, way: Array, axis: Array, angle: float, chosen: bool) -> Array:
    """Return the sum (3,) of repulsions (n, 3), each turned along its obstacle; see `turned`."""
    out = np.zeros(3)
    for i in range(len(pushes)):
        one = turned(pushes[i], away[i], way, axis, angle, chosen)
        for k in range(3):
            out[k] += one[k]
    return out
