"""Convex constraints at instants of a trajectory, and the algebra of the cones that their slacks lie in.

A constraint holds one derivative of one piece at one instant, v = φᵀ z (d,), in a convex set: the slacks

    s = b - N v - c θ

of its rows lie in a cone. The first rows of a constraint may form a second-order cone s₀ >= ‖s₁‖, the others are at
least zero each; θ is a number of the constraint's own, as where along a chord a ball lies. Slacks and multipliers are
scaled by Nesterov and Todd's W, λ = W z = W⁻¹ s (Nesterov and Todd 1997; Vandenberghe, The CVXOPT linear and quadratic
cone program solvers, 2010, section 4).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Rows(NamedTuple):
    """Constraints, and their rows one after the other."""

    first: Indices
    """(n + 1,) first row of each constraint, and how many rows there are"""
    round: Indices
    """(n,) how many rows of a constraint, from its first on, form a second-order cone; 0 for none"""
    piece: Indices
    """(n,)"""
    shapes: Array
    """(n, 2 s) φ, of the unknowns at the two knots of the piece"""
    normals: Array
    """(rows, d + 1) N, and c in the last column"""
    bounds: Array
    """(rows,) b"""


class Scaling(NamedTuple):
    """W: of a row alone its own factor; of a second-order cone η and the unit vector w̄ in its rows."""

    direction: Array
    """(rows,)"""
    size: Array
    """(n,) η"""


@compiled
def products(rows: Rows, x: Array, theta: Array, out: Array) -> None:
    """Fill `out` (rows,) with N v + c θ for the unknowns x (N + 1, s, d) and θ (n,)."""
    s, dimensions = x.shape[1], x.shape[2]
    v = np.empty(dimensions)
    for p in range(rows.piece.size):
        i, shape = rows.piece[p], rows.shapes[p]
        for d in range(dimensions):
            v[d] = 0.0
            for k in range(s):
                v[d] += shape[k] * x[i, k, d] + shape[s + k] * x[i + 1, k, d]
        for r in range(rows.first[p], rows.first[p + 1]):
            out[r] = rows.normals[r, dimensions] * theta[p]
            for d in range(dimensions):
                out[r] += rows.normals[r, d] * v[d]


@compiled
def pulls(rows: Rows, z: Array, x: Array, theta: Array) -> None:
    """Add to `x` (N + 1, s, d) and fill `theta` (n,) with the transposed products of the multipliers z (rows,)."""
    s, dimensions = x.shape[1], x.shape[2]
    for p in range(rows.piece.size):
        i, shape = rows.piece[p], rows.shapes[p]
        theta[p] = 0.0
        for r in range(rows.first[p], rows.first[p + 1]):
            theta[p] += rows.normals[r, dimensions] * z[r]
        for d in range(dimensions):
            v = 0.0
            for r in range(rows.first[p], rows.first[p + 1]):
                v += rows.normals[r, d] * z[r]
            for k in range(s):
                x[i, k, d] += shape[k] * v
                x[i + 1, k, d] += shape[s + k] * v


@compiled
def determinant(u: Array, first: int, end: int) -> float:
    """Return u₀² - ‖u₁‖² of the rows of a second-order cone, without cancellation."""
    norm = 0.0
    for r in range(first + 1, end):
        norm += u[r] * u[r]
    norm = math.sqrt(norm)
    return float((u[first] - norm) * (u[first] + norm))


@compiled
def scale(rows: Rows, s: Array, z: Array, out: Scaling) -> None:
    """Fill `out` with the scaling of slacks and multipliers inside their cones."""
    for p in range(rows.piece.size):
        a, e = rows.first[p], rows.first[p] + rows.round[p]
        for r in range(e, rows.first[p + 1]):
            out.direction[r] = np.sqrt(s[r] / z[r])
        if e == a:
            continue
        of_s, of_z = np.sqrt(determinant(s, a, e)), np.sqrt(determinant(z, a, e))
        inner = s[a] * z[a]
        for r in range(a + 1, e):
            inner += s[r] * z[r]
        gamma = np.sqrt(0.5 * (1.0 + inner / (of_s * of_z)))
        out.size[p] = np.sqrt(of_s / of_z)
        norm = 1.0
        for r in range(a + 1, e):
            out.direction[r] = 0.5 * (s[r] / of_s - z[r] / of_z) / gamma
            norm += out.direction[r] ** 2
        out.direction[a] = np.sqrt(norm)


@compiled
def turn(rows: Rows, scaling: Scaling, p: int, sign: float, u: Array, out: Array) -> None:
    """Fill the rows of a constraint of `out` with W u for sign 1 and W⁻¹ u for sign -1."""
    a, e = rows.first[p], rows.first[p] + rows.round[p]
    for r in range(e, rows.first[p + 1]):
        out[r] = u[r] * scaling.direction[r] if sign > 0.0 else u[r] / scaling.direction[r]
    if e > a:
        head, inner = scaling.direction[a], 0.0
        size = scaling.size[p] if sign > 0.0 else 1.0 / scaling.size[p]
        for r in range(a + 1, e):
            inner += scaling.direction[r] * u[r]
        before = u[a]
        out[a] = size * (head * before + sign * inner)
        share = sign * before + inner / (1.0 + head)
        for r in range(a + 1, e):
            out[r] = size * (u[r] + share * scaling.direction[r])


@compiled
def unscaled(rows: Rows, scaling: Scaling, p: int, u: Array, out: Array) -> None:
    """Fill the rows of a constraint of `out` with W⁻² u."""
    a, e = rows.first[p], rows.first[p] + rows.round[p]
    for r in range(e, rows.first[p + 1]):
        out[r] = u[r] / (scaling.direction[r] * scaling.direction[r])
    if e > a:
        inner = scaling.direction[a] * u[a]
        for r in range(a + 1, e):
            inner -= scaling.direction[r] * u[r]
        size = 1.0 / (scaling.size[p] * scaling.size[p])
        out[a] = size * (2.0 * inner * scaling.direction[a] - u[a])
        for r in range(a + 1, e):
            out[r] = size * (u[r] - 2.0 * inner * scaling.direction[r])


@compiled
def weigh(rows: Rows, scaling: Scaling, p: int, inner: Array, out: Array) -> None:
    """Fill `out` (d + 1, d + 1) with (N, c)ᵀ W⁻² (N, c) of a constraint; `inner` (d + 1,) is to work in."""
    a, e, size = rows.first[p], rows.first[p] + rows.round[p], out.shape[0]
    out[:] = 0.0
    for r in range(e, rows.first[p + 1]):
        weight = 1.0 / (scaling.direction[r] * scaling.direction[r])
        for k in range(size):
            for m in range(k + 1):
                out[k, m] += weight * rows.normals[r, k] * rows.normals[r, m]
    if e > a:
        weight = 1.0 / (scaling.size[p] * scaling.size[p])
        for k in range(size):
            inner[k] = scaling.direction[a] * rows.normals[a, k]
            for r in range(a + 1, e):
                inner[k] -= scaling.direction[r] * rows.normals[r, k]
            for m in range(k + 1):
                total = 2.0 * inner[k] * inner[m] - rows.normals[a, k] * rows.normals[a, m]
                for r in range(a + 1, e):
                    total += rows.normals[r, k] * rows.normals[r, m]
                out[k, m] += weight * total
    for k in range(size):
        for m in range(k):
            out[m, k] = out[k, m]


@compiled
def correction(
    rows: Rows, scaling: Scaling, centre: float, s: Array, z: Array, step_s: Array, step_z: Array, out: Array
) -> None:
    """Fill `out` with W u, λ ∘ u = λ ∘ λ + W⁻¹ Δs ∘ W Δz - centre e: what slacks and multipliers are to lose."""
    lam, left, right = np.empty(s.size), np.empty(s.size), np.empty(s.size)
    for p in range(rows.piece.size):
        turn(rows, scaling, p, 1.0, z, lam)
        turn(rows, scaling, p, -1.0, step_s, left)
        turn(rows, scaling, p, 1.0, step_z, right)
        a, e = rows.first[p], rows.first[p] + rows.round[p]
        for r in range(e, rows.first[p + 1]):
            left[r] = (left[r] * right[r] - centre) / lam[r]
        if e > a:
            head = left[a] * right[a]
            for r in range(a + 1, e):
                head += left[r] * right[r]
                right[r] = left[a] * right[r] + right[a] * left[r]
            head -= centre
            inner = lam[a] * head
            for r in range(a + 1, e):
                inner -= lam[r] * right[r]
            left[a] = inner / determinant(lam, a, e)
            for r in range(a + 1, e):
                left[r] = (right[r] - left[a] * lam[r]) / lam[a]
        turn(rows, scaling, p, 1.0, left, out)
        for r in range(a, rows.first[p + 1]):
            out[r] += s[r]


@compiled
def longest(rows: Rows, u: Array, step: Array) -> float:
    """Return the largest factor, at most 1e10, for which u + factor * step stays in its cones."""
    most = 1e10
    for p in range(rows.piece.size):
        a, e = rows.first[p], rows.first[p] + rows.round[p]
        for r in range(e, rows.first[p + 1]):
            if step[r] < 0.0:
                most = min(most, -u[r] / step[r])
        if e > a:
            most = min(most, _reach(u, step, a, e))
    return most


@compiled
def _reach(u: Array, step: Array, first: int, end: int) -> float:
    """Return the first positive root of the determinant of u + t step, or infinity."""
    c = determinant(u, first, end)
    a, b = determinant(step, first, end), u[first] * step[first]
    for r in range(first + 1, end):
        b -= u[r] * step[r]
    root = b * b - a * c
    if (a > 0.0 and b > 0.0) or root < 0.0:
        return np.inf
    if a == 0.0:
        return -0.5 * c / b if b < 0.0 else np.inf
    t = -b + np.sqrt(root) if b <= 0.0 else -b - np.sqrt(root)
    first_root, other = (c / t, t / a) if t != 0.0 else (np.inf, np.inf)
    first_root = first_root if first_root > 0.0 else np.inf
    other = other if other > 0.0 else np.inf
    return min(first_root, other)


@compiled
def inside(rows: Rows, u: Array) -> float:
    """Return how far inside its cones u is: the least eigenvalue, negative outside."""
    least = np.inf
    for p in range(rows.piece.size):
        a, e = rows.first[p], rows.first[p] + rows.round[p]
        for r in range(e, rows.first[p + 1]):
            least = min(least, u[r])
        if e > a:
            norm = 0.0
            for r in range(a + 1, e):
                norm += u[r] * u[r]
            least = min(least, u[a] - np.sqrt(norm))
    return least


@compiled
def shift(rows: Rows, amount: float, u: Array) -> None:
    """Add a multiple of the unit element of the cones to u."""
    for p in range(rows.piece.size):
        a, e = rows.first[p], rows.first[p] + rows.round[p]
        for r in range(e, rows.first[p + 1]):
            u[r] += amount
        if e > a:
            u[a] += amount


def depths(rows: Rows, u: Array) -> Array:
    """Return how far inside its cones each constraint (n,) is."""
    if not len(rows.piece):
        return np.empty(0)
    owner = np.repeat(np.arange(len(rows.piece)), np.diff(rows.first))
    place = np.arange(len(owner)) - rows.first[owner]
    tail = (place > 0) & (place < rows.round[owner])
    norms = np.sqrt(np.bincount(owner, np.where(tail, u * u, 0.0), len(rows.piece)))
    least = np.where(tail, np.inf, u - np.where((place == 0) & (rows.round[owner] > 0), norms[owner], 0.0))
    return np.asarray(np.minimum.reduceat(least, rows.first[:-1]))
