"""The closed form: block elimination over the derivatives at the knots, O(N), compiled for each order s.

With the positions known, the cost is a quadratic form in the derivatives x_i (s - 1 an axis) at the knots. Its
matrix is block tridiagonal and the same for every axis, one block of s - 1 rows a knot:

    B_i-1ᵀ x_i-1 + A_i x_i + B_i x_i+1 = r_i.

Elimination goes forward, S_i = A_i - B_i-1ᵀ S_i-1⁻¹ B_i-1, and substitution back. A derivative that is given keeps its
row as x = given, and its column moves to the right side.
"""

from collections.abc import Callable
from functools import cache
from math import factorial

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory import hermite
from crosstrack.types import Array

GUIDES = 3
"""orders a guide may have: position, velocity, acceleration"""
COLUMNS = 3
"""axes that are solved for at once"""

Kernel = Callable[[Array, Array, Array, Array, Array, Array], None]


@cache
def kernel(s: int) -> Kernel:
    """Return the compiled solver for the minimised derivative s, of as many columns as COLUMNS.

    It solves for m trajectories of N segments each, one after another in every array, and takes

    - durations (m N,) s, positive
    - knots (m (N + 1), s, columns): positions, and derivatives of which those with NaN in the first column are free;
      these are filled in
    - weights (m N, 3): of the guides of order 0, 1, 2 on each segment; (0, 3) without guides
    - loads (m N, 2 s, columns): half the linear term of the guides in the ends z of a segment, see `hermite`, with its
      first point as the origin; (0, 2 s, columns) without guides
    - coefficients (m N, 2 s, columns): filled in
    - least (m,): filled in with the least pivot relative to its diagonal entry, how many of 16 digits are left
    """
    free, columns = s - 1, COLUMNS
    matrices = np.array([hermite.gram(s, s), *(hermite.gram(s, order) for order in range(GUIDES))])
    upper = hermite.coefficients(s)[s:].copy()
    inverse_factorial = np.array([1 / factorial(k) for k in range(s)])

    @compiled
    def solve(durations: Array, knots: Array, weights: Array, loads: Array, coefficients: Array, least: Array) -> None:
        segments = durations.size // least.size
        back = np.empty((segments, free, free))
        block, across, ahead = np.empty((free, free)), np.empty((free, free)), np.empty((free, free))
        right, right_ahead = np.empty((free, columns)), np.empty((free, columns))
        powers, scales, taken = np.ones(2 * s), np.zeros(1 + GUIDES), np.empty(free)
        terms = 1 + GUIDES if weights.size > 0 else 1
        for trajectory in range(least.size):
            first = trajectory * segments
            begin(free, columns, block, right, taken)
            kept = 1.0
            for i in range(segments):
                segment, knot = first + i, first + trajectory + i
                start, end = knots[knot], knots[knot + 1]
                scale_terms(s, terms, durations[segment], segment, weights, powers, scales)
                add_terms(
                    free, columns, terms, scales, powers, matrices, start, end, block, across, ahead, right, right_ahead
                )
                if terms > 1:
                    add_loads(free, columns, powers, loads[segment], right, right_ahead)
                pin_ahead(free, columns, end, across, right)
                pin(free, columns, start, block, across, right, right_ahead, taken)
                kept = min(kept, decompose(free, block, taken))
                divide(free, columns, block, right)
                keep(free, columns, start, right)
                for k in range(free):
                    for j in range(free):
                        back[i, k, j] = across[k, j]
                divide(free, free, block, back[i])
                advance(free, columns, across, back[i], ahead, right, right_ahead, block, taken)
            last = knots[first + trajectory + segments]
            pin(free, columns, last, block, across, right, right_ahead, taken)
            least[trajectory] = min(kept, decompose(free, block, taken))
            divide(free, columns, block, right)
            keep(free, columns, last, right)
            for i in range(segments - 1, -1, -1):
                segment, knot = first + i, first + trajectory + i
                substitute(free, columns, back[i], knots[knot], knots[knot + 1])
                fill(
                    s,
                    columns,
                    durations[segment],
                    knots[knot],
                    knots[knot + 1],
                    upper,
                    inverse_factorial,
                    coefficients[segment],
                )

    return solve


@compiled
def begin(free: int, columns: int, block: Array, right: Array, taken: Array) -> None:
    """Clear what is known of the first knot."""
    for k in range(free):
        for m in range(free):
            block[k, m] = 0.0
        for d in range(columns):
            right[k, d] = 0.0
        taken[k] = 0.0


@compiled
def keep(free: int, columns: int, knot: Array, right: Array) -> None:
    """Write a right side into the derivatives at a knot."""
    for k in range(free):
        for d in range(columns):
            knot[k + 1, d] = right[k, d]


@compiled
def substitute(free: int, columns: int, back: Array, knot: Array, ahead: Array) -> None:
    """Take the derivatives at the next knot off those at a knot."""
    for k in range(free):
        for d in range(columns):
            for m in range(free):
                knot[k + 1, d] -= back[k, m] * ahead[m + 1, d]


@compiled
def scale_terms(s: int, terms: int, span: float, i: int, weights: Array, powers: Array, scales: Array) -> None:
    """Fill the powers of a duration and what every term is scaled by: T^(1 - 2 s), then λ_k T^(1 - 2 k)."""
    for k in range(1, 2 * s):
        powers[k] = powers[k - 1] * span
    scales[0] = 1.0 / powers[2 * s - 1]
    if terms > 1:
        inverse = 1.0 / span
        scales[1] = weights[i, 0] * span
        scales[2] = weights[i, 1] * inverse
        scales[3] = weights[i, 2] * inverse * inverse * inverse


