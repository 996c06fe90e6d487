"""The nearest of many obstacles to a point, and along a straight segment.

A box around an obstacle is at no greater signed distance than the obstacle, inside it as outside, so a node
of the tree whose box is farther than the best found so far is left out without changing the answer.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.lattice import relief, voxels
from crosstrack.world.solids import Sample, disc, extruded, polygon, rectangle, sphere
from crosstrack.world.table import BOX, CYLINDER, PRISM, RELIEF, SPHERE, VOXELS, Table

TOLERANCE = 1e-3
FINE_TOLERANCE = 1e-6
PIECE = 4.0
MOST_PIECES = 4096

Segment = tuple[float, float, float, float, float, float, float]


@compiled
def sample(table: Table, i: int, x: float, y: float, z: float) -> Sample:
    """Return the signed distance to obstacle `i` and its gradient."""
    kind, n = table.kinds[i], table.numbers[i]
    if kind == BOX:
        return extruded(rectangle(x, y, n[0], n[1], n[3], n[4]), z, n[2], n[5])
    if kind == CYLINDER:
        return extruded(disc(x, y, n[0], n[1], n[2]), z, n[3], n[4])
    if kind == SPHERE:
        return sphere(x, y, z, n[0], n[1], n[2], n[3])
    if kind == PRISM:
        return extruded(polygon(x, y, table.corners, int(n[0]), int(n[1])), z, n[2], n[3])
    if kind == RELIEF:
        return extruded(relief(x, y, n, table.boxes[i], table.values), z, n[6], n[7])
    return voxels(x, y, z, n, table.boxes[i], table.values)


@compiled
def slope(kind: int) -> float:
    """Return the most by which the distance to an obstacle of a kind changes per metre."""
    if kind == RELIEF:
        return math.sqrt(2.0)
    if kind == VOXELS:
        return math.sqrt(3.0)
    return 1.0


@compiled
def least_convex(table: Table, i: int, segment: Segment, best: float) -> float:
    """Return the least distance to a convex obstacle along a segment; some distance if none is below `best`.

    The signed distance to a convex body is convex, so the two tangents at the ends of an interval bound it
    from below and the sign of the slope says which half holds the least.
    """
    x, y, z, dx, dy, dz, high = segment
    low = 0.0
    low_d, gx, gy, gz = sample(table, i, x, y, z)
    low_slope = gx * dx + gy * dy + gz * dz
    if low_slope >= 0.0:
        return low_d
    high_d, gx, gy, gz = sample(table, i, x + high * dx, y + high * dy, z + high * dz)
    high_slope = gx * dx + gy * dy + gz * dz
    if high_slope <= 0.0:
        return high_d
    while True:
        meet = (low_d - high_d + high_slope * (high - low)) / (high_slope - low_slope)
        least = min(low_d, high_d)
        if low_d + low_slope * meet >= min(least, best) - FINE_TOLERANCE:
            return least
        s = 0.5 * (low + high)
        if s <= low or s >= high:
            return least
        d, gx, gy, gz = sample(table, i, x + s * dx, y + s * dy, z + s * dz)
        along = gx * dx + gy * dy + gz * dz
        if along < 0.0:
            low, low_d, low_slope = s, d, along
        elif along > 0.0:
            high, high_d, high_slope = s, d, along
        else:
            return d


@compiled
def least_any(table: Table, i: int, segment: Segment, best: float) -> float:
    """Return the least distance to an obstacle along a segment; some distance if none is below `best`.

    With slope at most k and values d, d' at two points h apart, nothing between is below (d + d' - k h)/2; a
    step of (d - best + 2 tolerance)/k therefore misses nothing lower than the best by more than the
    tolerance, even where d' is the new best.
    """
    x, y, z, dx, dy, dz, length = segment
    steep = slope(table.kinds[i])
    s = 0.0
    d = sample(table, i, x, y, z)[0]
    least: float = min(d, sample(table, i, x + length * dx, y + length * dy, z + length * dz)[0])
    while s < length:
        s += (d - min(least, best) + 2.0 * TOLERANCE) / steep
        if s < length:
            d = sample(table, i, x + s * dx, y + s * dy, z + s * dz)[0]
            least = min(least, d)
    return least


@compiled
def box_distance(box: Array, x: float, y: float, z: float) -> float:
    """Return the signed distance from a point to a box."""
    dx = max(box[0] - x, x - box[3])
    dy = max(box[1] - y, y - box[4])
    dz = max(box[2] - z, z - box[5])
    if dx <= 0.0 and dy <= 0.0 and dz <= 0.0:
        return float(max(dx, dy, dz))
    dx, dy, dz = max(dx, 0.0), max(dy, 0.0), max(dz, 0.0)
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@compiled
def search(table: Table, segment: Segment, best: float, stack: Array) -> tuple[float, int]:
    """Return the least distance along a segment if below `best`, and which obstacle has it (-1: none).

    Args:
        table: of obstacles
        segment: start (m), direction (unit), length (m); a length of 0 asks about a point
        best: m, known already
        stack: (64, 2) room to work in: the depth of a tree of halves is below 64
    """
    half = 0.5 * segment[6]
    x, y, z = segment[0] + half * segment[3], segment[1] + half * segment[4], segment[2] + half * segment[5]
    found, top = -1, 1
    stack[0, 0], stack[0, 1] = 0.0, box_distance(table.nodes[0], x, y, z) - half
    while top > 0:
        top -= 1
        if stack[top, 1] >= best:
            continue
        node = int(stack[top, 0])
        first, count = table.links[node, 0], table.links[node, 1]
        if count > 0:
            for i in range(first, first + count):
                d = sample(table, i, x, y, z)[0]
                if half > 0.0 and d - slope(table.kinds[i]) * half < best:
                    if table.kinds[i] <= SPHERE:
                        d = min(d, least_convex(table, i, segment, min(best, d)))
                    else:
                        d = min(d, least_any(table, i, segment, min(best, d)))
                if d < best:
                    best, found = d, i
        else:
            one = box_distance(table.nodes[node + 1], x, y, z) - half
            two = box_distance(table.nodes[first], x, y, z) - half
            near, far = (node + 1, first) if one < two else (first, node + 1)
            stack[top, 0], stack[top, 1] = far, max(one, two)
            stack[top + 1, 0], stack[top + 1, 1] = near, min(one, two)
            top += 2
    return best, found


@compiled
def distances(table: Table, points: Array) -> Array:
    """Return the signed distance from points (n, 3) to the nearest obstacle, (n,) m."""
    stack, out = np.empty((64, 2)), np.empty(len(points))
    for k in range(len(points)):
        segment = (points[k, 0], points[k, 1], points[k, 2], 0.0, 0.0, 0.0, 0.0)
        out[k] = search(table, segment, math.inf, stack)[0]
    return out


@compiled
def gradients(table: Table, points: Array) -> Array:
    """Return the gradient of the distance from points (n, 3) to the nearest obstacle, (n, 3)."""
    stack, out = np.empty((64, 2)), np.empty((len(points), 3))
    for k in range(len(points)):
        segment = (points[k, 0], points[k, 1], points[k, 2], 0.0, 0.0, 0.0, 0.0)
        i = search(table, segment, math.inf, stack)[1]
        _, out[k, 0], out[k, 1], out[k, 2] = sample(table, i, points[k, 0], points[k, 1], points[k, 2])
    return out


@compiled
def swept(table: Table, start: Array, end: Array) -> float:
    """Return the least signed distance along the segment between two points (3,), m.

    Long segments are taken in pieces, so that far branches of the tree are left out.
    """
    stack = np.empty((64, 2))
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    pieces = int(min(max(math.ceil(length / PIECE), 1.0), MOST_PIECES))
    unit = 1.0 / length if length > 0.0 else 0.0
    best = math.inf
    for piece in range(pieces):
        part = piece / pieces
        x, y, z = start[0] + part * dx, start[1] + part * dy, start[2] + part * dz
        segment = (x, y, z, unit * dx, unit * dy, unit * dz, length / pieces)
        best = min(best, search(table, segment, best, stack)[0])
    return best
