"""Convex polytopes of free space around the legs of a way.

Obstacles are seen as points of their surfaces. Around a leg the nearest of them gives a plane across the line to it,
at the clearance; what is behind that plane needs none of its own, and so on with the nearest that is left.

Source: Liu et al. 2017, Planning dynamically feasible trajectories for quadrotors using safe flight corridors in 3-D
complex environments (IEEE Robotics and Automation Letters), with balls in place of their ellipsoids.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.protocols import Field, Map
from crosstrack.types import Array

CELL = 0.14
"""m, between the points of the lattice that surfaces are found with"""
SHELL = 0.87
"""cells, within which of a surface a point of the lattice always is"""
MOST_FACES = 40
SETTLINGS = 2
MOST_POINTS = 6_000_000
"""of the lattice"""


def surface(world: Map, way: Array, reach: float) -> Array:
    """Return points (n, 3) m of the surfaces of obstacles within a reach (m) of a way (k, 3) m."""
    low, high = way.min(axis=0) - reach, way.max(axis=0) + reach
    cell = max(CELL, float((np.prod(high - low) / MOST_POINTS) ** (1 / 3)))
    counts = np.ceil((high - low) / cell).astype(int) + 1
    values = world.field(low, cell, (int(counts[0]), int(counts[1]), int(counts[2])), 2 * SHELL * cell)
    near = shell(values, low, cell, way, reach, np.zeros(values.shape, np.uint8))
    return near - world.distance(near)[:, None] * world.gradient(near)


@compiled
def shell(values: Field, low: Array, cell: float, way: Array, reach: float, taken: Array) -> Array:
    """Return the points (n, 3) m of a lattice just outside of obstacles, within a reach of a way."""
    count = 0
    shape = values.shape
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for leg in range(len(way) - 1):
        a, b = way[leg], way[leg + 1]
        for d in range(3):
            first[d] = max(math.ceil((min(a[d], b[d]) - reach - low[d]) / cell), 0)
            last[d] = min(math.floor((max(a[d], b[d]) + reach - low[d]) / cell) + 1, shape[d])
        for i in range(first[0], last[0]):
            for j in range(first[1], last[1]):
                for k in range(first[2], last[2]):
                    if taken[i, j, k] == 0 and 0.0 <= values[i, j, k] <= SHELL * cell:
                        x, y, z = low[0] + i * cell, low[1] + j * cell, low[2] + k * cell
                        if beside(a, b, x, y, z)[0] <= reach:
                            taken[i, j, k] = 1
                            count += 1
    points = np.empty((count, 3))
    count = 0
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                if taken[i, j, k] != 0:
                    points[count, 0], points[count, 1] = low[0] + i * cell, low[1] + j * cell
                    points[count, 2] = low[2] + k * cell
                    count += 1
    return points


@compiled
def beside(a: Array, b: Array, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return how far a point is from a segment, and the point of the segment that is nearest."""
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    square = dx * dx + dy * dy + dz * dz
    share = ((x - a[0]) * dx + (y - a[1]) * dy + (z - a[2]) * dz) / square if square > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    px, py, pz = a[0] + share * dx, a[1] + share * dy, a[2] + share * dz
    return math.sqrt((x - px) ** 2 + (y - py) ** 2 + (z - pz) ** 2), px, py, pz


