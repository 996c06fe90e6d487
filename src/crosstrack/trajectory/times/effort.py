"""The effort of the best trajectory as a function of the durations of its segments: value, slopes and curvature.

With z the ends of a segment relative to its chord, see `hermite`, f_k = λ_k T^(1-2k) and A = diag(order of each end), a
segment costs E = Σ f_k zᵀ G_k z. At fixed derivatives at the knots z follows T as T dz/dT = A z̄, with z̄ the ends
themselves, since the chord on unit time does not depend on T. So with y = log T, and c = 1 - 2k,

    dE/dy   = Σ f_k (c zᵀGz + 2 (Az̄)ᵀGz)
    d²E/dy² = Σ f_k (c² zᵀGz + 4c (Az̄)ᵀGz + 2 (A²z̄)ᵀGz + 2 (Az̄)ᵀG(Az̄)).

At the derivatives that minimise the cost its slope by the durations is the one at fixed derivatives (envelope theorem);
without guides that is -T (‖p⁽ˢ⁾‖² + 2 Σ_{k=1}^{s-1} (-1)ᵏ p⁽ˢ⁺ᵏ⁾·p⁽ˢ⁻ᵏ⁾), which is the same anywhere on the segment.
"""

from functools import cache

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory import hermite
from crosstrack.trajectory.banded import GUIDES
from crosstrack.types import Array


@cache
def grams(s: int) -> Array:
    """Return G (1 + GUIDES, 2 s, 2 s): of the derivative s that is minimised, then of orders 0, 1, 2 for the guides."""
    return np.array([hermite.gram(s, s), *(hermite.gram(s, order) for order in range(GUIDES))])


@compiled
def spread(span: float, start: Array, end: Array, whole: Array, bent: Array) -> None:
    """Fill the ends (2 s, columns) of a segment: `whole` relative to its first point, `bent` relative to its chord."""
    s, columns = start.shape
    for d in range(columns):
        step = end[0, d] - start[0, d]
        power = 1.0
        for k in range(s):
            whole[k, d] = start[k, d] * power if k > 0 else 0.0
            whole[s + k, d] = end[k, d] * power if k > 0 else step
            bent[k, d], bent[s + k, d] = whole[k, d], whole[s + k, d]
            power *= span
        bent[s, d] = 0.0
        bent[1, d] -= step
        bent[s + 1, d] -= step


@compiled
def scale(i: int, span: float, s: int, weights: Array, factors: Array) -> None:
    """Fill `factors` (1 + GUIDES,) with f_k of segment i: of the minimised derivative, then of the guides."""
    inverse = 1.0 / span
    factors[0] = span
    for _ in range(2 * s):
        factors[0] *= inverse
    if weights.size > 0:
        factors[1] = weights[i, 0] * span
        factors[2] = weights[i, 1] * inverse
        factors[3] = weights[i, 2] * inverse * inverse * inverse


@compiled
def exponent(term: int, s: int) -> float:
    """Return c = 1 - 2 k of a term of the cost."""
    return 1.0 - 2.0 * (s if term == 0 else term - 1)


@compiled
def slopes(durations: Array, knots: Array, weights: Array, grams: Array, out: Array) -> float:
    """Fill `out` (N,) with T_i dJ/dT_i at fixed derivatives at the knots and return the cost J.

    Args:
        durations: (N,) s
        knots: (N + 1, s, columns), all known
        weights: (N, 3) λ of the chord as a guide of order 0, 1, 2; (0, 3) without
        grams: see `grams`
        out: (N,)
    """
    s, columns = knots.shape[1:]
    whole, bent = np.empty((2 * s, columns)), np.empty((2 * s, columns))
    factors = np.zeros(1 + GUIDES)
    total = 0.0
    for i in range(durations.size):
        spread(durations[i], knots[i], knots[i + 1], whole, bent)
        out[i] = 0.0
        scale(i, durations[i], s, weights, factors)
        for term in range(1 + GUIDES):
            if factors[term] == 0.0:
                continue
            c = exponent(term, s)
            value, turn = 0.0, 0.0
            for m in range(2 * s):
                for d in range(columns):
                    pushed = 0.0
                    for n in range(2 * s):
                        pushed += grams[term, m, n] * bent[n, d]
                    value += bent[m, d] * pushed
                    turn += (m % s) * whole[m, d] * pushed
            total += factors[term] * value
            out[i] += factors[term] * (c * value + 2.0 * turn)
    return total


