"""A trajectory by its values and derivatives at the knots, in units that make them alike: costs, shapes, curves.

The unknowns are y_ik = h_i^k p⁽ᵏ⁾(t_i), k < s, with the position relative to the waypoint and h_i the mean duration of
the segments at the knot.
"""

from dataclasses import dataclass
from functools import cached_property
from math import factorial, perm

import numpy as np

from crosstrack.trajectory import hermite
from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.constrained.cones import Flags, Indices
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Spans:
    """Conditions, seen as a chain of segments between free knots."""

    asked: Conditions
    free: Flags
    """(N + 1,) bool, knots whose position is free"""

    @property
    def order(self) -> int:
        """The derivative s that is minimised."""
        return self.asked.order

    @cached_property
    def fixed(self) -> Flags:
        """(N + 1, s, d) bool, unknowns that are given"""
        fixed = ~np.isnan(self.asked.knots)
        fixed[self.free, 0] = False
        return fixed

    @cached_property
    def units(self) -> Array:
        """(N + 1, s) h_i^k"""
        log = np.log(self.asked.durations)
        mean = np.exp(0.5 * (np.concatenate([log[:1], log]) + np.concatenate([log, log[-1:]])))
        powers: Array = mean[:, None] ** np.arange(self.order)
        return powers

    @cached_property
    def ratios(self) -> Array:
        """(N, 2 s) of the ends z of a segment, see `hermite`, to the unknowns at its knots"""
        powers = self.asked.durations[:, None] ** np.arange(self.order)
        return np.concatenate([powers / self.units[:-1], powers / self.units[1:]], axis=1)

    @cached_property
    def steps(self) -> Array:
        """(N, d) m, from waypoint to waypoint"""
        return np.diff(self.asked.knots[:, 0], axis=0)

    @cached_property
    def forms(self) -> Array:
        """(N, 2 s, 2 s), the quadratic part of half the cost is ½ yᵀ M y"""
        s, durations, ratios = self.order, self.asked.durations, self.ratios
        total = durations[:, None, None] ** (1 - 2 * s) * hermite.gram(s, s)
        for order in range(GUIDES) if self.asked.weights.size else ():
            weight = self.asked.weights[:, order] * durations ** (1 - 2 * order)
            total = total + weight[:, None, None] * hermite.gram(s, order)
        return total * ratios[:, :, None] * ratios[:, None, :]

    def ends(self, y: Array) -> Array:
        """Return the ends z (N, 2 s, d) of every segment relative to its first waypoint."""
        z = np.concatenate([y[:-1], y[1:]], axis=1) * self.ratios[:, :, None]
        z[:, self.order] += self.steps
        return z

    def slope(self, y: Array) -> Array:
        """Return the gradient (N + 1, s, d) of half the cost at y."""
        s, ratios = self.order, self.ratios[:, :, None]
        pushed = (self.forms / ratios / ratios.transpose(0, 2, 1)) @ self.ends(y)
        if self.asked.loads.shape[0]:
            pushed = pushed - self.asked.loads
        pushed = pushed * ratios
        total = np.zeros_like(y)
        total[:-1] += pushed[:, :s]
        total[1:] += pushed[:, s:]
        return total

    def shapes(self, piece: Indices, order: int, tau: Array) -> Array:
        """Return φ (n, 2 s) of a derivative at unit times of pieces, by the unknowns at their knots."""
        values = hermite.values(self.order, order, tau) / self.asked.durations[piece, None] ** order
        return np.asarray(values * self.ratios[piece])

    def values(self, y: Array, piece: Indices, order: int, tau: Array) -> Array:
        """Return a derivative (n, d) at unit times of pieces, positions relative to the first waypoint."""
        z = self.ends(y)[piece]
        basis = hermite.values(self.order, order, tau) / self.asked.durations[piece, None] ** order
        found: Array = np.einsum("nk,nkd->nd", basis, z)
        return found + self.asked.knots[piece, 0] if order == 0 else found

    def unknowns(self, curve: PiecewisePolynomial) -> Array:
        """Return the unknowns (N + 1, s, d) of a curve relative to the first waypoint."""
        s = self.order
        last = curve.durations[-1] ** np.arange(2 * s)
        rows = [[perm(n, k) * last[n - k] if n >= k else 0.0 for n in range(2 * s)] for k in range(s)]
        starts = curve.coefficients[:, :s] * np.array([factorial(k) for k in range(s)])[:, None]
        y = np.concatenate([starts, (np.array(rows) @ curve.coefficients[-1])[None]])
        y[:, 0] -= self.asked.knots[:, 0]
        return np.asarray(np.where(self.fixed, self.given, y * self.units[:, :, None]))

    @cached_property
    def given(self) -> Array:
        """(N + 1, s, d) unknowns that are fixed; others are zero"""
        y = np.where(self.fixed, self.asked.knots, 0.0) * self.units[:, :, None]
        y[:, 0] = 0.0
        return y

    def curve(self, y: Array) -> PiecewisePolynomial:
        """Return the curve, with positions relative to the first waypoint."""
        s, durations = self.order, self.asked.durations
        z = self.ends(y)
        start = z[:, 0].copy()
        z[:, s] -= start
        z[:, 0] = 0.0
        coefficients = hermite.coefficients(s) @ z / durations[:, None, None] ** np.arange(2 * s)[:, None]
        coefficients[:, 0] = self.asked.knots[:-1, 0] + start
        return PiecewisePolynomial(durations, coefficients)
