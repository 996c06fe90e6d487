"""Certified extremes of piecewise polynomials: proven for every instant, not for samples.

Every piece becomes a polynomial on unit time in Bernstein form, and `peak.peak` encloses its maximum.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.certified.bernstein import (
    DEEPEST,
    EPSILON,
    Indices,
    basis,
    control_points,
    products,
    squared,
)
from crosstrack.trajectory.certified.peak import peak
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TOLERANCE = 1e-9
"""of the extreme itself, or of the largest coefficient where the extreme may be zero"""


@dataclass(frozen=True, slots=True)
class Extreme:
    """The extreme of one quantity along a curve, enclosed: it lies between `attained` and `value`."""

    value: float
    """certified bound that nothing passes"""
    attained: float
    """what the curve reaches at `time`, to rounding"""
    time: float
    """s, on the curve"""
    piece: int
    """index of the piece where it is attained"""


@dataclass(frozen=True, slots=True, eq=False)
class Peaks:
    """The maximum of one quantity on each of several pieces, enclosed."""

    bound: Array
    """(n,) certified: nothing is above"""
    attained: Array
    """(n,) what the curve reaches at `time`, to rounding"""
    time: Array
    """(n,) s, on the curve"""
    piece: Indices
    """(n,) int, index of the piece"""

    def largest(self) -> Extreme:
        """Return the maximum over all of them."""
        at = int(np.argmax(self.attained))
        return Extreme(float(self.bound.max()), float(self.attained[at]), float(self.time[at]), int(self.piece[at]))


@dataclass(frozen=True, slots=True)
class Range:
    """Least and greatest value of one axis; the value of `least` is a lower bound."""

    least: Extreme
    greatest: Extreme


def norm_peaks(
    curve: PiecewisePolynomial, order: int = 0, axes: Sequence[int] | None = None, *, tolerance: float = TOLERANCE
) -> Peaks:
    """Enclose the maximum on every piece of the Euclidean norm of the derivative of an order.

    Args:
        curve: of any degree and dimension
        order: 0 is the position itself
        axes: to take the norm over, all by default; [0, 1] is horizontal
        tolerance: of the maximum, relative
    """
    chosen = np.arange(curve.coefficients.shape[2]) if axes is None else np.asarray(axes, np.int64)
    degree = max(curve.degree - order, 0)
    out = np.empty((len(curve.durations), 3))
    norms(*parts(curve), order, chosen, basis(degree), products(degree), 2.0 * tolerance, out)
    return peaks(curve, out)


def largest_norm(
    curve: PiecewisePolynomial, order: int = 0, axes: Sequence[int] | None = None, *, tolerance: float = TOLERANCE
) -> Extreme:
    """Enclose the maximum over time of the Euclidean norm of the derivative of an order, see `norm_peaks`.

    Raises:
        InputError: the order is below 0, or the curve has no such axis.
    """
    check("largest_norm", curve, order, axes)
    return norm_peaks(curve, order, axes, tolerance=tolerance).largest()


def halfspace_peaks(
    curve: PiecewisePolynomial,
    order: int,
    pieces: Indices,
    normals: Array,
    offsets: Array,
    *,
    tolerance: float = TOLERANCE,
) -> Peaks:
    """Enclose the maximum of n·p⁽ᵏ⁾(t) - b on the piece that each half-space n·x <= b is for: positive is outside.

    Args:
        curve: of any degree and dimension
        order: k, of the derivative
        pieces: (n,) int, index of the piece of each half-space; one piece may have many
        normals: (n, dimensions)
        offsets: (n,)
        tolerance: of the largest |Bernstein coefficient| of n·p⁽ᵏ⁾ - b
    """
    pieces = np.asarray(pieces, np.int64)
    out = np.empty((len(pieces), 3))
    degree = max(curve.degree - order, 0)
    rows = np.ascontiguousarray(normals, float), np.ascontiguousarray(offsets, float)
    outsides(*parts(curve), order, pieces, *rows, basis(degree), tolerance, out)
    return peaks(curve, out, pieces)


def axis_range(curve: PiecewisePolynomial, order: int = 0, *, tolerance: float = TOLERANCE) -> list[Range]:
    """Enclose the least and the greatest value over time of each axis of the derivative of an order.

    Args:
        curve: of any degree and dimension
        order: 0 is the position itself
        tolerance: of the largest |Bernstein coefficient|, the position taken from the start of the curve

    Raises:
        InputError: the order is below 0.
    """
    check("axis_range", curve, order, None)
    count, dimensions = len(curve.durations), curve.coefficients.shape[2]
    sides = np.concatenate([np.eye(dimensions), -np.eye(dimensions)])
    levels = sides @ curve.coefficients[0, 0] if order == 0 else np.zeros(2 * dimensions)
    pieces = np.tile(np.arange(count), 2 * dimensions)
    rows = np.repeat(sides, count, axis=0), np.repeat(levels, count)
    found = halfspace_peaks(curve, order, pieces, *rows, tolerance=tolerance)
    tops = []
    for i, level in enumerate(levels):
        own = slice(i * count, (i + 1) * count)
        top = Peaks(found.bound[own], found.attained[own], found.time[own], found.piece[own]).largest()
        tops.append(raised(top, float(level)))
    return [
        Range(Extreme(-low.value, -low.attained, low.time, low.piece), high)
        for high, low in zip(tops[:dimensions], tops[dimensions:], strict=True)
    ]


def check(source: str, curve: PiecewisePolynomial, order: int, axes: Sequence[int] | None) -> None:
    """Raise InputError for a derivative or axes that a curve does not have."""
    dimensions, found = curve.coefficients.shape[2], []
    if not isinstance(order, int | np.integer) or order < 0:
        found.append(Problem("order", f"must be 0 or more, found {order!r:.60}"))
    if axes is not None and not (len(axes) and all(axis in range(dimensions) for axis in axes)):
        found.append(Problem("axes", f"must be from 0 to {dimensions - 1}, one at least, found {axes!r:.60}"))
    if found:
        raise InputError(source, found)


def raised(top: Extreme, level: float) -> Extreme:
    """Return an extreme with a level added to it, and what that rounds away to its bound."""
    value = top.value + level
    return Extreme(value + EPSILON * abs(value), top.attained + level, top.time, top.piece)


def parts(curve: PiecewisePolynomial) -> tuple[Array, Array]:
    """Return durations and coefficients as the kernels take them."""
    return np.ascontiguousarray(curve.durations, float), np.ascontiguousarray(curve.coefficients, float)


def peaks(curve: PiecewisePolynomial, out: Array, piece: Indices | None = None) -> Peaks:
    """Return rows of (bound, attained, unit time) as `Peaks` on the curve's own time."""
    index = np.arange(len(out)) if piece is None else piece
    time = curve.knots[index]
    time += out[:, 2] * curve.durations[index]
    return Peaks(out[:, 0], out[:, 1], np.minimum(time, curve.knots[index + 1], out=time), index)


