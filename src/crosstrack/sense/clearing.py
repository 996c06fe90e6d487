"""What a scan takes away from the points that are held.

A point goes when rays went through it: the ray nearest to it measured more than it is away, by a margin, and so did the
eight around that ray. Where a surface is seen at a shallow angle, or ends, one of these is shorter, so that it is not
worn away; the ground is no such surface.

Points nearby are looked up with every scan, those farther away in turn, some thousand at once, in loops without
branches: of a hundred thousand a few dozen are worn.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sense.blocks import VOXELS, Blocks, Integers, give_back, remove
from crosstrack.sense.pose import Turn, entries, turned_to
from crosstrack.sense.range_image import RangeImage, Singles, nearest_rays, sights
from crosstrack.types import Array

BESIDE = 0.6
"""voxels, how far from a point a ray may pass that goes through it"""
BATCH = 2048
"""points that are looked up at once"""
NEARBY = 5.0
"""m, from the sensor, within which a point is looked up with every scan of it"""
TURNS = 5
"""scans of a sensor in which all others are"""


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
    """
    turn, points, end, now = entries(turned), blocks.points, blocks.pool[2], np.float32(when[0])
    lengths = np.zeros((len(free) + 1, 2), dtype=np.float32)  # the last for -1, no ray
    for ray in range(len(free)):
        lengths[ray, 0], lengths[ray, 1] = free[ray], shield[ray]
    image.scans[0] += 1
    x, y, z = np.empty(BATCH, dtype=np.float32), np.empty(BATCH, dtype=np.float32), np.empty(BATCH, dtype=np.float32)
    rays, worn, rows = np.empty(BATCH, dtype=np.int32), np.empty(BATCH, dtype=np.int64), np.empty(BATCH, dtype=np.int64)
    ox, oy, oz = np.float32(origin[0]), np.float32(origin[1]), np.float32(origin[2])
    while end > 0:  # from the last on: what is removed is replaced by the last
        batch, found = (end - 1) // BATCH, 0
        far = np.float32(NEARBY if (batch + image.scans[0]) % TURNS else math.inf)
        count = within(points, batch * BATCH, end, ox, oy, oz, far, rows)
        end = batch * BATCH
        for k in range(count):
            row = rows[k]
            x[k], y[k], z[k] = points[row, 0] - ox, points[row, 1] - oy, points[row, 2] - oz
        sights(image, turn, count, x, y, z)
        nearest_rays(image, count, x, y, rays)
        for k in range(count):
            ray = rays[k]
            x[k], y[k] = lengths[ray, 0] - z[k], lengths[ray, 1] - z[k]
        for k in range(count):
            row = rows[k]
            seen = points[row, 3]
            points[row, 3] = now if abs(x[k]) < margin else seen
            worn[found] = k
            found += (x[k] >= margin) & (y[k] >= margin)
        for n in range(found - 1, -1, -1):
            wear(blocks, rows[worn[n]], image.directions, rays[worn[n]], turn, origin, when)


@compiled
def within(
    points: Singles,
    first: int,
    end: int,
    ox: np.float32,
    oy: np.float32,
    oz: np.float32,
    most: np.float32,
    out: Integers,
) -> int:
    """Set which rows of `points`, from `first` to before `end`, are nearer than `most` (m); return how many are."""
    count = 0
    for row in range(first, end):
        x, y, z = points[row, 0] - ox, points[row, 1] - oy, points[row, 2] - oz
        out[count] = row
        count += x * x + y * y + z * z < most * most
    return count


@compiled
def wear(
    blocks: Blocks, row: int, directions: Array, ray: int, turn: Turn, origin: Array, when: tuple[float, float]
) -> None:
    """Trust a point less through which a ray went; take it away where it is trusted no more.

    Args:
        blocks: that hold the points
        row: of the point
        directions: (rays, 3) body
        ray: that went through it
        turn: body to world
        origin: (3,) m, world, of the sensor
        when: see `clear`
    """
    points, worth = blocks.points, blocks.worth
    x, y, z = points[row, 0] - origin[0], points[row, 1] - origin[1], points[row, 2] - origin[2]
    dx, dy, dz = turned_to(turn, directions[ray, 0], directions[ray, 1], directions[ray, 2])
    along = x * dx + y * dy + z * dz
    if x * x + y * y + z * z - along * along <= (BESIDE * blocks.cell) ** 2:
        worth[row, 1] -= 1
    elif points[row, 3] < when[1]:
        worth[row, 1] = 0
    if worth[row, 1] <= 0:
        b, p = blocks.owner[row] // VOXELS, blocks.owner[row] % VOXELS
        remove(blocks, b, p)
        if blocks.filled[b] == 0 and blocks.home[b] >= 0:  # what the window has left is given back as it is forgotten
            give_back(blocks, b)
