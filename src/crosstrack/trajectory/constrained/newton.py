"""The linear systems of the interior-point method, condensed on the knots.

    [ P   Nᵀ  ] [ x ]   [ f ]
    [ N  -W²  ] [ z ] = [ g ]

With z = W⁻² (N x - g) the constraints add to P what has its block structure; each constraint's own θ is eliminated
alone.
"""

from typing import NamedTuple

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory.constrained import chain
from crosstrack.trajectory.constrained.chain import Blocks
from crosstrack.trajectory.constrained.cones import Flags, Rows, Scaling, products, pulls, turn, unscaled, weigh
from crosstrack.types import Array


class Point(NamedTuple):
    """What the method moves, a direction to move it in, or a right side for it."""

    x: Array
    """(N + 1, s, d)"""
    theta: Array
    """(constraints,)"""
    s: Array
    """(rows,) slacks"""
    z: Array
    """(rows,) multipliers"""


class System(NamedTuple):
    """A factored system."""

    scaling: Scaling
    lower: Blocks
    own: Array
    """(n, d + 1) last row of (N, c)ᵀ W⁻² (N, c) of each constraint"""


def room(rows: Rows, fixed: Flags) -> System:
    """Return an empty system."""
    count = len(rows.piece)
    scaling = Scaling(np.ones(len(rows.bounds)), np.ones(count))
    return System(scaling, chain.blocks(len(fixed) - 1, fixed.shape[1]), np.empty((count, rows.normals.shape[1])))


@compiled
def factor(rows: Rows, forms: Array, fixed: Flags, out: System) -> float:
    """Fill `out` from its scaling and the quadratic forms (N, 2 s, 2 s); return the least relative pivot.

    Unknowns that are fixed (N + 1, m) stay zero.
    """
    dimensions = rows.normals.shape[1] - 1
    chain.assemble(forms, dimensions, out.lower)
    inner, whole = np.empty(dimensions + 1), np.empty((dimensions + 1, dimensions + 1))
    weight = np.empty((dimensions, dimensions))
    for p in range(rows.piece.size):
        weigh(rows, out.scaling, p, inner, whole)
        last = whole[dimensions, dimensions]
        for d in range(dimensions + 1):
            out.own[p, d] = whole[dimensions, d]
        for d in range(dimensions):
            for f in range(dimensions):
                taken = whole[d, dimensions] * whole[f, dimensions] / last if last > 0.0 else 0.0
                weight[d, f] = whole[d, f] - taken
        chain.add(rows.piece[p], rows.shapes[p], weight, out.lower)
    chain.hold(fixed, out.lower)
    return chain.factor(out.lower)


@compiled
def solve(rows: Rows, system: System, fixed: Flags, x: Array, theta: Array, z: Array) -> None:
    """Replace f, its part for θ, and g, as x (N + 1, s, d), `theta` (n,) and `z` (rows,), by the solution."""
    s, dimensions = x.shape[1], x.shape[2]
    image, own = np.empty(z.size), system.own
    for p in range(rows.piece.size):
        i, shape, a, e = rows.piece[p], rows.shapes[p], rows.first[p], rows.first[p + 1]
        unscaled(rows, system.scaling, p, z, image)
        for r in range(a, e):
            theta[p] += rows.normals[r, dimensions] * image[r]
        share = theta[p] / own[p, dimensions] if own[p, dimensions] > 0.0 else 0.0
        for d in range(dimensions):
            pull = -own[p, d] * share
            for r in range(a, e):
                pull += rows.normals[r, d] * image[r]
            for k in range(s):
                x[i, k, d] += shape[k] * pull
                x[i + 1, k, d] += shape[s + k] * pull
    flat = x.reshape((x.shape[0], s * dimensions))
    for i in range(flat.shape[0]):
        for k in range(flat.shape[1]):
            if fixed[i, k]:
                flat[i, k] = 0.0
    chain.substitute(system.lower, flat)
    recover(rows, system, x, theta, z, image)


@compiled
def recover(rows: Rows, system: System, x: Array, theta: Array, z: Array, image: Array) -> None:
    """Replace `theta` and g in `z` by the solution for known x; `image` (rows,) is to work in."""
    s, dimensions = x.shape[1], x.shape[2]
    v = np.empty(dimensions)
    for p in range(rows.piece.size):
        i, shape, own = rows.piece[p], rows.shapes[p], system.own[p]
        for d in range(dimensions):
            v[d] = 0.0
            for k in range(s):
                v[d] += shape[k] * x[i, k, d] + shape[s + k] * x[i + 1, k, d]
            theta[p] -= own[d] * v[d]
        theta[p] = theta[p] / own[dimensions] if own[dimensions] > 0.0 else 0.0
        for r in range(rows.first[p], rows.first[p + 1]):
            image[r] = rows.normals[r, dimensions] * theta[p] - z[r]
            for d in range(dimensions):
                image[r] += rows.normals[r, d] * v[d]
        unscaled(rows, system.scaling, p, image, z)


@compiled
def miss(rows: Rows, forms: Array, fixed: Flags, system: System, right: Point, found: Point, out: Point) -> None:
    """Fill x, θ and z of `out` with what a solution leaves of the right side; its slacks are to work in."""
    flat_fixed = fixed.reshape(out.x.shape)
    chain.gradient(forms, found.x, out.x)
    pulls(rows, found.z, out.x, out.theta)
    products(rows, found.x, found.theta, out.z)
    for p in range(rows.piece.size):
        out.theta[p] = right.theta[p] - out.theta[p]
        turn(rows, system.scaling, p, 1.0, found.z, out.s)
        turn(rows, system.scaling, p, 1.0, out.s, out.s)
    for r in range(out.z.size):
        out.z[r] = right.z[r] - out.z[r] + out.s[r]
    for i in np.ndindex(out.x.shape):
        out.x[i] = 0.0 if flat_fixed[i] else right.x[i] - out.x[i]
