"""What a scan says of obstacles: how far its rays went, which of them hit one, and the points that these become."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sense.blocks import FULL, MOST_HITS, MOST_TRUST, OUTSIDE, Blocks, frame, row_at
from crosstrack.sense.pose import entries, turned_to
from crosstrack.types import Array


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
def add_hits(
    blocks: Blocks, ranges: Array, directions: Array, turned: Array, origin: Array, time: float, first: int
) -> int:
    """Add the hits of a scan from ray `first` on; return the ray for which there was no room, their number at the end.

    Args:
        blocks: that hold the points
        ranges: (rays,) m, inf where there is nothing to add
        directions: (rays, 3) body
        turned: (3, 3) body to world
        origin: (3,) m, world, of the sensor
        time: s
        first: where to begin
    """
    turn, window = entries(turned), frame(blocks)
    worth, points = blocks.worth, blocks.points
    for ray in range(first, len(ranges)):
        r = ranges[ray]
        if r == math.inf:
            continue
        x, y, z = turned_to(turn, directions[ray, 0], directions[ray, 1], directions[ray, 2])
        x, y, z = origin[0] + r * x, origin[1] + r * y, origin[2] + r * z
        row = row_at(blocks, window, x, y, z)
        if row == FULL:
            return ray
        if row == OUTSIDE:
            continue
        hits = min(worth[row, 0] + 1, MOST_HITS)
        worth[row, 0], worth[row, 1] = hits, min(worth[row, 1] + 1, MOST_TRUST)
        points[row, 0] += (x - points[row, 0]) / hits
        points[row, 1] += (y - points[row, 1]) / hits
        points[row, 2] += (z - points[row, 2]) / hits
        points[row, 3] = time
    return len(ranges)
