"""Guides: curves that a trajectory, its velocity or its acceleration is drawn to."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from crosstrack.trajectory import hermite
from crosstrack.trajectory.arguments import as_numbers
from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Guide:
    """Add λ ∫ ‖p⁽ᵏ⁾(t) - g(t)‖² dt to the cost, with the time from the start of the trajectory.

    The velocity or acceleration guide is compared as it is: no constant of integration enters.
    """

    curve: PiecewisePolynomial
    """g: m, m/s or m/s²; with knots of its own, held after its end"""
    weight: float | Array = 1.0
    """λ, or (segments,): m² s to the unit of the cost"""
    order: int = 0
    """k: 0 position, 1 velocity, 2 acceleration"""

    def faults(self, segments: int, dimensions: int) -> list[tuple[str, str]]:
        """Return what is wrong with it for a trajectory, as pairs of a field and a message."""
        found, weight = [], as_numbers(self.weight)
        if not isinstance(self.order, int | np.integer) or self.order not in range(GUIDES):
            found.append(("order", f"must be 0, 1 or 2, found {self.order!r}"))
        if weight.shape not in {(), (segments,)} or not ((weight >= 0) & np.isfinite(weight)).all():
            found.append(("weight", f"must be one or {segments} numbers of 0 or more, found {self.weight!r:.60}"))
        if not isinstance(self.curve, PiecewisePolynomial):
            return [*found, ("curve", f"must be a PiecewisePolynomial, found {self.curve!r:.60}")]
        shape = self.curve.coefficients.shape
        if shape[2] != dimensions:
            found.append(("curve", f"must have {dimensions} dimensions, found {shape[2]}"))
        if not (np.isfinite(self.curve.coefficients).all() and (self.curve.durations > 0).all()):
            found.append(("curve", "must have finite coefficients and positive durations"))
        return found

    def error(self, curve: PiecewisePolynomial) -> float:
        """Return λ ∫ ‖p⁽ᵏ⁾ - g‖² dt over a trajectory."""
        weights = np.broadcast_to(self.weight, curve.durations.shape)
        total = 0.0
        degree = 2 * max(curve.degree - self.order, self.curve.degree)
        for segment, nodes, share in quadrature(curve.knots, self.curve.knots, degree):
            off = curve(nodes, self.order) - self.curve(nodes)
            total += float(np.sum(weights[segment] * share * (off**2).sum(axis=1)))
        return total

    def loads(self, knots: Array, origins: Array, s: int) -> Array:
        """Return λ ∫ p⁽ᵏ⁾ g dt of every segment as a form in its ends z, see `hermite`.

        Args:
            knots: (N + 1,) s, of the trajectory
            origins: (N, dimensions) m, what positions of a segment are relative to
            s: the derivative that is minimised

        Returns:
            shape (N, 2 s, dimensions).
        """
        durations = np.diff(knots)
        weights = np.broadcast_to(self.weight, durations.shape)
        out = np.zeros((len(durations), 2 * s, origins.shape[1]))
        for segment, nodes, share in quadrature(knots, self.curve.knots, 2 * s - 1 - self.order + self.curve.degree):
            span = durations[segment]
            basis = hermite.values(s, self.order, (nodes - knots[segment]) / span)
            drawn_to = self.curve(nodes) - (origins[segment] if self.order == 0 else 0.0)
            factor = weights[segment] * share / span**self.order
            np.add.at(out, segment, factor[:, None, None] * basis[:, :, None] * drawn_to[:, None, :])
        return out


def chord(waypoints: Array, durations: Array) -> PiecewisePolynomial:
    """Return the straight line through waypoints (N + 1, dimensions), each segment at its own constant speed."""
    steps = np.diff(waypoints, axis=0)
    return PiecewisePolynomial(durations, np.stack([waypoints[:-1], steps / durations[:, None]], axis=1))


def chord_loads(waypoints: Array, durations: Array, weights: Array, s: int) -> Array:
    """Return the loads (N, 2 s, dimensions) of the chord as a guide of position, in closed form: λ T G₀ z of the chord.

    Args:
        waypoints: (N + 1, dimensions) m
        durations: (N,) s
        weights: (N,) λ
        s: the derivative that is minimised
    """
    matrix = hermite.gram(s, 0)
    ends = matrix[:, 1] + matrix[:, s] + matrix[:, s + 1]  # z = (0, 1, 0, ..., 1, 1, 0, ...) times the chord
    return np.asarray((weights * durations)[:, None, None] * ends[:, None] * np.diff(waypoints, axis=0)[:, None, :])


gauss_legendre = cache(np.polynomial.legendre.leggauss)
"""nodes and weights on [-1, 1]"""


def quadrature(knots: Array, others: Array, degree: int) -> Iterator[tuple[np.ndarray, Array, Array]]:
    """Yield segment, time and weight, each (intervals,), of Gauss-Legendre nodes that integrate a degree exactly.

    The intervals lie between neighbours of `knots` and `others` together, within `knots`.
    """
    inside = others[(others > knots[0]) & (others < knots[-1])]
    edges = np.union1d(knots, inside)
    low, width = edges[:-1], np.diff(edges)
    segment = np.clip(np.searchsorted(knots, low + width / 2, side="right") - 1, 0, len(knots) - 2)
    nodes, weights = gauss_legendre(degree // 2 + 1)
    for node, weight in zip(nodes, weights, strict=True):
        yield segment, low + width * (1 + node) / 2, width * weight / 2
