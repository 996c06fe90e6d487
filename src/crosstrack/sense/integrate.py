"""What one scan changes in the points that are held.

Hits on obstacles become points. A point goes when rays went through it: the ray nearest to it measured more than it is
away, by a margin, and so did the eight around that ray. Where a surface is seen at a shallow angle, or ends, one of
these is shorter, so that it is not worn away; the ground is no such surface.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sense.blocks import (
    MOST_TRUST,
    MOST_WEIGHT,
    Blocks,
    coarse,
    fourth,
    frame,
    give_back,
    remove,
    start_point,
    take,
)
from crosstrack.sense.pose import entries, turned_back, turned_to
from crosstrack.sense.range_image import RangeImage, texel
from crosstrack.types import Array

BESIDE = 0.6
"""voxels, how far from a point a ray may pass that goes through it"""


@compiled
def free_lengths(ranges: Array, most: float) -> Array:
    """Return how far (n,) m each ray has seen space to be free: 0 where nothing was measured, `most` without a hit."""
    out = np.empty(len(ranges))
    for i in range(len(ranges)):
        out[i] = ranges[i] if ranges[i] <= most else (0.0 if math.isnan(ranges[i]) else most)
    return out


@compiled
def off_ground(ranges: Array, directions: Array, turned: Array, height: float, tolerance: float) -> Array:
    """Return ranges (n,) m with inf for those that hit the ground or nothing.

    Args:
        ranges: (n,) m
        directions: (n, 3) body
        turned: (3, 3) body to world
        height: m, of the sensor above the ground
        tolerance: m, above the ground up to which a hit is one of the ground
    """
    out = np.empty(len(ranges))
    for i in range(len(ranges)):
        r = ranges[i]
        rise = turned[2, 0] * directions[i, 0] + turned[2, 1] * directions[i, 1] + turned[2, 2] * directions[i, 2]
        out[i] = r if r < math.inf and height + r * rise > tolerance else math.inf
    return out


@compiled
def clear(
    blocks: Blocks,
    image: RangeImage,
    free: Array,
    shield: Array,
    turned: Array,
    origin: Array,
    when: tuple[float, float],
    margin: float,
    reach: float,
) -> None:
    """Take away the points that a scan has seen through often enough, or long after they were last seen.

    Args:
        blocks: that hold the points
        image: of the scan's rays
        free: (rays,) m, how far each has seen space to be free
        shield: (rays,) m, the least range to an obstacle of each and those around it
        turned: (3, 3) body to world
        origin: (3,) m, world, of the sensor
        when: s, of the scan, and before which a point must have been seen last to go where rays pass by it only closely
        margin: m, beyond a point that a ray must have gone
        reach: m, of the sensor
    """
    aside, far = (BESIDE * blocks.cell) ** 2, (reach + 4.0 * blocks.cell) ** 2
    turn, start, scale = entries(turned), image.start, image.scale
    around, high = image.rays.shape
    points, count, seen, trust, to = blocks.points, blocks.filled, blocks.seen, blocks.trust, image.directions
    for b in range(blocks.pool[0]):
        for p in range(count[b] - 1, -1, -1):
            x, y, z = points[b, 0, p] - origin[0], points[b, 1, p] - origin[1], points[b, 2, p] - origin[2]
            square = x * x + y * y + z * z
            if square > far:
                break
            bx, by, bz = turned_back(turn, x, y, z)
            i, j = texel(bx, by, bz, start, scale)
            ray = image.rays[i % around, j] if 0 <= j < high else -1
            r = math.sqrt(square)
            if ray < 0 or free[ray] <= r - margin:
                continue
            if free[ray] < r + margin:
                seen[b, p] = when[0]
            elif shield[ray] >= r + margin:
                along = bx * to[ray, 0] + by * to[ray, 1] + bz * to[ray, 2]
                if square - along * along <= aside:
                    trust[b, p] -= 1
                elif seen[b, p] < when[1]:
                    trust[b, p] = 0
                if trust[b, p] <= 0:
                    remove(blocks, b, p)
                    if count[b] == 0:
                        give_back(blocks, b)


@compiled
def add_hits(
    blocks: Blocks, ranges: Array, directions: Array, turned: Array, origin: Array, time: float, first: int
) -> int:
    """Add the hits of a scan from ray `first` on; return the ray at which the pool was empty, their number at the end.

    Args:
        blocks: that hold the points
        ranges: (rays,) m, inf where there is nothing to add
        directions: (rays, 3) body
        turned: (3, 3) body to world
        origin: (3,) m, world, of the sensor
        time: s
        first: where to begin
    """
    turn, cell, window, index, slot = entries(turned), blocks.cell, frame(blocks), blocks.parts, blocks.slot
    for ray in range(first, len(ranges)):
        r = ranges[ray]
        if r == math.inf:
            continue
        x, y, z = turned_to(turn, directions[ray, 0], directions[ray, 1], directions[ray, 2])
        x, y, z = origin[0] + r * x, origin[1] + r * y, origin[2] + r * z
        i, j, k = math.floor(x / cell), math.floor(y / cell), math.floor(z / cell)
        cube = coarse(window, i >> 4, j >> 4, k >> 4)
        if cube < 0:
            continue
        part, voxel = fourth(i >> 2, j >> 2, k >> 2), fourth(i, j, k)
        b = index[cube, part]
        if b < 0:
            b = take(blocks, cube, part, (i >> 2, j >> 2, k >> 2))
            if b < 0:
                return ray
        p = slot[b, voxel]
        if p < 0:
            p = start_point(blocks, b, voxel)
        weight = min(blocks.weight[b, p] + 1.0, MOST_WEIGHT)
        blocks.weight[b, p] = weight
        blocks.points[b, 0, p] += (x - blocks.points[b, 0, p]) / weight
        blocks.points[b, 1, p] += (y - blocks.points[b, 1, p]) / weight
        blocks.points[b, 2, p] += (z - blocks.points[b, 2, p]) / weight
        blocks.trust[b, p] = min(blocks.trust[b, p] + 1, MOST_TRUST)
        blocks.seen[b, p] = time
    return len(ranges)
