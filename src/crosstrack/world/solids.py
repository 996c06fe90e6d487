"""Exact signed distance to one solid, and its gradient.

A solid that is a plane outline times an interval of heights has, from its distance d₂ to the outline and d_z
to the interval, the signed distance √(d₂² + d_z²) where both are positive and max(d₂, d_z) elsewhere.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array

Flat = tuple[float, float, float]
Sample = tuple[float, float, float, float]


@compiled
def disc(x: float, y: float, cx: float, cy: float, radius: float) -> Flat:
    """Return the distance from a point to a disc and its gradient."""
    dx, dy = x - cx, y - cy
    r = math.sqrt(dx * dx + dy * dy)
    if r == 0.0:
        return -radius, 1.0, 0.0
    return r - radius, dx / r, dy / r


@compiled
def rectangle(x: float, y: float, lx: float, ly: float, hx: float, hy: float) -> Flat:
    """Return the distance from a point to a rectangle and its gradient."""
    sx = 1.0 if x - lx > hx - x else -1.0
    sy = 1.0 if y - ly > hy - y else -1.0
    dx, dy = max(lx - x, x - hx), max(ly - y, y - hy)
    if dx > 0.0 and dy > 0.0:
        d = math.sqrt(dx * dx + dy * dy)
        return d, sx * dx / d, sy * dy / d
    if dx > dy:
        return dx, sx, 0.0
    return dy, 0.0, sy


@compiled
def polygon(x: float, y: float, corners: Array, first: int, count: int) -> Flat:
    """Return the distance from a point to a counter-clockwise polygon and its gradient.

    The nearest point of the outline gives the size, the parity of edges crossed by a ray the sign.
    """
    best, nx, ny, ex, ey = math.inf, 0.0, 0.0, 0.0, 0.0
    inside = False
    ax, ay = corners[first + count - 1, 0], corners[first + count - 1, 1]
    for i in range(first, first + count):
        bx, by = corners[i, 0], corners[i, 1]
        dx, dy = bx - ax, by - ay
        along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)
        along = min(max(along, 0.0), 1.0)
        px, py = x - ax - along * dx, y - ay - along * dy
        square = px * px + py * py
        if square < best:
            best, nx, ny, ex, ey = square, px, py, dx, dy
        if (ay > y) != (by > y) and (x - ax < (y - ay) / dy * dx):
            inside = not inside
        ax, ay = bx, by
    d = math.sqrt(best)
    if d == 0.0:
        length = math.sqrt(ex * ex + ey * ey)
        return 0.0, ey / length, -ex / length
    if inside:
        return -d, -nx / d, -ny / d
    return d, nx / d, ny / d


@compiled
def extruded(flat: Flat, z: float, lo: float, hi: float) -> Sample:
    """Return the distance to a plane outline extruded over heights, from the distance to the outline."""
    d, gx, gy = flat
    sz = 1.0 if z - lo > hi - z else -1.0
    dz = max(lo - z, z - hi)
    if d > 0.0 and dz > 0.0:
        far = math.sqrt(d * d + dz * dz)
        return far, gx * d / far, gy * d / far, sz * dz / far
    if d > dz:
        return d, gx, gy, 0.0
    return dz, 0.0, 0.0, sz


@compiled
def sphere(x: float, y: float, z: float, cx: float, cy: float, cz: float, radius: float) -> Sample:
    """Return the distance from a point to a ball and its gradient."""
    dx, dy, dz = x - cx, y - cy, z - cz
    r = math.sqrt(dx * dx + dy * dy + dz * dz)
    if r == 0.0:
        return -radius, 0.0, 0.0, 1.0
    return r - radius, dx / r, dy / r, dz / r
