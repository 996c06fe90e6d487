"""The closed form for durations of very different length: as `banded`, by orthogonal transformations.

A long segment beside a short one is softer by up to (T / t)^(2 s - 1), and elimination on the matrix of the cost loses
twice the digits that the cost itself holds. Here the cost is kept as a sum of squares ‖F z - f‖² of Legendre
coefficients, and each knot is eliminated by Householder reflections, largest row first (Powell and Reid 1969), which
lose half of them.
"""

from functools import cache
from math import factorial

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory import hermite
from crosstrack.trajectory.banded import COLUMNS, GUIDES, Kernel, fill
from crosstrack.types import Array


@cache
def kernel(s: int) -> Kernel:
    """Return the compiled solver of one trajectory, which takes what that of `banded` takes.

    `least` (1,) is the least diagonal entry of the triangle relative to its column: zero where a derivative is
    undetermined.
    """
    free, columns = s - 1, COLUMNS
    width = 2 * free + columns
    orders = (s, *range(GUIDES))
    roots, spread = np.zeros((2, len(orders), 2 * s, 2 * s))
    for term, order in enumerate(orders):
        factor = hermite.root(s, order)
        roots[term, : len(factor)] = factor
        spread[term, : len(factor)] = np.linalg.pinv(factor.T)
    upper = hermite.coefficients(s)[s:].copy()
    inverse_factorial = np.array([1 / factorial(k) for k in range(s)])

    @compiled
    def solve(durations: Array, knots: Array, weights: Array, loads: Array, coefficients: Array, least: Array) -> None:
        segments = durations.size
        kept = np.zeros((segments + 1, free, width))
        rows = np.zeros((2 * free + 2 * s * (1 + GUIDES), width))
        count, least[0] = 0, 1.0
        for i in range(segments):
            count = add_energy(s, columns, count, durations[i], knots[i], knots[i + 1], roots, rows)
            if weights.size > 0:
                count = add_guides(
                    s, columns, count, durations[i], knots[i], knots[i + 1], weights[i], loads[i], roots, spread, rows
                )
            take_out(free, columns, free, count, knots[i + 1], rows)
            count = hold(free, columns, count, knots[i], rows)
            least[0] = min(least[0], triangle(free, 2 * free, count, rows))
            count = min(count, 2 * free)
            for k in range(free):
                for m in range(width):
                    kept[i, k, m] = rows[k, m]
            count = shift(free, columns, count, rows)
        count = hold(free, columns, count, knots[segments], rows)
        least[0] = min(least[0], triangle(free, free, count, rows))
        for k in range(free):
            for m in range(width):
                kept[segments, k, m] = rows[k, m]
        substitute(free, columns, kept[segments], knots[segments], np.zeros((s, columns)))
        for i in range(segments - 1, -1, -1):
            substitute(free, columns, kept[i], knots[i], knots[i + 1])
            fill(s, columns, durations[i], knots[i], knots[i + 1], upper, inverse_factorial, coefficients[i])

    return solve


@compiled
def add_energy(
    s: int, columns: int, count: int, span: float, start: Array, end: Array, roots: Array, rows: Array
) -> int:
    """Append the s rows of the energy of a segment; return how many rows there are."""
    scale = span ** (0.5 - s)
    for r in range(s):
        add_row(s, columns, span, scale, start, end, roots[0, r], rows[count + r])
    return count + s


@compiled
def add_guides(
    s: int,
    columns: int,
    count: int,
    span: float,
    start: Array,
    end: Array,
    weights: Array,
    loads: Array,
    roots: Array,
    spread: Array,
    rows: Array,
) -> int:
    """Append the rows of the guides of a segment; the lowest order takes the linear terms of all."""
    loaded = False
    for order in range(weights.size):
        if weights[order] == 0.0:
            continue
        scale = np.sqrt(weights[order]) * span ** (0.5 - order)
        for r in range(2 * s - order):
            add_row(s, columns, span, scale, start, end, roots[1 + order, r], rows[count + r])
            for d in range(columns):
                for m in range(0 if loaded else 2 * s):
                    rows[count + r, 2 * (s - 1) + d] += spread[1 + order, r, m] * loads[m, d] / scale
        loaded = True
        count += 2 * s - order
    return count