@compiled
def add_terms(
    free: int,
    columns: int,
    terms: int,
    scales: Array,
    powers: Array,
    matrices: Array,
    start: Array,
    end: Array,
    block: Array,
    across: Array,
    ahead: Array,
    right: Array,
    right_ahead: Array,
) -> None:
    """Add the terms of a segment to the blocks and right sides of its first knot, and begin those of the next."""
    s = free + 1
    for k in range(free):
        for m in range(free):
            across[k, m] = ahead[k, m] = 0.0
        for d in range(columns):
            right_ahead[k, d] = 0.0
    for term in range(terms):
        if scales[term] == 0.0:
            continue
        matrix = matrices[term]
        for k in range(free):
            for m in range(free):
                scale = scales[term] * powers[k + m + 2]
                block[k, m] += matrix[k + 1, m + 1] * scale
                across[k, m] += matrix[k + 1, s + m + 1] * scale
                ahead[k, m] += matrix[s + k + 1, s + m + 1] * scale
            scale = scales[term] * powers[k + 1]
            for d in range(columns):
                step = scale * (end[0, d] - start[0, d])
                right[k, d] -= matrix[k + 1, s] * step
                right_ahead[k, d] -= matrix[s + k + 1, s] * step


@compiled
def add_loads(free: int, columns: int, powers: Array, loads: Array, right: Array, right_ahead: Array) -> None:
    """Add the linear terms of the guides on a segment."""
    for k in range(free):
        for d in range(columns):
            right[k, d] += loads[k + 1, d] * powers[k + 1]
            right_ahead[k, d] += loads[free + 2 + k, d] * powers[k + 1]


@compiled
def pin(
    free: int,
    columns: int,
    knot: Array,
    block: Array,
    across: Array,
    right: Array,
    right_ahead: Array,
    taken: Array,
) -> None:
    """Take the derivatives given at a knot out of the unknowns."""
    for k in range(free):
        if np.isnan(knot[k + 1, 0]):
            continue
        for d in range(columns):
            given = knot[k + 1, d]
            for m in range(free):
                right[m, d] -= block[m, k] * given
                right_ahead[m, d] -= across[k, m] * given
            right[k, d] = given
        for m in range(free):
            block[m, k] = block[k, m] = across[k, m] = 0.0
        block[k, k], taken[k] = 1.0, 0.0


@compiled
def pin_ahead(free: int, columns: int, knot: Array, across: Array, right: Array) -> None:
    """Take the derivatives given at the next knot out of the rows of this one."""
    for k in range(free):
        if np.isnan(knot[k + 1, 0]):
            continue
        for m in range(free):
            for d in range(columns):
                right[m, d] -= across[m, k] * knot[k + 1, d]
            across[m, k] = 0.0


@compiled
def decompose(size: int, block: Array, taken: Array) -> float:
    """Turn a symmetric block into L D below its diagonal and 1 / D on it; return its least relative pivot.

    Relative to the diagonal before anything was eliminated: `taken` (size,) is what the knots before have taken off it.
    """
    least = 1.0
    for k in range(size):
        whole = block[k, k] + taken[k]
        for j in range(k):
            factor = block[k, j] * block[j, j]
            for m in range(k, size):
                block[m, k] -= factor * block[m, j]
        least = min(least, block[k, k] / whole)
        block[k, k] = 1.0 / block[k, k]
    return least


@compiled
def divide(size: int, columns: int, block: Array, right: Array) -> None:
    """Solve with a decomposed block, in place."""
    for k in range(size):
        for j in range(k):
            factor = block[k, j] * block[j, j]
            for d in range(columns):
                right[k, d] -= factor * right[j, d]
    for k in range(size - 1, -1, -1):
        for d in range(columns):
            value = right[k, d]
            for j in range(k + 1, size):
                value -= block[j, k] * right[j, d]
            right[k, d] = value * block[k, k]


@compiled
def advance(
    free: int,
    columns: int,
    across: Array,
    back: Array,
    ahead: Array,
    right: Array,
    right_ahead: Array,
    block: Array,
    taken: Array,
) -> None:
    """Make block and right side those of the next knot, with this one eliminated."""
    for k in range(free):
        for m in range(free):
            value = ahead[k, m]
            for j in range(free):
                value -= across[j, k] * back[j, m]
            block[k, m] = value
        taken[k] = ahead[k, k] - block[k, k]
        for d in range(columns):
            value = right_ahead[k, d]
            for j in range(free):
                value -= across[j, k] * right[j, d]
            right_ahead[k, d] = value
    for k in range(free):
        for d in range(columns):
            right[k, d] = right_ahead[k, d]


@compiled
def fill(
    s: int, columns: int, span: float, start: Array, end: Array, upper: Array, inverse_factorial: Array, out: Array
) -> None:
    """Fill the coefficients (2 s, columns) of a segment from position and derivatives at its ends."""
    inverse = 1.0 / span
    shrink = inverse
    for _ in range(s - 1):
        shrink *= inverse
    for k in range(s):
        for d in range(columns):
            out[k, d] = start[k, d] * inverse_factorial[k]
            value = upper[k, s] * (end[0, d] - start[0, d])
            power = span
            for m in range(1, s):
                value += (upper[k, m] * start[m, d] + upper[k, s + m] * end[m, d]) * power
                power *= span
            out[s + k, d] = value * shrink
        shrink *= inverse
