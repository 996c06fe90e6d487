"""What the vehicles of the environments see: ranges along beams fixed to their bodies, and how near obstacles are."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.nearest import box_distance, least_any, least_convex, slope
from crosstrack.world.rays import hit, ray_from
from crosstrack.world.table import CYLINDER, SPHERE, Table

Indices = NDArray[np.int64]


@compiled
def around(table: Table, first: int, end: int, x: float, y: float, reach: float, found: Indices) -> int:
    """Write which obstacles have a box within reach (m) of a point in the plane; return how many."""
    count, boxes = 0, table.boxes
    square = reach * reach
    for i in range(first, end):
        dx, dy = max(boxes[i, 0] - x, x - boxes[i, 3], 0.0), max(boxes[i, 1] - y, y - boxes[i, 4], 0.0)
        if dx * dx + dy * dy <= square:
            found[count] = i
            count += 1
    return count


@compiled
def look(
    table: Table, found: Indices, count: int, body: Array, beams: Array, reach: float, ground: float, rays: Array
) -> None:
    """Write how far (m) beams go until they hit an obstacle or the ground; `reach` where nothing is hit.

    From a height between the ends of an upright cylinder a ray enters it through its side or not at all, and all rays
    are asked at once.

    Args:
        table: of obstacles
        found: which of them may be within reach
        count: how many these are
        body: (13,) or more: position (m), then velocity, attitude xyzw
        beams: (rays, 3) unit vectors, body
        reach: m
        ground: m, height of it
        rays: (5, rays) changed: how far, direction in the world, one over the square of its level part
    """
    turned(body, beams, rays)
    px, py, pz = body[0], body[1], body[2]
    ranges, east, north, up, level = rays[0], rays[1], rays[2], rays[3], rays[4]
    many, height = len(ranges), pz - ground
    for r in range(many):
        ranges[r] = max(0.0, -height / up[r]) if -up[r] * reach > height else reach
    kinds, numbers = table.kinds, table.numbers
    for k in range(count):
        i = found[k]
        if kinds[i] == CYLINDER and numbers[i, 3] <= pz <= numbers[i, 4]:
            ox, oy = px - numbers[i, 0], py - numbers[i, 1]
            c, low, high = ox * ox + oy * oy - numbers[i, 2] ** 2, numbers[i, 3] - pz, numbers[i, 4] - pz
            for r in range(many):
                b = (ox * east[r] + oy * north[r]) * level[r]
                t = -b - math.sqrt(b * b - c * level[r])
                if 0.0 <= t < ranges[r] and low <= t * up[r] <= high:
                    ranges[r] = t
            if c <= 0.0:
                ranges[:] = 0.0
        else:
            for r in range(many):
                ray = ray_from(px, py, pz, east[r], north[r], up[r])
                ranges[r] = min(ranges[r], hit(table, i, ray, ranges[r]))


@compiled
def turned(body: Array, beams: Array, rays: Array) -> None:
    """Write the directions of beams in the world, and one over the square of their level part, see `look`."""
    x, y, z, w = body[6], body[7], body[8], body[9]
    r00, r01, r02 = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    r10, r11, r12 = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    r20, r21, r22 = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    for r in range(beams.shape[0]):
        bx, by, bz = beams[r, 0], beams[r, 1], beams[r, 2]
        dx, dy = r00 * bx + r01 * by + r02 * bz, r10 * bx + r11 * by + r12 * bz
        rays[1, r], rays[2, r], rays[3, r] = dx, dy, r20 * bx + r21 * by + r22 * bz
        rays[4, r] = 1.0 / max(1e-18, dx * dx + dy * dy)


@compiled
def nearest(table: Table, found: Indices, count: int, start: Array, x: float, y: float, z: float, most: float) -> float:
    """Return the least signed distance (m) along a segment to some obstacles; `most` where it is not below that.

    Args:
        table: of obstacles
        found: which of them
        count: how many these are
        start: (3,) m
        x: m, its end
        y: m
        z: m
        most: m
    """
    dx, dy, dz = x - start[0], y - start[1], z - start[2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    unit = 1.0 / length if length > 0.0 else 0.0
    segment = (start[0], start[1], start[2], unit * dx, unit * dy, unit * dz, length)
    half = 0.5 * length
    mx, my, mz = x - 0.5 * dx, y - 0.5 * dy, z - 0.5 * dz
    best = most
    for k in range(count):
        i = found[k]
        if box_distance(table.boxes[i], mx, my, mz) - slope(table.kinds[i]) * half >= best:
            continue
        if table.kinds[i] <= SPHERE:
            best = min(best, least_convex(table, i, segment, best))
        else:
            best = min(best, least_any(table, i, segment, best))
    return best
