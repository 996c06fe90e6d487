"""One polynomial of degree 2s - 1 by the values and derivatives at its ends, on unit time: exact constants.

A segment of duration T has the ends z = (p₀, T ṗ₀, ..., T^(s-1) p₀⁽ˢ⁻¹⁾, p₁, T ṗ₁, ...), 2s numbers an axis, and on
unit time τ = t / T the coefficients Z z. With the matrix G_k of ∫ p⁽ᵏ⁾ p⁽ᵏ⁾ᵀ dτ, ∫ (p⁽ᵏ⁾)² dt = T^(1-2k) zᵀ G_k z.
"""

from fractions import Fraction
from functools import cache
from math import factorial, perm

import numpy as np

from crosstrack.types import Array

Exact = list[list[Fraction]]


@cache
def basis(s: int) -> Exact:
    """Return Z (2s, 2s): ascending coefficients on unit time of the polynomial with the ends z."""
    size = 2 * s
    rows: Exact = []
    for order in range(s):
        rows.append([Fraction(perm(power, order) if power == order else 0) for power in range(size)])
    for order in range(s):
        rows.append([Fraction(perm(power, order)) for power in range(size)])
    return inverse(rows)


@cache
def gram(s: int, order: int) -> Array:
    """Return G (2s, 2s), the matrix of the integral of the square of a derivative over unit time."""
    z = basis(s)
    size = range(2 * s)
    powers = range(order, 2 * s)
    inner = {(j, k): Fraction(perm(j, order) * perm(k, order), j + k - 2 * order + 1) for j in powers for k in powers}
    half = [[sum((inner[j, k] * z[k][n] for k in powers), Fraction()) for n in size] for j in powers]
    exact = [[sum((z[j][m] * half[j - order][n] for j in powers), Fraction()) for n in size] for m in size]
    return np.array(exact, float)


@cache
def coefficients(s: int) -> Array:
    """Return Z (2s, 2s) as floats."""
    return np.array(basis(s), float)


def values(s: int, order: int, tau: Array) -> Array:
    """Return the derivative of an order of the 2s basis polynomials at unit times (n,), shape (n, 2s)."""
    powers = np.arange(order, 2 * s)
    factors = np.array([factorial(int(power)) // factorial(int(power) - order) for power in powers], float)
    return np.asarray((tau[:, None] ** (powers - order) * factors) @ coefficients(s)[order:])


def inverse(matrix: Exact) -> Exact:
    """Invert a regular matrix exactly (Gauss-Jordan)."""
    size = len(matrix)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(size))] for i, row in enumerate(matrix)]
    for column in range(size):
        pivot = next(i for i in range(column, size) if rows[i][column])
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [value / rows[column][column] for value in rows[column]]
        for i in range(size):
            if i != column and rows[i][column]:
                factor = rows[i][column]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[column], strict=True)]
    return [row[size:] for row in rows]


@cache
def root(s: int, order: int) -> Array:
    """Return F (2 s - order, 2 s) with Fᵀ F = `gram`: the Legendre coefficients of a derivative over unit time.

    With the Legendre polynomials P_j of [0, 1], row j is sqrt(2 j + 1) ∫ p⁽ᵏ⁾ P_j dτ.
    """
    size, z, rows = range(2 * s), basis(s), []
    for j in range(2 * s - order):
        # ∫ τ^n P_j dτ = n!² / ((n - j)! (n + j + 1)!), zero for n < j
        moments = {
            n + order: Fraction(perm(n + order, order) * factorial(n) ** 2, factorial(n - j) * factorial(n + j + 1))
            for n in range(j, 2 * s - order)
        }
        row = [sum((moment * z[k][n] for k, moment in moments.items()), Fraction()) for n in size]
        rows.append(np.sqrt(2 * j + 1) * np.array(row, float))
    return np.array(rows)