@compiled
def add_row(s: int, columns: int, span: float, scale: float, start: Array, end: Array, root: Array, row: Array) -> None:
    """Write one row of scale F z by the derivatives at both ends, and the known positions on the right side."""
    power = span
    for k in range(1, s):
        row[k - 1] = scale * root[k] * power
        row[s - 1 + k - 1] = scale * root[s + k] * power
        power *= span
    for d in range(columns):
        row[2 * (s - 1) + d] = -scale * root[s] * (end[0, d] - start[0, d])


@compiled
def take_out(free: int, columns: int, offset: int, count: int, knot: Array, rows: Array) -> None:
    """Move the columns of the derivatives given at a knot to the right side."""
    for k in range(free):
        if np.isnan(knot[k + 1, 0]):
            continue
        for r in range(count):
            for d in range(columns):
                rows[r, 2 * free + d] -= rows[r, offset + k] * knot[k + 1, d]
            rows[r, offset + k] = 0.0


@compiled
def hold(free: int, columns: int, count: int, knot: Array, rows: Array) -> int:
    """Take out the derivatives given at a knot, and give each a row of its own; return how many rows there are."""
    take_out(free, columns, 0, count, knot, rows)
    for k in range(free):
        if np.isnan(knot[k + 1, 0]):
            continue
        for m in range(2 * free):
            rows[count, m] = 0.0
        rows[count, k] = 1.0
        for d in range(columns):
            rows[count, 2 * free + d] = knot[k + 1, d]
        count += 1
    for r in range(count, 2 * free):
        for m in range(2 * free + columns):
            rows[r, m] = 0.0
    return max(count, 2 * free)


@compiled
def triangle(own: int, across: int, count: int, rows: Array) -> float:
    """Turn the first `across` columns into a triangle; return the least diagonal of the first `own`, see `kernel`."""
    least = 1.0
    width = rows.shape[1]
    for k in range(across):
        above, below, pivot = 0.0, 0.0, k
        for r in range(count):
            square = rows[r, k] * rows[r, k]
            if r < k:
                above += square
            else:
                below += square
                if abs(rows[r, k]) > abs(rows[pivot, k]):
                    pivot = r
        if k < own:
            least = min(least, np.sqrt(below / (above + below)) if above + below > 0.0 else 0.0)
        if below == 0.0:
            continue
        for m in range(width):
            rows[k, m], rows[pivot, m] = rows[pivot, m], rows[k, m]
        reflect(k, count, np.sqrt(below), rows)
    return least


@compiled
def reflect(k: int, count: int, norm: float, rows: Array) -> None:
    """Reflect rows k and below so that column k keeps its norm in row k alone."""
    first = rows[k, k]
    diagonal = -norm if first > 0.0 else norm
    head = first - diagonal
    factor = 1.0 / (norm * (norm + abs(first)))
    for m in range(k + 1, rows.shape[1]):
        inner = head * rows[k, m]
        for r in range(k + 1, count):
            inner += rows[r, k] * rows[r, m]
        inner *= factor
        rows[k, m] -= inner * head
        for r in range(k + 1, count):
            rows[r, m] -= inner * rows[r, k]
    rows[k, k] = diagonal
    for r in range(k + 1, count):
        rows[r, k] = 0.0


@compiled
def shift(free: int, columns: int, count: int, rows: Array) -> int:
    """Keep the rows that say something of the next knot alone, with its columns first; return their number."""
    for r in range(free, count):
        for m in range(free):
            rows[r - free, m] = rows[r, free + m]
            rows[r - free, free + m] = 0.0
        for d in range(columns):
            rows[r - free, 2 * free + d] = rows[r, 2 * free + d]
    return count - free


@compiled
def substitute(free: int, columns: int, row: Array, knot: Array, ahead: Array) -> None:
    """Fill in the derivatives at a knot from those at the next."""
    for k in range(free - 1, -1, -1):
        for d in range(columns):
            value = row[k, 2 * free + d]
            for m in range(free):
                value -= row[k, free + m] * ahead[m + 1, d]
            for m in range(k + 1, free):
                value -= row[k, m] * knot[m + 1, d]
            knot[k + 1, d] = value / row[k, k]
