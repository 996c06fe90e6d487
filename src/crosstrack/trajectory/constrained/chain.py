"""Quadratic costs of a chain of knots, and the block tridiagonal systems of their minimisation.

Every knot has m = s d unknowns, derivative by derivative, axis by axis. A segment couples those of its two knots, so
the matrix is a chain of blocks, factored from one end to the other as L Lᵀ in O(N m³).
"""

from typing import NamedTuple

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory.constrained.cones import Flags
from crosstrack.types import Array

TINY = 1e-15
"""of its diagonal entry, the least a pivot may be"""


class Blocks(NamedTuple):
    """A symmetric block tridiagonal matrix, or its factor L; the lower half of its diagonal blocks counts."""

    diagonal: Array
    """(N + 1, m, m)"""
    below: Array
    """(N, m, m), rows of knot i + 1, columns of knot i"""


def blocks(segments: int, unknowns: int) -> Blocks:
    """Return room for a matrix."""
    return Blocks(np.empty((segments + 1, unknowns, unknowns)), np.empty((segments, unknowns, unknowns)))


@compiled
def assemble(forms: Array, dimensions: int, out: Blocks) -> None:
    """Fill `out` with the sum of the quadratic forms (N, 2 s, 2 s) of the segments, each the same for every axis."""
    diagonal, below = out
    diagonal[:] = 0.0
    below[:] = 0.0
    s = forms.shape[1] // 2
    for i in range(forms.shape[0]):
        for k in range(s):
            for m in range(s):
                for d in range(dimensions):
                    row, column = k * dimensions + d, m * dimensions + d
                    diagonal[i, row, column] += forms[i, k, m]
                    diagonal[i + 1, row, column] += forms[i, s + k, s + m]
                    below[i, row, column] += forms[i, s + k, m]


@compiled
def add(piece: int, shape: Array, weight: Array, out: Blocks) -> None:
    """Add the form (φᵀ z)ᵀ W (φᵀ z) of a segment, with its shape φ (2 s,) and a symmetric weight W (d, d)."""
    diagonal, below = out
    s, dimensions = shape.size // 2, weight.shape[0]
    for k in range(s):
        for m in range(s):
            left, right, cross = shape[k] * shape[m], shape[s + k] * shape[s + m], shape[s + k] * shape[m]
            for d in range(dimensions):
                for e in range(dimensions):
                    row, column = k * dimensions + d, m * dimensions + e
                    if m <= k:
                        diagonal[piece, row, column] += left * weight[d, e]
                        diagonal[piece + 1, row, column] += right * weight[d, e]
                    below[piece, row, column] += cross * weight[d, e]


@compiled
def hold(fixed: Flags, out: Blocks) -> None:
    """Replace the rows and columns of the unknowns that are fixed (N + 1, m) by those of the identity."""
    diagonal, below = out
    last = fixed.shape[0] - 1
    for i in range(last + 1):
        for k in range(fixed.shape[1]):
            if fixed[i, k]:
                diagonal[i, k, :] = 0.0
                diagonal[i, :, k] = 0.0
                diagonal[i, k, k] = 1.0
                if i < last:
                    below[i, :, k] = 0.0
                if i > 0:
                    below[i - 1, k, :] = 0.0


@compiled
def factor(matrix: Blocks) -> float:
    """Replace a matrix by its factor L; return the least pivot relative to its diagonal entry, at least `TINY`."""
    diagonal, below = matrix
    least = 1.0
    size = diagonal.shape[1]
    for i in range(diagonal.shape[0]):
        block = diagonal[i]
        for k in range(size):
            whole = block[k, k]
            if i > 0:
                for m in range(k + 1):
                    value = 0.0
                    for n in range(size):
                        value += below[i - 1, k, n] * below[i - 1, m, n]
                    block[k, m] -= value
            for m in range(k):
                value = block[k, m]
                for n in range(m):
                    value -= block[k, n] * block[m, n]
                block[k, m] = value / block[m, m]
            pivot = block[k, k]
            for n in range(k):
                pivot -= block[k, n] * block[k, n]
            least = min(least, pivot / whole)
            block[k, k] = np.sqrt(max(pivot, TINY * whole))
        if i < below.shape[0]:
            for r in range(size):
                for k in range(size):
                    value = below[i, r, k]
                    for n in range(k):
                        value -= below[i, r, n] * block[k, n]
                    below[i, r, k] = value / block[k, k]
    return max(least, TINY)


@compiled
def substitute(lower: Blocks, right: Array) -> None:
    """Solve L Lᵀ x = right (N + 1, m) in place."""
    diagonal, below = lower
    count, size = right.shape
    for i in range(count):
        for k in range(size):
            value = right[i, k]
            if i > 0:
                for n in range(size):
                    value -= below[i - 1, k, n] * right[i - 1, n]
            for n in range(k):
                value -= diagonal[i, k, n] * right[i, n]
            right[i, k] = value / diagonal[i, k, k]
    for i in range(count - 1, -1, -1):
        if i < count - 1:
            for r in range(size):
                value = right[i + 1, r]
                for k in range(size):
                    right[i, k] -= below[i, r, k] * value
        for k in range(size - 1, -1, -1):
            right[i, k] /= diagonal[i, k, k]
            value = right[i, k]
            for n in range(k):
                right[i, n] -= diagonal[i, k, n] * value


@compiled
def gradient(forms: Array, x: Array, out: Array) -> None:
    """Fill `out` (N + 1, s, d) with the product of the assembled forms (N, 2 s, 2 s) and x (N + 1, s, d)."""
    s, dimensions = x.shape[1], x.shape[2]
    out[:] = 0.0
    for i in range(forms.shape[0]):
        for k in range(s):
            for d in range(dimensions):
                first, second = 0.0, 0.0
                for m in range(s):
                    first += forms[i, k, m] * x[i, m, d] + forms[i, k, s + m] * x[i + 1, m, d]
                    second += forms[i, s + k, m] * x[i, m, d] + forms[i, s + k, s + m] * x[i + 1, m, d]
                out[i, k, d] += first
                out[i + 1, k, d] += second
