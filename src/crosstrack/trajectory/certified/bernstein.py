"""Polynomials on unit time in Bernstein form, whose coefficients enclose their values.

Farouki, The Bernstein polynomial basis: a centennial retrospective, Computer Aided Geometric Design 29 (2012).
"""

from functools import cache
from math import comb

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

Indices = NDArray[np.int64]
EPSILON = float(np.finfo(float).eps)
DEEPEST = 52
"""halvings after which an interval is as short as the spacing of floats in [0, 1]"""


@cache
def basis(degree: int) -> Array:
    """Return M (terms, terms) with b = M a: ascending powers of unit time to Bernstein coefficients.

    b_i = Σ_j C(i, j) / C(n, j) a_j
    """
    return np.array([[comb(i, j) / comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)])


@cache
def products(degree: int) -> Array:
    """Return W (terms, terms) for products of two polynomials of a degree: (f g)_k = Σ_{i+j=k} W_ij f_i g_j.

    W_ij = C(n, i) C(n, j) / C(2n, i + j)
    """
    n = degree
    return np.array([[comb(n, i) * comb(n, j) / comb(2 * n, i + j) for j in range(n + 1)] for i in range(n + 1)])


@compiled
def control_points(
    coefficients: Array, duration: float, order: int, origin: Array, axes: Indices, basis: Array, out: Array
) -> float:
    """Fill `out` with the Bernstein coefficients on unit time of the derivative of an order of one piece.

    Args:
        coefficients: (degree + 1, dimensions), ascending powers of local time
        duration: s
        order: of the derivative, with respect to local time
        origin: (dimensions,), subtracted from the position before anything else, so that far coordinates cost nothing
        axes: (chosen,) int, the axes wanted
        basis: of the derivative's degree
        out: (terms, chosen)

    Returns:
        A bound on the distance by which rounding moves a control point, infinite where a coefficient is not finite.
    """
    terms = out.shape[0]
    error: float = 0.0
    for d in range(axes.size):
        for i in range(terms):
            out[i, d] = 0.0
        size = 0.0
        power = 1.0
        for j in range(min(terms, coefficients.shape[0] - order)):
            factor = power
            for m in range(order):
                factor *= j + order - m
            a = coefficients[j + order, axes[d]]
            if j == 0 and order == 0:
                a -= origin[axes[d]]
            a *= factor
            size += abs(a)
            for i in range(j, terms):
                out[i, d] += basis[i, j] * a
            power *= duration
        error += size
    return error * EPSILON * 4.0 * (terms + order) if error < np.inf else np.inf


@compiled
def squared(points: Array, products: Array, out: Array) -> None:
    """Fill `out` (2 terms - 1,) with the Bernstein coefficients of ‖p‖² for control points (terms, dimensions)."""
    terms, dimensions = points.shape
    for k in range(2 * terms - 1):
        out[k] = 0.0
    for i in range(terms):
        for j in range(i, terms):
            dot = 0.0
            for d in range(dimensions):
                dot += points[i, d] * points[j, d]
            out[i + j] += products[i, j] * dot * (1.0 if i == j else 2.0)


@compiled
def divide(control: Array, right: Array, terms: int, u: float) -> None:
    """Split at u by de Casteljau: `control` becomes the part before it, `right` the one after it."""
    right[terms - 1] = control[terms - 1]
    for level in range(1, terms):
        for i in range(terms - 1, level - 1, -1):
            control[i] = u * control[i] + (1.0 - u) * control[i - 1]
        right[terms - 1 - level] = control[terms - 1]


@compiled
def differences(control: Array, degree: int, order: int, u: float) -> float:
    """Evaluate the polynomial with the forward differences of an order (0, 1, 2) of `control` as its coefficients.

    So derivatives are n and n (n - 1) times the values for order 1 and 2.
    """
    n = degree - order
    if n < 0:
        return 0.0
    v = 1.0 - u
    power, total = 1.0, 0.0
    for i in range(n + 1):
        c = control[i]
        if order == 1:
            c = control[i + 1] - c
        elif order == 2:
            c += control[i + 2] - 2.0 * control[i + 1]
        total = total * v + power * c
        power *= u * (n - i) / (i + 1)
    return total
