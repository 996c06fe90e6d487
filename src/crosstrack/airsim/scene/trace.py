"""Rays from one point to the first thing that they hit: obstacles, the ground, or other vehicles."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.nearest import sample
from crosstrack.world.sectors import traced
from crosstrack.world.table import Table

Numbers = NDArray[np.int64]
SKY, GROUND = 0, 1
"""numbers of the first two things of a scene"""
STANDING = 0.1
"""m, above the ground, that rays begin at least: what carries them has a body"""
BEFORE = 1e-3
"""m, before a surface, where its normal is looked up: on it the side is a matter of rounding"""


@compiled
def ball_ahead(balls: Array, k: int, origin: Array, dx: float, dy: float, dz: float) -> float:
    """Return how far a ray goes until it enters a ball, inf where it does not or begins in it."""
    px, py, pz = origin[0] - balls[k, 0], origin[1] - balls[k, 1], origin[2] - balls[k, 2]
    b, c = px * dx + py * dy + pz * dz, px * px + py * py + pz * pz - balls[k, 3] * balls[k, 3]
    square = b * b - c
    if square < 0.0 or b > 0.0 or c < 0.0:
        return math.inf
    return float(-b - math.sqrt(square))


@compiled
def look(
    table: Table, owners: Numbers, balls: Array, origin: Array, directions: Array, reach: float, ground: float
) -> tuple[Array, Numbers, Numbers]:
    """Return how far rays go (n,) m, which thing each hits (n,), and which row of the table (n,), -1 for another thing.

    Args:
        table: obstacles
        owners: (rows,) which thing each obstacle belongs to; balls count on from the largest
        balls: (k, 4) centres and radii of other vehicles, m
        origin: (3,) m, ENU
        directions: (n, 3) unit vectors, ENU
        reach: m, beyond which there is only sky, at inf
        ground: m, its height
    """
    ranges, rows = traced(table, origin, directions, reach)
    seen, after = np.empty(len(ranges), dtype=np.int64), GROUND + 1
    for i in range(len(owners)):
        after = max(after, owners[i] + 1)
    height = max(origin[2] - ground, STANDING)
    for r in range(len(ranges)):
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        t, row = ranges[r], rows[r]
        what = owners[row] if row >= 0 else SKY
        if -dz * min(t, reach) >= height:
            t, what, row = -height / dz, GROUND, -1
        for k in range(len(balls)):
            d = ball_ahead(balls, k, origin, dx, dy, dz)
            if d < t and d <= reach:
                t, what, row = d, after + k, -1
        ranges[r], seen[r], rows[r] = t, what, row
    return ranges, seen, rows


@compiled
def normal(
    table: Table, balls: Array, after: int, what: int, row: int, point: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the unit vector out of an obstacle or a vehicle, just before whose surface a point (m) lies."""
    if row >= 0:
        _, x, y, z = sample(table, row, point[0], point[1], point[2])
    else:
        k = what - after
        x, y, z = point[0] - balls[k, 0], point[1] - balls[k, 1], point[2] - balls[k, 2]
    size = math.sqrt(x * x + y * y + z * z)
    return (x / size, y / size, z / size) if size > 0.0 else (0.0, 0.0, 0.0)


@compiled
def normals(
    table: Table,
    balls: Array,
    after: int,
    origin: Array,
    directions: Array,
    ranges: Array,
    seen: Numbers,
    rows: Numbers,
) -> Array:
    """Return the unit vectors (n, 3) out of what rays hit, ENU; zero for the sky."""
    out = np.zeros((len(ranges), 3))
    for r in range(len(ranges)):
        if seen[r] == GROUND:
            out[r, 2] = 1.0
        if seen[r] <= GROUND:
            continue
        t = ranges[r] - BEFORE
        point = (
            origin[0] + t * directions[r, 0],
            origin[1] + t * directions[r, 1],
            origin[2] + t * directions[r, 2],
        )
        out[r, 0], out[r, 1], out[r, 2] = normal(table, balls, after, seen[r], rows[r], point)
    return out
