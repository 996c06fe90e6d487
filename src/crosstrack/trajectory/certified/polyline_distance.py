"""Certified largest distance of a curve from a polyline.

The distance to a straight leg is convex, so on a part of a curve it is nowhere larger than at the control points of
that part. Parts are divided until that, taken for the legs nearest to their ends, is within the tolerance of the
largest distance found. Where a part lies beside, before or beyond one leg throughout, the square of the distance is a
polynomial, and `peak.peak` finishes at once.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.arguments import as_numbers
from crosstrack.trajectory.certified.bernstein import (
    DEEPEST,
    EPSILON,
    Indices,
    basis,
    control_points,
    differences,
    divide,
    products,
    squared,
)
from crosstrack.trajectory.certified.extremes import Extreme, Peaks, parts, peaks
from crosstrack.trajectory.certified.legs import alongside, closest, hull, prepared
from crosstrack.trajectory.certified.peak import peak
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TOLERANCE = 1e-9
"""m"""
SIDE = 1 / 16
"""least share of a part that is divided"""
WHOLE = -1
"""in place of the index of a leg: the polyline as a whole"""


def deviation_peaks(curve: PiecewisePolynomial, points: Array | None = None, *, tolerance: float = TOLERANCE) -> Peaks:
    """Enclose the largest distance of every piece from its own straight leg, a capsule around it.

    Args:
        curve: of any degree and dimension
        points: (pieces + 1, dimensions) m, leg i is from point i to point i + 1; by default where the knots are, so
            that the legs are the chords
        tolerance: m
    """
    if points is None:
        points = np.concatenate([curve.coefficients[:, 0], curve(curve.duration)[None]])
    return peaks(curve, measured(curve, points, tolerance, True))


def largest_deviation(curve: PiecewisePolynomial, points: Array, *, tolerance: float = TOLERANCE) -> Extreme:
    """Enclose the largest distance over time from the nearest point of a polyline.

    Args:
        curve: of any degree and dimension
        points: (n, dimensions) m, one at least
        tolerance: m

    Raises:
        InputError: the points have another shape than that, or are not finite.
    """
    found = route_faults("points", points, curve.coefficients.shape[2])
    if found:
        raise InputError("largest_deviation", found)
    return peaks(curve, measured(curve, points, tolerance, False)).largest()


def route_faults(name: str, points: Array, dimensions: int) -> list[Problem]:
    """Return what is wrong with the corners of a polyline."""
    corners = as_numbers(points)
    if corners.ndim != 2 or not len(corners) or corners.shape[1] != dimensions:
        found = corners.shape if corners.ndim else f"{points!r:.60}"
        return [Problem(name, f"must have the shape (n, {dimensions}) with n at least 1, found {found}")]
    if not np.isfinite(corners).all():
        return [Problem(name, "must be finite")]
    return []


def measured(curve: PiecewisePolynomial, points: Array, tolerance: float, own: bool) -> Array:
    """Return rows of bound (m), attained value (m) and unit time for every piece."""
    out = np.empty((len(curve.durations), 3))
    corners = np.ascontiguousarray(points, float)
    deviations(*parts(curve), corners, basis(curve.degree), products(curve.degree), tolerance, own, out)
    return out


@compiled
def deviations(
    durations: Array,
    coefficients: Array,
    corners: Array,
    basis: Array,
    products: Array,
    tolerance: float,
    own: bool,
    out: Array,
) -> None:
    """Fill `out` (pieces, 3) with bound, attained value and unit time of the largest distance of every piece.

    Args:
        durations: (pieces,) s
        coefficients: (pieces, degree + 1, dimensions)
        corners: (n, dimensions) m, of the polyline
        basis: of the degree
        products: of the degree
        tolerance: m
        own: whether piece i has leg i alone; else all pieces share the polyline, and where it is shown that the maximum
            over all pieces is not on a piece, that piece is left
        out: (pieces, 3)
    """
    dimensions = coefficients.shape[2]
    axes = np.arange(dimensions)
    points = np.empty((basis.shape[0], dimensions))
    legs, boxes = prepared(corners)
    rounding = 0.0
    for corner in range(corners.shape[0]):
        for d in range(dimensions):
            rounding = max(rounding, 8.0 * EPSILON * abs(corners[corner, d] - corners[0, d]))
    nearest = np.empty((DEEPEST + 2, 2), np.int64)
    nearest[0, 1] = 0
    best = 0.0
    for i in range(durations.size):
        error = control_points(coefficients[i], durations[i], 0, corners[0], axes, basis, points)
        error = error * (1.0 + 0.5 * DEEPEST) + rounding  # dividing rounds too
        high, low, u = np.inf, 0.0, 0.0
        if error < np.inf:
            leg, floor = (i, 0.0) if own else (WHOLE, best)
            high, low, u = farthest(points, leg, legs, boxes, products, floor, max(tolerance, error), nearest)
        best = max(best, low)
        out[i, 0] = high + error
        out[i, 1] = low
        out[i, 2] = u


@compiled
def farthest(
    points: Array,
    own: int,
    legs: Array,
    boxes: Array,
    products: Array,
    floor: float,
    tolerance: float,
    nearest: Indices,
) -> tuple[float, float, float]:
    """Enclose the largest distance (m) of one piece with control points (terms, dimensions).

    Args:
        points: (terms, dimensions) m
        own: index of the leg to measure from, or WHOLE
        legs: see `legs.prepared`
        boxes: see `legs.prepared`
        products: of the degree
        floor: m, see `peak.peak`
        tolerance: m
        nearest: (DEEPEST + 2, 2), to work in; the leg in its first row and last column is tried first, and the leg
            nearest to the end of the piece is left there

    Returns:
        bound, value, u as `peak.peak` returns them
    """
    terms, dimensions = points.shape
    stack, spans = np.empty((DEEPEST + 2, dimensions, terms)), np.empty((DEEPEST + 2, 2))
    offsets, work = np.empty((terms, dimensions)), np.empty((DEEPEST + 3, 2 * terms + 1))
    point = np.empty((dimensions, 1))
    for i in range(terms):
        for d in range(dimensions):
            stack[0, d, i] = points[i, d]
    spans[0, 0], spans[0, 1] = 0.0, 1.0
    nearest[0, 0] = own if own >= 0 else nearest[0, 1]
    nearest[0, 1] = own if own >= 0 else min(nearest[0, 0] + 1, legs.shape[0] - 1)
    low, at, bound = -1.0, 0.0, 0.0  # m, below zero as long as no distance is known
    top, last = 0, nearest[0, 1]
    while top >= 0:
        part, width, best = stack[top], spans[top, 1], max(low, floor)
        reach, leg = np.inf, nearest[top, 0]
        for side in range(1 if leg == nearest[top, 1] else 2):
            most = hull(part, nearest[top, side], legs)
            if most < reach:
                reach, leg = most, nearest[top, side]
        last = leg if low < 0.0 else last
        if low < 0.0 and reach > best + tolerance:
            for side in range(2):
                here(part, float(side), point)
                distance, nearest[0, side] = closest(point, own, leg, legs, boxes)
                if distance > low:
                    low, at = distance, float(side)
            last = nearest[0, 1]
            continue
        u, final = 0.5, width < EPSILON or top == DEEPEST
        if reach > best + tolerance and not final:
            if nearest[top, 0] == nearest[top, 1]:
                crown, u = beside(part, leg, legs, products, best, tolerance, offsets, work)
                reach, u = min(reach, crown), min(max(u, SIDE), 1.0 - SIDE)
            here(part, u, point)
            distance, leg = closest(point, own, leg, legs, boxes)
            if distance > low:
                low, at = distance, spans[top, 0] + u * width
        if final or reach <= max(low, floor) + tolerance:
            bound = max(bound, reach)
            top -= 1
            continue
        for d in range(dimensions):
            divide(part[d], stack[top + 1, d], terms, u)
        spans[top, 1], spans[top + 1, 1] = u * width, (1.0 - u) * width
        spans[top + 1, 0] = spans[top, 0] + u * width
        nearest[top + 1, 1] = nearest[top, 1]
        nearest[top, 1] = nearest[top + 1, 0] = leg
        top += 1
    nearest[0, 1] = last
    return bound, max(low, 0.0), at


@compiled
def beside(
    part: Array,
    leg: int,
    legs: Array,
    products: Array,
    best: float,
    tolerance: float,
    offsets: Array,
    work: Array,
) -> tuple[float, float]:
    """Bound the distance (m) of a part (dimensions, terms) that lies on one side of a leg, by its polynomial.

    Args:
        part: (dimensions, terms) m
        leg: index
        legs: see `legs.prepared`
        products: of the degree
        best: m, what is not above it need not be told apart
        tolerance: m
        offsets: (terms, dimensions), to work in
        work: (DEEPEST + 3, 2 terms + 1), to work in

    Returns:
        bound, and u where the distance is largest; infinite and the middle where the part is not on one side.
    """
    extra = alongside(part, leg, legs, 0.25 * tolerance, offsets)
    if extra < 0.0:
        return np.inf, 0.5
    square = work[0, : 2 * part.shape[1] - 1]
    squared(offsets, products, square)
    slack = 0.5 * tolerance
    high, _, u = peak(square, best * best, slack * (slack + 2.0 * best), 0.0, work[1:])
    return math.sqrt(max(high, 0.0)) + extra, u


@compiled
def here(part: Array, u: float, point: Array) -> None:
    """Fill `point` (dimensions, 1) with the point at u of control points (dimensions, terms)."""
    for d in range(point.shape[0]):
        point[d, 0] = differences(part[d], part.shape[1] - 1, 0, u)