@compiled
def norms(
    durations: Array,
    coefficients: Array,
    order: int,
    axes: Indices,
    basis: Array,
    products: Array,
    relative: float,
    out: Array,
) -> None:
    """Fill `out` (pieces, 3) with bound, attained value and unit time of the maximum of ‖p⁽ᵏ⁾‖ over some axes.

    Args:
        durations: (pieces,) s
        coefficients: (pieces, degree + 1, dimensions)
        order: k
        axes: (chosen,) int
        basis: of the derivative's degree
        products: of the derivative's degree
        relative: tolerance of the square
        out: (pieces, 3)
    """
    terms = basis.shape[0]
    points = np.empty((terms, axes.size))
    square = np.empty(2 * terms - 1)
    stack = np.empty((DEEPEST + 2, 2 * terms + 1))
    origin = np.zeros(coefficients.shape[2])
    for i in range(durations.size):
        error = control_points(coefficients[i], durations[i], order, origin, axes, basis, points)
        squared(points, products, square)
        high, low, u = peak(square, 0.0, 0.0, relative, stack)
        out[i, 0] = np.sqrt(max(high, 0.0)) * (1.0 + 2.0 * EPSILON) + error
        out[i, 1] = np.sqrt(max(low, 0.0))
        out[i, 2] = u


@compiled
def outsides(
    durations: Array,
    coefficients: Array,
    order: int,
    pieces: Indices,
    normals: Array,
    offsets: Array,
    basis: Array,
    tolerance: float,
    out: Array,
) -> None:
    """Fill `out` (n, 3) with bound, attained value and unit time of the maximum of n·p⁽ᵏ⁾ - b on a piece.

    Shapes as in `norms` and `halfspace_peaks`. The position is taken from the start of its piece.
    """
    terms, dimensions = basis.shape[0], coefficients.shape[2]
    points = np.empty((terms, dimensions))
    control = np.empty(terms)
    stack = np.empty((DEEPEST + 2, terms + 2))
    origin = np.zeros(dimensions)
    axes = np.arange(dimensions)
    for row in range(pieces.size):
        i = pieces[row]
        level, size, error = -offsets[row], 0.0, abs(offsets[row])
        for d in range(dimensions):
            if order == 0:
                origin[d] = coefficients[i, 0, d]
            level += normals[row, d] * origin[d]
            size += abs(normals[row, d])
            error += abs(normals[row, d] * origin[d])
        error *= EPSILON * (dimensions + 2)
        error += size * control_points(coefficients[i], durations[i], order, origin, axes, basis, points)
        scale = 0.0
        for j in range(terms):
            control[j] = level
            for d in range(dimensions):
                control[j] += normals[row, d] * points[j, d]
            scale = max(scale, abs(control[j]))
        high, low, u = peak(control, -np.inf, tolerance * scale, 0.0, stack)
        out[row, 0] = high + error + EPSILON * (dimensions + 2) * scale
        out[row, 1] = low
        out[row, 2] = u
