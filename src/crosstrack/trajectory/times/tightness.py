"""How tight limits are along the trajectories of least effort, smoothly, as a function of their durations.

At a sample the derivative k has the size q = ‖p⁽ᵏ⁾‖ / limit, and q^(1/k) is the factor by which time must be stretched
for the limit to hold. The p-norm of these factors is smooth, at least their maximum, and comes near it as p grows. Time
times tightness does not depend on the pace: it measures durations by the time they take once stretched to the limits.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory import hermite
from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.certified.bernstein import Indices
from crosstrack.trajectory.closed_form import solved
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.limits import Bound
from crosstrack.trajectory.times.effort import grams, scale, spread, twist
from crosstrack.types import Array

SAMPLES = 25
"""on every segment, both ends among them"""
ORDERS = 4
"""derivatives that limits are for, and the position"""


@cache
def bases(s: int) -> Array:
    """Return the derivatives (ORDERS, SAMPLES, 2 s) of the basis polynomials at the samples."""
    return np.array([hermite.values(s, order, np.linspace(0.0, 1.0, SAMPLES)) for order in range(ORDERS)])


def stretched_time(asked: Conditions, durations: Array, bounds: list[Bound], power: float) -> tuple[float, Array]:
    """Return log (Σ T · tightness) of the trajectory of least effort at some durations, and its slopes by log T.

    Args:
        asked: from rest to rest, without guides
        durations: (N,) s
        bounds: at least one
        power: p
    """
    s, columns = asked.knots.shape[1:]
    segments = len(durations)
    knots = asked.knots.copy()
    solved(replace(asked, durations=durations), knots)
    pulls, own = np.zeros((segments, 2 * s, columns)), np.empty(segments)
    orders, first, most = (np.array(row) for row in zip(*((b.order, b.axes[0], b.most) for b in bounds), strict=True))
    value = tightness(durations, knots, orders, first, most, bases(s), power, pulls, own)
    moved = np.where(np.isnan(asked.knots), np.nan, 0.0)
    solved(replace(asked, durations=durations, weights=np.zeros((segments, GUIDES)), loads=pulls), moved)
    follow(durations, knots, moved, grams(s), own)
    total = durations.sum()
    return value + float(np.log(total)), own + durations / total


@compiled
def tightness(
    durations: Array,
    knots: Array,
    orders: Indices,
    first: Indices,
    most: Array,
    bases: Array,
    power: float,
    pulls: Array,
    own: Array,
) -> float:
    """Return the logarithm of the p-norm of the factors of all samples and limits.

    Args:
        durations: (N,) s
        knots: (N + 1, s, columns), all known
        orders: (limits,) of the derivatives
        first: (limits,) axis from which on the norm is taken
        most: (limits,) the limits
        bases: see `bases`
        power: p
        pulls: (N, 2 s, columns), filled with the slopes by the ends z of every segment
        own: (N,), filled with the slopes by log T at fixed derivatives at the knots
    """
    s, columns = knots.shape[1:]
    segments, samples = durations.size, bases.shape[1]
    whole, bent, moved = np.empty((2 * s, columns)), np.empty((2 * s, columns)), np.empty(columns)
    factors = np.empty((segments, orders.size, samples))
    peak = 0.0
    for i in range(segments):
        spread(durations[i], knots[i], knots[i + 1], whole, bent)
        for b in range(orders.size):
            for j in range(samples):
                size = sample(whole, bases[orders[b], j], durations[i], orders[b], first[b], moved)
                factors[i, b, j] = (size / most[b]) ** (1.0 / orders[b])
                peak = max(peak, factors[i, b, j])
    total = 0.0
    for i in range(segments):
        for b in range(orders.size):
            for j in range(samples):
                total += (factors[i, b, j] / peak) ** power
    for i in range(segments):
        spread(durations[i], knots[i], knots[i + 1], whole, bent)
        own[i] = 0.0
        for b in range(orders.size):
            order = orders[b]
            shrink = durations[i] ** (-order)
            for j in range(samples):
                share = (factors[i, b, j] / peak) ** power / total
                if share < 1e-14:
                    continue
                size = sample(whole, bases[order, j], durations[i], order, first[b], moved)
                own[i] -= share
                for d in range(first[b], columns):
                    pull = share * moved[d] / (order * size * size) * shrink
                    for m in range(2 * s):
                        pulls[i, m, d] += bases[order, j, m] * pull
        for m in range(2 * s):
            for d in range(columns):
                own[i] += (m % s) * whole[m, d] * pulls[i, m, d]
    return math.log(peak) + math.log(total) / power


@compiled
def sample(whole: Array, basis: Array, span: float, order: int, first: int, out: Array) -> float:
    """Fill `out` (columns,) with a derivative at one sample and return its norm over the axes from `first` on."""
    square = 0.0
    for d in range(first, out.size):
        value = 0.0
        for m in range(basis.size):
            value += basis[m] * whole[m, d]
        out[d] = value / span**order
        square += out[d] * out[d]
    return math.sqrt(square)


@compiled
def follow(durations: Array, knots: Array, moved: Array, grams: Array, out: Array) -> None:
    """Subtract from `out` (N,) the slopes that come from the knots' derivatives following the durations.

    Args:
        durations: (N,) s
        knots: (N + 1, s, columns), all known
        moved: (N + 1, s, columns), K⁻¹ times the slopes by the knots' derivatives, K half of the curvature
        grams: see `effort.grams`
        out: (N,)
    """
    s, columns = knots.shape[1:]
    whole, bent, cross = np.empty((2 * s, columns)), np.empty((2 * s, columns)), np.empty((2 * s, columns))
    factors, none = np.zeros(1 + GUIDES), np.empty((0, GUIDES))
    for i in range(durations.size):
        spread(durations[i], knots[i], knots[i + 1], whole, bent)
        scale(i, durations[i], s, none, factors)
        twist(durations[i], whole, bent, factors, grams, cross)
        for m in range(2 * s):
            for d in range(columns):
                out[i] -= moved[i + m // s, m % s, d] * cross[m, d]
