"""Random curves, and their exact values in fractions, which no rounding can blur."""

from fractions import Fraction
from math import perm

import numpy as np

from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

SHIFTS = (0.0, 5.4e6)
"""m, of all coordinates: at the origin, and in UTM"""


def random_curve(
    seed: int, degree: int = 7, dimensions: int = 3, pieces: int = 4, shift: float = 0.0, spread: float = 6.0
) -> PiecewisePolynomial:
    """Return pieces that move by metres each, with durations over `spread` decades around 1 s."""
    rng = np.random.default_rng(seed)
    durations = 10 ** rng.uniform(-spread / 2, spread / 2, pieces)
    unit = rng.normal(size=(pieces, degree + 1, dimensions)) * 10 ** rng.uniform(-2, 2, (pieces, 1, 1))
    unit[:, 0] += shift
    return PiecewisePolynomial(durations, unit / durations[:, None, None] ** np.arange(degree + 1)[:, None])


def exact(curve: PiecewisePolynomial, piece: int, u: float, order: int = 0) -> list[Fraction]:
    """Return the derivative of an order of a piece at the unit time u, axis by axis."""
    local = Fraction(u) * Fraction(float(curve.durations[piece]))
    return [
        sum(
            (Fraction(float(c)) * perm(k, order) * local ** (k - order) for k, c in enumerate(axis) if k >= order),
            Fraction(0),
        )
        for axis in curve.coefficients[piece].T
    ]


def norm_squared(values: list[Fraction]) -> Fraction:
    """Return the square of the Euclidean norm."""
    return sum((value * value for value in values), Fraction(0))


def gap_squared(point: list[Fraction], start: Array, end: Array) -> Fraction:
    """Return the squared distance of a point from the segment between two others."""
    a = [Fraction(float(x)) for x in start]
    leg = [Fraction(float(x)) - y for x, y in zip(end, a, strict=True)]
    away = [x - y for x, y in zip(point, a, strict=True)]
    length = norm_squared(leg)
    dot = sum((x * y for x, y in zip(away, leg, strict=True)), Fraction(0))
    foot = min(max(dot / length, Fraction(0)), Fraction(1)) if length else Fraction(0)
    return norm_squared([x - foot * y for x, y in zip(away, leg, strict=True)])
