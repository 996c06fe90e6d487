"""Many rays from one point, against all obstacles.

All rays start at the same point, so the plane around it is cut into sectors once, and each sector lists the obstacles
that reach into it, the nearest first. A ray asks those of its own sector until the next begins farther away than the
nearest hit: one or two in a forest.

The sectors are even in the turn of a direction, t = d_y/(|d_x| + |d_y|) continued to [0, 4): it grows with the bearing,
opposite directions differ by 2, and it needs no trigonometry.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.nearest import box_distance
from crosstrack.world.rays import box_span, corners_of, entry, hit, ray_from, upright
from crosstrack.world.table import BOX, CYLINDER, Table

Indices = NDArray[np.int64]
ROUNDING = 1e-9


@compiled
def turn(dx: float, dy: float) -> float:
    """Return how far a plane direction has turned from east, counter-clockwise, in [0, 4]; 0 for none."""
    size = abs(dx) + abs(dy)
    if size == 0.0:
        return 0.0
    part = dy / size
    if dx < 0.0:
        return 2.0 - part
    return part if dy >= 0.0 else 4.0 + part


@compiled
def sector(dx: float, dy: float, count: int) -> int:
    """Return the sector of a plane direction, of so many."""
    return min(int(turn(dx, dy) * (0.25 * count)), count - 1)


@compiled
def within(table: Table, origin: Array, reach: float) -> Indices:
    """Return the obstacles whose box is within reach (m) of a point."""
    found, stack = np.empty(len(table.kinds), dtype=np.int64), np.empty(64, dtype=np.int64)
    count, top = 0, 1
    stack[0] = 0
    x, y, z = origin[0], origin[1], origin[2]
    while top > 0:
        top -= 1
        node = stack[top]
        if box_distance(table.nodes[node], x, y, z) > reach:
            continue
        first, many = table.links[node, 0], table.links[node, 1]
        if many == 0:
            stack[top], stack[top + 1] = first, node + 1
            top += 2
            continue
        for i in range(first, first + many):
            if box_distance(table.boxes[i], x, y, z) <= reach:
                found[count] = i
                count += 1
    return found[:count]


@compiled
def plan_distance(box: Array, origin: Array) -> float:
    """Return the distance in the plane from a point to a box, 0 inside."""
    dx = max(box[0] - origin[0], origin[0] - box[3], 0.0)
    dy = max(box[1] - origin[1], origin[1] - box[4], 0.0)
    return math.sqrt(dx * dx + dy * dy)


@compiled
def covered(box: Array, origin: Array, count: int) -> tuple[int, int]:
    """Return the first and the last sector that a box reaches into; to be wrapped into [0, count)."""
    lx, ly, hx, hy = box[0] - origin[0], box[1] - origin[1], box[3] - origin[0], box[4] - origin[1]
    if lx <= 0.0 <= hx and ly <= 0.0 <= hy:
        return 0, count - 1
    middle = turn(lx + hx, ly + hy)
    least = most = 0.0
    for corner in range(4):
        beside = turn(hx if corner & 1 else lx, hy if corner & 2 else ly) - middle
        beside -= 4.0 * math.floor((beside + 2.0) / 4.0)
        least, most = min(least, beside), max(most, beside)
    scale = 0.25 * count
    first = math.floor((middle + least - ROUNDING) * scale)
    return first, min(math.floor((middle + most + ROUNDING) * scale), first + count - 1)


@compiled
def listed(table: Table, origin: Array, found: Indices, count: int) -> tuple[Indices, Indices]:
    """Return the obstacles of each sector as places in `found`: where each list begins (count + 1,), and the lists."""
    spans = np.empty((len(found), 2), dtype=np.int64)
    starts = np.zeros(count + 1, dtype=np.int64)
    for k in range(len(found)):
        spans[k, 0], spans[k, 1] = covered(table.boxes[found[k]], origin, count)
        for s in range(spans[k, 0], spans[k, 1] + 1):
            starts[s % count + 1] += 1
    for s in range(count):
        starts[s + 1] += starts[s]
    lists, filled = np.empty(starts[count], dtype=np.int64), starts[:count].copy()
    for k in range(len(found)):
        for s in range(spans[k, 0], spans[k, 1] + 1):
            lists[filled[s % count]] = k
            filled[s % count] += 1
    return starts, lists


@compiled
def cast(table: Table, origin: Array, directions: Array, reach: float) -> Array:
    """Return how far (n,) m rays go from a point (3,) along unit vectors (n, 3); inf where not within reach (m)."""
    return traced(table, origin, directions, reach)[0]


@compiled
def traced(table: Table, origin: Array, directions: Array, reach: float) -> tuple[Array, Indices]:
    """Return what `cast` does, and which obstacle each ray hits (n,), -1 where none."""
    found = within(table, origin, reach)
    near = np.empty(len(found))
    for k in range(len(found)):
        near[k] = plan_distance(table.boxes[found[k]], origin)
    order = np.argsort(near)
    found, near = found[order], near[order]
    count = min(max(len(directions) // 8, 16), 1024)
    starts, lists = listed(table, origin, found, count)
    kinds, numbers = table.kinds, table.numbers
    out, struck = np.empty(len(directions)), np.empty(len(directions), dtype=np.int64)
    whole = corners_of(table.nodes, 0)
    for r in range(len(directions)):
        ray = ray_from(origin[0], origin[1], origin[2], directions[r, 0], directions[r, 1], directions[r, 2])
        flat, best, first = math.sqrt(ray[3] * ray[3] + ray[4] * ray[4]), math.inf, -1
        ahead = min(reach, box_span(ray, whole)[1] + ROUNDING)
        s = sector(ray[3], ray[4], count)
        for at in range(starts[s], starts[s + 1]):
            k = lists[at]
            if near[k] > ahead * flat + ROUNDING:
                break
            i = found[k]
            if kinds[i] == CYLINDER:  # the commonest kinds are met here: a table passed on costs more than its boxes
                axis = numbers[i, 0], numbers[i, 1], numbers[i, 2]
                t = upright(ray, axis, numbers[i, 3], numbers[i, 4])
            elif kinds[i] == BOX:
                t = entry(box_span(ray, corners_of(numbers, i)))
            else:
                t = hit(table, i, ray, ahead)
            if t <= ahead:
                best = ahead = t
                first = i
        out[r], struck[r] = best, first
    return out, struck
