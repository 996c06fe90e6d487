"""Curves made of polynomials, by time."""

from dataclasses import dataclass
from functools import cached_property
from math import perm

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.errors import InputError, Problem
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class PiecewisePolynomial:
    """A curve over time: piece i is p(t) = Σ c_k u^k with the local time u = t - (durations before it)."""

    durations: Array
    """(pieces,) s, positive"""
    coefficients: Array
    """(pieces, degree + 1, dimensions), ascending powers of local time"""

    @cached_property
    def knots(self) -> Array:
        """(pieces + 1,) s, when each piece starts, and the whole duration"""
        return np.concatenate([[0.0], np.cumsum(self.durations)])

    @property
    def duration(self) -> float:
        """s"""
        return float(self.knots[-1])

    @property
    def degree(self) -> int:
        """Of every piece."""
        return int(self.coefficients.shape[1]) - 1

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate the derivative of an order at the time `t` (s, shape (...)), 0 at the start of the first piece.

        Returns:
            shape (..., dimensions). Outside [0, duration] the ends answer; at a knot the later piece does.

        Raises:
            InputError: the order is negative.
        """
        if order < 0:
            raise InputError("curve", [Problem("order", f"must be 0 or more, found {order}")])
        t = np.asarray(t, float)
        out = np.empty((t.size, self.coefficients.shape[2]))
        evaluate(t.ravel(), order, self.knots, self.coefficients, out)
        return out.reshape((*t.shape, out.shape[1]))

    def derivative(self, order: int = 1) -> "PiecewisePolynomial":
        """Return the derivative of an order, a curve of lower degree; zero has degree 0."""
        powers = np.arange(order, self.degree + 1)
        factors = np.array([perm(int(power), order) for power in powers], float)
        falling = self.coefficients[:, order:] * factors[:, None]
        if not len(powers):
            falling = np.zeros_like(self.coefficients[:, :1])
        return PiecewisePolynomial(self.durations, falling)

    def cost(self, derivative: int) -> float:
        """Return ∫ ‖p⁽ᵏ⁾‖² dt over the whole duration for the derivative k."""
        of = self.derivative(derivative)
        powers = np.arange(of.degree + 1)
        scaled = of.coefficients * self.durations[:, None, None] ** powers[:, None]
        inner = 1.0 / (powers[:, None] + powers + 1)  # ∫ u^j u^k over [0, 1]
        return float(np.einsum("i,ijd,jk,ikd->", self.durations, scaled, inner, scaled))


@compiled
def evaluate(t: Array, order: int, knots: Array, coefficients: Array, out: Array) -> None:
    """Fill `out` (n, dimensions) with the derivative of an order at the times `t` (n,), by Horner's rule."""
    pieces, terms, dimensions = coefficients.shape
    for i in range(t.size):
        k = min(max(int(np.searchsorted(knots, t[i], side="right")) - 1, 0), pieces - 1)
        u = min(max(t[i], 0.0), knots[-1]) - knots[k]
        for d in range(dimensions):
            out[i, d] = 0.0
        for power in range(terms - 1, order - 1, -1):
            factor = 1.0
            for j in range(order):
                factor *= power - j
            for d in range(dimensions):
                out[i, d] = out[i, d] * u + factor * coefficients[k, power, d]
