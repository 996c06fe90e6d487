"""The minimum-derivative trajectory in exact arithmetic, from its conditions of continuity: an independent oracle."""

from collections.abc import Sequence
from fractions import Fraction
from math import perm

import numpy as np

from crosstrack.types import Array


def coefficients(waypoints: Sequence[float], durations: Sequence[float], s: int) -> Array:
    """Return the coefficients (N, 2 s) of one axis, rest to rest, by solving 2 s N equations in fractions.

    Optimal are the polynomials of degree 2 s - 1 that pass through the waypoints, are at rest at both ends, and whose
    derivatives 1 to 2 s - 2 are continuous (Euler-Lagrange).
    """
    pieces, terms = len(durations), 2 * s
    spans = [Fraction(value) for value in durations]
    rows: list[dict[int, Fraction]] = []
    sides: list[Fraction] = []

    def at(piece: int, order: int, u: Fraction, sign: int = 1) -> dict[int, Fraction]:
        return {
            piece * terms + k: sign * perm(k, order) * u ** (k - order)
            for k in range(order, terms)
            if k == order or u != 0
        }

    zero = Fraction(0)
    for piece, span in enumerate(spans):
        rows += [at(piece, 0, zero), at(piece, 0, span)]
        sides += [Fraction(waypoints[piece]), Fraction(waypoints[piece + 1])]
    for order in range(1, s):
        rows += [at(0, order, zero), at(pieces - 1, order, spans[-1])]
        sides += [zero, zero]
    for piece in range(pieces - 1):
        for order in range(1, 2 * s - 1):
            rows.append(at(piece, order, spans[piece]) | at(piece + 1, order, zero, -1))
            sides.append(zero)
    return np.array(solved(rows, sides), float).reshape(pieces, terms)


def solved(rows: list[dict[int, Fraction]], sides: list[Fraction]) -> list[Fraction]:
    """Solve a square sparse system by elimination."""
    size = len(rows)
    order: list[int] = []
    for column in range(size):
        candidates = [i for i in range(size) if i not in order and rows[i].get(column)]
        pivot = min(candidates, key=lambda i: len(rows[i]))
        order.append(pivot)
        for i in range(size):
            if i != pivot and rows[i].get(column):
                factor = rows[i][column] / rows[pivot][column]
                for k, value in rows[pivot].items():
                    left = rows[i].get(k, Fraction(0)) - factor * value
                    if left:
                        rows[i][k] = left
                    else:
                        rows[i].pop(k, None)
                sides[i] -= factor * sides[pivot]
    return [sides[pivot] / rows[pivot][column] for column, pivot in enumerate(order)]
