"""Durations of least effort with guides that have a time of their own, and of loops: quasi-Newton, with exact slopes.

A guide fixed in time meets a segment at another time when the durations before it change. With q the derivative k of
the segment, t its start, T its duration and w = ‖q - g‖², its share E = λ ∫ w dt has

    dE/dt = λ (w(t + T) - w(t) - 2 ∫ (q - g)·q̇ dt),
    dE/dT = λ (w(t + T) + 2 ∫ (q - g)·∂q/∂T dt),      ∂q/∂T = (-k q - u q̇ + r) / T,

where u is the time since its start, and r the derivative k of the polynomial whose ends are A z, see `effort`. The
guide's own slope does not enter. Where it jumps the effort has a kink.
"""

from collections.abc import Callable, Sequence
from math import perm

import numpy as np
from scipy.optimize import minimize

from crosstrack.trajectory import hermite
from crosstrack.trajectory.closed_form import closed_form, ends
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.guide import Guide, quadrature
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.effort import grams, slopes
from crosstrack.trajectory.times.effort_descent import SMALLEST, Descent, Effort
from crosstrack.types import Array

FLAT = 1e-7
"""slope of the objective by log T, relative to where it begins, at which it has converged"""


def descend_guided(
    remade: Callable[[Array], Conditions], guides: Sequence[Guide], durations: Array, price: float | None
) -> Descent:
    """Minimise effort + price · Σ T, or the effort alone with a fixed total for None.

    Args:
        remade: from durations to conditions
        guides: those among the conditions; the chord's weight is in the conditions themselves
        durations: (N,) s, to begin with
        price: ρ
    """
    total, cost = float(durations.sum()), price or 0.0

    def at(y: Array) -> Array:
        spans: Array = np.exp(y - y.max())
        return np.exp(y) if price is not None else spans * (total / spans.sum())

    def objective(y: Array) -> tuple[float, Array]:
        now = guided_effort(remade(at(y)), guides)
        uphill = now.slopes + cost * now.durations
        if price is None:
            uphill = uphill - now.durations * (uphill.sum() / total)
        return (now.value + cost * float(now.durations.sum())) / scale, uphill / scale

    scale = 1.0
    scale = objective(np.log(durations))[0] or 1.0
    done = minimize(objective, np.log(durations), jac=True, method="BFGS", options={"gtol": FLAT})
    best = guided_effort(remade(at(done.x)), guides)
    slope = float(np.abs(done.jac).max()) * scale / max(best.value, SMALLEST)
    return Descent(best, bool(done.success), int(done.nit), slope)


def guided_effort(asked: Conditions, guides: Sequence[Guide]) -> Effort:
    """Return the least effort under conditions of any kind."""
    curve = closed_form(asked)
    s = asked.order
    knots = asked.knots.copy()
    for k in range(1, s):
        knots[:-1, k] = perm(k) * curve.coefficients[:, k]
        knots[-1, k] = curve(curve.duration, k)
    weights = np.empty((0, 3)) if guides else asked.weights
    out = np.empty(len(asked.durations))
    value = slopes(asked.durations, knots, weights, grams(s), out)
    for guide in guides:
        value += guide.error(curve)
        out += drift(guide, curve, knots) * asked.durations
    return Effort(asked.durations, value, out, knots)


def drift(guide: Guide, curve: PiecewisePolynomial, knots: Array) -> Array:
    """Return the slopes (N,) of a guide's share of the effort by the durations, at fixed derivatives at the knots.

    Args:
        guide: fixed in time
        curve: the trajectory
        knots: (N + 1, s, d) its derivatives at the knots
    """
    k, spans, s = guide.order, curve.durations, knots.shape[1]
    weights = np.broadcast_to(guide.weight, spans.shape)
    orders = np.arange(2 * s)[:, None]
    turned = hermite.coefficients(s) @ (orders % s * ends(spans, knots)) / spans[:, None, None] ** orders
    turning = PiecewisePolynomial(spans, turned)
    stretch, shift = np.zeros(len(spans)), np.zeros(len(spans))
    degree = 2 * max(2 * s - 1 - k, guide.curve.degree)
    for segment, nodes, share in quadrature(curve.knots, guide.curve.knots, degree):
        q, move = curve(nodes, k), curve(nodes, k + 1)
        u, span = (nodes - curve.knots[segment])[:, None], spans[segment][:, None]
        by_span = (-k * q - u * move + turning(nodes, k)) / span
        off = 2.0 * (weights[segment] * share)[:, None] * (q - guide.curve(nodes))
        np.add.at(stretch, segment, (off * by_span).sum(axis=1))
        np.add.at(shift, segment, -(off * move).sum(axis=1))
    drawn_to = guide.curve(curve.knots)
    first, last = sides(curve, k)
    after = weights * ((last - drawn_to[1:]) ** 2).sum(axis=1)
    before = weights * ((first - drawn_to[:-1]) ** 2).sum(axis=1)
    later = np.append(np.cumsum((after - before + shift)[::-1])[::-1][1:], 0.0)
    return np.asarray(after + stretch + later)


def sides(curve: PiecewisePolynomial, order: int) -> tuple[Array, Array]:
    """Return the derivative of an order at the start and at the end of every piece, each (N, d)."""
    pieces = curve.derivative(order)
    powers = curve.durations[:, None, None] ** np.arange(pieces.degree + 1)[:, None]
    return pieces.coefficients[:, 0], (pieces.coefficients * powers).sum(axis=1)