@compiled
def twist(span: float, whole: Array, bent: Array, factors: Array, grams: Array, out: Array) -> tuple[float, float]:
    """Fill `out` (2 s, columns) with half of d²E/(dx dy) by the derivatives x at the knots; return half of E' and E''.

    The primes are by y. `whole` and `bent` are those of `spread`.
    """
    size, columns = whole.shape
    s = size // 2
    slope, curvature = 0.0, 0.0
    for m in range(size):
        for d in range(columns):
            out[m, d] = 0.0
    for term in range(1 + GUIDES):
        factor, c = factors[term], exponent(term, s)
        if factor == 0.0:
            continue
        for m in range(size):
            a = m % s
            for d in range(columns):
                pushed, turned = 0.0, 0.0
                for n in range(size):
                    pushed += grams[term, m, n] * bent[n, d]
                    turned += grams[term, m, n] * (n % s) * whole[n, d]
                first = a * whole[m, d] * pushed
                slope += factor * (0.5 * c * bent[m, d] * pushed + first)
                curvature += factor * (0.5 * c * c * bent[m, d] * pushed + (2.0 * c + a) * first)
                curvature += factor * a * whole[m, d] * turned
                out[m, d] += factor * ((c + a) * pushed + turned)
    power = 1.0
    for k in range(s):
        for d in range(columns):
            out[k, d] *= power
            out[s + k, d] *= power
        power *= span
    return slope, curvature


@compiled
def curvature(
    durations: Array, knots: Array, pinned: Array, weights: Array, price: float, grams: Array, band: Array
) -> None:
    """Fill half the matrix of second derivatives of J + ρ Σ T, by the free derivatives at the knots and y, as a band.

    The unknowns are, knot by knot, its derivatives of order 1 ... s - 1 with all axes of each, then y of the segment
    that begins there. A derivative that is given keeps a row of the identity.

    Args:
        durations: (N,) s
        knots: (N + 1, s, columns), all known
        pinned: (N + 1, s) bool, whether a derivative is given
        weights: see `slopes`
        price: ρ, of time
        grams: see `grams`
        band: (2 (s - 1) columns + 1, unknowns), band[r, j] = M[j + r, j], zero
    """
    s, columns = knots.shape[1:]
    free = (s - 1) * columns
    whole, bent, cross = np.empty((2 * s, columns)), np.empty((2 * s, columns)), np.empty((2 * s, columns))
    powers, factors = np.ones(s), np.zeros(1 + GUIDES)
    for i in range(durations.size):
        span = durations[i]
        for k in range(1, s):
            powers[k] = powers[k - 1] * span
        first = i * (free + 1)
        spread(span, knots[i], knots[i + 1], whole, bent)
        scale(i, span, s, weights, factors)
        _, bend = twist(span, whole, bent, factors, grams, cross)
        y = first + free
        band[0, y] += bend + 0.5 * price * span
        for m in range(2 * s):
            k, side = m % s, m // s
            if k == 0 or pinned[i + side, k]:
                continue
            for d in range(columns):
                at = first + side * (free + 1) + (k - 1) * columns + d
                band[abs(at - y), min(at, y)] += cross[m, d]
            for n in range(m + 1):
                j, other = n % s, n // s
                if j == 0 or pinned[i + other, j]:
                    continue
                value = 0.0
                for term in range(1 + GUIDES):
                    value += factors[term] * grams[term, m, n]
                value *= powers[k] * powers[j]
                column = first + other * (free + 1) + (j - 1) * columns
                row = first + side * (free + 1) + (k - 1) * columns
                for d in range(columns):
                    band[row - column, column + d] += value
    for i in range(durations.size + 1):
        for k in range(1, s):
            if pinned[i, k]:
                for d in range(columns):
                    band[0, i * (free + 1) + (k - 1) * columns + d] = 1.0
