"""The nearest of the points to a point, and to a straight segment.

The coarse cubes around the middle of the segment are looked at from the nearest on. A cube or a block that is farther
from the middle than the best distance so far plus half the segment holds nothing nearer, so the answer is exact.
"""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sense.blocks import SIDE, VOXELS, Blocks, Integers, coarse, frame
from crosstrack.types import Array

TOLERANCE = 1e-3
"""m, of rays"""
PATIENCE = 2.0
"""m, the longest step along a ray"""

Segment = tuple[float, float, float, float, float, float, float]
"""middle (m), direction (unit), half its length (m)"""
Around = tuple[Integers, Array]
"""(n, 3) cubes around a cube, from the nearest on, and (n,) how many edges they are from it at least"""
Found = tuple[float, float, float, float]
"""m, distance and where the nearest point is"""


def around(reach: float, edge: float) -> Around:
    """Return the cubes around a cube that may be within reach (m) of half an edge beside it."""
    most = math.ceil(reach / edge + 0.5) + 1
    steps = np.arange(-most, most + 1)
    cubes = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    bounds = np.linalg.norm(np.maximum(np.abs(cubes) - 1, 0), axis=1)
    order = np.lexsort((np.abs(cubes).sum(axis=1), bounds))
    return cubes[order], bounds[order]


@compiled
def gap(x: float, low: float, edge: float) -> float:
    """Return how far a coordinate is outside [low, low + edge]."""
    return max(low - x, x - low - edge, 0.0)


@compiled
def square_to_cube(segment: Segment, i: int, j: int, k: int, edge: float) -> float:
    """Return the squared distance from the middle of a segment to a cube of a lattice with so long edges."""
    dx, dy, dz = gap(segment[0], i * edge, edge), gap(segment[1], j * edge, edge), gap(segment[2], k * edge, edge)
    return dx * dx + dy * dy + dz * dz


@compiled
def square_to_point(segment: Segment, px: float, py: float, pz: float) -> float:
    """Return the squared distance from a point to a segment."""
    x, y, z, ux, uy, uz, half = segment
    rx, ry, rz = px - x, py - y, pz - z
    along = min(max(rx * ux + ry * uy + rz * uz, -half), half)
    rx, ry, rz = rx - along * ux, ry - along * uy, rz - along * uz
    return rx * rx + ry * ry + rz * rz


@compiled
def nearest(blocks: Blocks, around: Around, segment: Segment, best: Found) -> Found:
    """Return the point nearest to a segment if it is nearer than the best so far."""
    cubes, bounds = around
    window, index, active, count = frame(blocks), blocks.parts, blocks.active, blocks.filled
    members, points = blocks.members, blocks.points
    edge, half = blocks.cell * SIDE, segment[6]
    i, j, k = math.floor(segment[0] / edge), math.floor(segment[1] / edge), math.floor(segment[2] / edge)
    least, far = best[0] * best[0], best[0] + half
    found = -1
    for c in range(len(bounds)):
        if bounds[c] * edge >= far:
            break
        ci, cj, ck = i + cubes[c, 0], j + cubes[c, 1], k + cubes[c, 2]
        cube = coarse(window, ci, cj, ck)
        if cube < 0 or active[cube] == 0 or square_to_cube(segment, ci, cj, ck, edge) >= far * far:
            continue
        left = active[cube]
        for part in range(VOXELS):
            if left == 0:
                break
            b = index[cube, part]
            if b < 0:
                continue
            left -= 1
            bi, bj, bk = 4 * ci + (part >> 4), 4 * cj + ((part >> 2) & 3), 4 * ck + (part & 3)
            if square_to_cube(segment, bi, bj, bk, 0.25 * edge) >= far * far:
                continue
            for p in range(count[b]):
                row = members[b, p]
                square = square_to_point(segment, points[row, 0], points[row, 1], points[row, 2])
                if square < least:
                    least, found = square, row
            far = math.sqrt(least) + half
    if found < 0:
        return best
    at = float(points[found, 0]), float(points[found, 1]), float(points[found, 2])
    return math.sqrt(least), at[0], at[1], at[2]


@compiled
def distances(blocks: Blocks, around: Around, points: Array, reach: float) -> Array:
    """Return the distance from points (n, 3) to the nearest point held, (n,) m, at most reach (m)."""
    out = np.empty(len(points))
    for r in range(len(points)):
        segment = (points[r, 0], points[r, 1], points[r, 2], 0.0, 0.0, 0.0, 0.0)
        out[r] = nearest(blocks, around, segment, (reach, 0.0, 0.0, 0.0))[0]
    return out


@compiled
def gradients(blocks: Blocks, around: Around, points: Array, reach: float) -> Array:
    """Return the unit vectors (n, 3) to points (n, 3) from the nearest point held; zero beyond reach (m)."""
    out = np.zeros((len(points), 3))
    for r in range(len(points)):
        x, y, z = points[r, 0], points[r, 1], points[r, 2]
        d, px, py, pz = nearest(blocks, around, (x, y, z, 0.0, 0.0, 0.0, 0.0), (reach, 0.0, 0.0, 0.0))
        if 0.0 < d < reach:
            out[r, 0], out[r, 1], out[r, 2] = (x - px) / d, (y - py) / d, (z - pz) / d
    return out


@compiled
def swept(blocks: Blocks, around: Around, start: Array, end: Array, reach: float) -> float:
    """Return the least distance from a straight segment between two points (3,) to the points held, at most reach (m).

    Taken in pieces as long as a coarse cube, so that far cubes are left out.
    """
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    pieces = int(max(math.ceil(length / (blocks.cell * SIDE)), 1.0))
    unit = 1.0 / length if length > 0.0 else 0.0
    best = (reach, 0.0, 0.0, 0.0)
    for piece in range(pieces):
        part = (piece + 0.5) / pieces
        x, y, z = start[0] + part * dx, start[1] + part * dy, start[2] + part * dz
        best = nearest(blocks, around, (x, y, z, unit * dx, unit * dy, unit * dz, 0.5 * length / pieces), best)
    return best[0]


@compiled
def cast(blocks: Blocks, around: Around, origin: Array, directions: Array, reach: float, near: float) -> Array:
    """Return how far (n,) m rays go until they are `near` (m) a point held, within 1 mm; inf where not in reach (m)."""
    out = np.empty(len(directions))
    for r in range(len(directions)):
        t, ahead = 0.0, 0.0
        while t <= reach:
            x, y, z = (
                origin[0] + t * directions[r, 0],
                origin[1] + t * directions[r, 1],
                origin[2] + t * directions[r, 2],
            )
            ahead = nearest(blocks, around, (x, y, z, 0.0, 0.0, 0.0, 0.0), (near + PATIENCE, 0.0, 0.0, 0.0))[0] - near
            if ahead <= TOLERANCE:
                break
            t += ahead
        out[r] = t if t <= reach else math.inf
    return out
