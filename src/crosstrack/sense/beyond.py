"""What a scan suggests beyond its view: a surface seen at its upper or lower edge goes on, straight up or down.

A vehicle that climbs beside a trunk gets to where its sensor has not looked yet, and stops only after that. What is
assumed there goes as soon as a ray passes through it.
"""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sense.blocks import FULL, OUTSIDE, Blocks, frame, row_at
from crosstrack.sense.pose import entries, turned_to
from crosstrack.types import Array

NEARBY = 2.0
"""m, from the sensor, within which a surface is assumed to go on: what is farther comes into view before it matters"""
BEYOND = 0.5
"""m, that it goes on"""
SPACING = 0.1
"""m, between the points that stand for it"""


@compiled
def beyond(ranges: Array, directions: Array, turned: Array, origin: Array, rows: int, floor: float) -> Array:
    """Return points (n, 3) m, world, of what a scan suggests beyond its view.

    Args:
        ranges: (rays,) m, inf where there is nothing to add
        directions: (rays, 3) body, row by row, the rows from below or from above
        turned: (3, 3) body to world
        origin: (3,) m, world, of the sensor
        rows: of the picture that the rays form
        floor: m, below which nothing goes on
    """
    turn, columns = entries(turned), len(ranges) // rows
    last, steps = len(ranges) - columns, round(BEYOND / SPACING)
    out, count = np.empty((2 * columns * steps, 3)), 0
    upwards = 1.0 if directions[last, 2] > directions[0, 2] else -1.0
    for column in range(2 * columns):
        ray, rise = (column, -upwards) if column < columns else (last + column - columns, upwards)
        r = ranges[ray]
        if r > NEARBY:
            continue
        x, y, z = turned_to(turn, directions[ray, 0], directions[ray, 1], directions[ray, 2])
        for step in range(1, steps + 1):
            height = origin[2] + r * z + rise * step * SPACING
            if height > floor:
                out[count, 0], out[count, 1], out[count, 2] = origin[0] + r * x, origin[1] + r * y, height
                count += 1
    return out[:count]


@compiled
def assume(blocks: Blocks, points: Array, time: float, first: int) -> int:
    """Add points (n, 3) m to voxels that hold none, from `first` on; return the one for which there was no room, or n.

    The first ray through such a point takes it away.
    """
    window, worth = frame(blocks), blocks.worth
    for n in range(first, len(points)):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        row = row_at(blocks, window, x, y, z)
        if row == FULL:
            return n
        if row != OUTSIDE and worth[row, 0] == 0:
            blocks.points[row, 0], blocks.points[row, 1], blocks.points[row, 2] = x, y, z
            blocks.points[row, 3], worth[row, 0], worth[row, 1] = time, 1, 1
    return len(points)
