"""Functions of vectors (3,) that several roles need, compiled: numpy takes twice as long for three numbers."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array


@compiled
def dot(a: Array, b: Array) -> float:
    """Return the scalar product."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@compiled
def norm(vector: Array) -> float:
    """Return the length."""
    return math.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])


@compiled
def across(vector: Array, along: Array) -> Array:
    """Return the part of a vector that is perpendicular to a unit vector."""
    part = dot(vector, along)
    out = np.empty(3)
    for k in range(3):
        out[k] = vector[k] - part * along[k]
    return out


@compiled
def direction(vector: Array) -> Array:
    """Return the unit vector, zero for zero."""
    size, out = norm(vector), np.zeros(3)
    if size > 1e-9:
        for k in range(3):
            out[k] = vector[k] / size
    return out


@compiled
def limited(vector: Array, most: float) -> Array:
    """Return the vector, shortened to the length `most` where it is longer."""
    size, out = norm(vector), np.empty(3)
    scale = most / size if size > most else 1.0
    for k in range(3):
        out[k] = scale * vector[k]
    return out