@compiled
def faces_of(a: Array, b: Array, points: Array, clearance: float, reach: float, faces: Array, touched: Array) -> int:
    """Fill `faces` (m, 4) with planes n p <= offset around a segment; return how many.

    Args:
        a: (3,) m, one end
        b: (3,) m, the other
        points: (n, 3) m, of obstacles
        clearance: m, from the planes through them
        reach: m, farther than which points do not matter
        faces: (m, 4) room for normals, unit, and offsets
        touched: (m, 3) m, room for the points they were drawn through
    """
    count, size = 0, 0
    distances, chosen, feet = np.empty(len(points)), np.empty(len(points), np.int64), np.empty((len(points), 3))
    for i in range(len(points)):
        far, px, py, pz = beside(a, b, points[i, 0], points[i, 1], points[i, 2])
        if far < reach:
            distances[size], chosen[size] = far, i
            feet[size, 0], feet[size, 1], feet[size, 2] = px, py, pz
            size += 1
    while size > 0 and count < len(faces):
        k = int(np.argmin(distances[:size]))
        o, far = points[chosen[k]], max(distances[k], 1e-9)
        for d in range(3):
            faces[count, d] = (o[d] - feet[k, d]) / far
            touched[count, d] = o[d]
        edge = faces[count, 0] * o[0] + faces[count, 1] * o[1] + faces[count, 2] * o[2]
        faces[count, 3] = edge - clearance
        left = 0
        for i in range(size):
            p = points[chosen[i]]
            if faces[count, 0] * p[0] + faces[count, 1] * p[1] + faces[count, 2] * p[2] < edge - 1e-6:
                distances[left], chosen[left] = distances[i], chosen[i]
                for d in range(3):
                    feet[left, d] = feet[i, d]
                left += 1
        size = left
        count += 1
    return count


def polytopes(world: Map, legs: Array, clearances: Array, reach: float, box: Array) -> list[tuple[Array, Array]]:
    """Return a polytope A p <= b of free space around each leg, A (m, 3) and b (m,).

    Only the faces within the reach of the leg; they hold on the points of the surfaces that were looked at.

    Args:
        world: what is in the way
        legs: (n + 1, 3) m
        clearances: (n,) m, of each leg: at most what it has
        reach: m, from the leg, farther than which faces are left out
        box: (2, 3) m, to stay in; only its lower height needs to be finite
    """
    points = surface(world, legs, reach + float(clearances.max()))
    room, touched = np.zeros((len(clearances), MOST_FACES, 4)), np.zeros((len(clearances), MOST_FACES, 3))
    counts = np.zeros(len(clearances), int)
    for i, clearance in enumerate(clearances):
        counts[i] = faces_of(legs[i], legs[i + 1], points, clearance, reach + clearance, room[i], touched[i])
    settle(world, room, touched, counts, clearances)
    found = []
    for a, b, faces, count in zip(legs[:-1], legs[1:], room, counts, strict=True):
        low, high = np.minimum(box[0], np.minimum(a, b)), np.maximum(box[1], np.maximum(a, b))
        normals = np.concatenate([faces[:count, :3], -np.eye(3), np.eye(3)])
        offsets = np.concatenate(
            [np.maximum(faces[:count, 3], (np.stack([a, b]) @ faces[:count, :3].T).max(axis=0)), -low, high]
        )
        near = offsets - np.maximum(normals @ a, normals @ b) < reach
        near[count + 2] = True  # a polytope has a face, and the ground is always there
        found.append((normals[near], offsets[near]))
    return found


def settle(world: Map, faces: Array, touched: Array, counts: NDArray[np.int64], clearances: Array) -> None:
    """Move faces (n, m, 4) inward to where the points that they were drawn through are as clear as is wanted.

    The points of a surface that were looked at are not all there are: between them it may bulge.
    """
    which = np.arange(faces.shape[1]) < counts[:, None]
    for _ in range(SETTLINGS):
        normals = faces[..., :3]
        off = faces[..., 3] - (normals * touched).sum(axis=-1)
        feet = touched + off[..., None] * normals
        short = np.zeros(which.shape)
        short[which] = np.repeat(clearances, counts) - world.distance(feet[which])
        faces[..., 3] -= np.maximum(short, 0.0)


def add_face(faces: list[tuple[Array, Array]], piece: int, leg: Array, point: Array, clearance: float) -> None:
    """Add a face to the polytope of a piece: across the line from its leg (2, 3) to a point (3,) of an obstacle."""
    far, *foot = beside(leg[0], leg[1], *(float(x) for x in point))
    outward = (point - np.array(foot)) / max(far, 1e-9)
    normals, offsets = faces[piece]
    offset = max(float(outward @ point) - clearance, float((leg @ outward).max()))
    faces[piece] = np.concatenate([normals, outward[None]]), np.append(offsets, offset)
