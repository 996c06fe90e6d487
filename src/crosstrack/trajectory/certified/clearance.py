"""Certified least clearance of a curve from the obstacles of a map.

The true distance changes no faster than the point moves. So on a part of a curve whose control points lie within r of
its middle point c it is at least distance(c) - r. Parts that may hold less than the least distance found, less the
tolerance, are halved, all at once in a sweep.
"""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Map
from crosstrack.trajectory.certified.bernstein import DEEPEST, basis, control_points, divide
from crosstrack.trajectory.certified.extremes import parts
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TOLERANCE = 0.01
"""m"""
MOST = 400_000
"""parts that are looked at, at most"""


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """The least distance to an obstacle along a curve, enclosed: it lies between `value` and `attained`."""

    value: float
    """m, certified: the curve comes no closer; inf without any obstacle"""
    attained: float
    """m, what the map says at `time`"""
    time: float
    """s, on the curve"""
    position: Array
    """(dimensions,) m, where that is"""
    piece: int
    """index of the piece where it is attained"""


def least_clearance(
    curve: PiecewisePolynomial, world: Map, *, tolerance: float = TOLERANCE, optimism: float = 0.0, most: int = MOST
) -> Clearance:
    """Enclose the least distance to an obstacle over time.

    Assumes that the true distance is 1-Lipschitz, as every distance is, and that the map never exceeds it by more than
    `optimism`. A part of radius r is halved only if r > tolerance, so that about 2 Σ rᵢ / tolerance parts are looked at
    for pieces of radius rᵢ along a wall, and far fewer elsewhere. After `most` of them the bound is given as it then
    is: `attained` - `value` is its true gap, which is at most `tolerance` + `optimism` otherwise.

    Args:
        curve: of any degree, (x, y, z)
        world: what is in the way
        tolerance: m
        optimism: m, by which the map's distance may exceed the true one
        most: parts looked at
    """
    count, dimensions = len(curve.durations), curve.coefficients.shape[2]
    origin = curve.coefficients[0, 0]
    points = np.empty((count, dimensions, curve.degree + 1))
    error = pieces_points(*parts(curve), origin, basis(curve.degree), points)
    index, start, depth, seen = np.arange(count), np.zeros(count), 0, 0
    retired, found = np.inf, (np.inf, 0, 0.0, origin)
    while len(index):
        seen += len(index)
        middles, radii = np.empty((len(index), dimensions)), np.empty(len(index))
        halves = np.empty((2, *points.shape))
        split(points, halves, middles, radii)
        distances = world.distance(middles + origin)
        width = 0.5**depth
        least = int(np.argmin(distances))
        if distances[least] < found[0] or depth == 0:
            time = start[least] + 0.5 * width
            found = (float(distances[least]), int(index[least]), float(time), middles[least] + origin)
        bounds = distances - radii
        again = bounds < found[0] - tolerance
        last = seen + 2 * np.count_nonzero(again) > most or depth == DEEPEST
        retired = min(retired, float(np.min(bounds if last else bounds[~again], initial=np.inf)))
        if last:
            break
        points = np.concatenate(halves[:, again])
        start = np.concatenate([start[again], start[again] + 0.5 * width])
        index, depth = np.tile(index[again], 2), depth + 1
    attained, piece, unit, position = found
    time = float(curve.knots[piece] + unit * curve.durations[piece])
    return Clearance(min(retired, attained) - error - optimism, attained, time, position, piece)


@compiled
def pieces_points(durations: Array, coefficients: Array, origin: Array, basis: Array, out: Array) -> float:
    """Fill `out` (pieces, dimensions, terms) with the control points relative to `origin`, m; return their error, m."""
    points = np.empty((out.shape[2], out.shape[1]))
    axes = np.arange(out.shape[1])
    error: float = 0.0
    for i in range(durations.size):
        error = max(error, control_points(coefficients[i], durations[i], 0, origin, axes, basis, points))
        for d in range(out.shape[1]):
            for j in range(out.shape[2]):
                out[i, d, j] = points[j, d]
    return error * (1.0 + 0.125 * DEEPEST)  # halving rounds too


@compiled
def split(points: Array, halves: Array, middles: Array, radii: Array) -> None:
    """Halve curves with control points (n, dimensions, terms).

    Args:
        points: (n, dimensions, terms) m
        halves: (2, n, dimensions, terms) m, filled with the control points of both halves
        middles: (n, dimensions) m, filled with the point between them
        radii: (n,) m, filled with the radius around it that holds the curve
    """
    count, dimensions, terms = points.shape
    for i in range(count):
        for d in range(dimensions):
            for j in range(terms):
                halves[0, i, d, j] = points[i, d, j]
            divide(halves[0, i, d], halves[1, i, d], terms, 0.5)
            middles[i, d] = halves[1, i, d, 0]
        most = 0.0
        for side in range(2):
            for j in range(terms):
                square = 0.0
                for d in range(dimensions):
                    square += (halves[side, i, d, j] - middles[i, d]) ** 2
                most = max(most, square)
        radii[i] = math.sqrt(most)
