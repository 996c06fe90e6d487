"""Surfaces for drawing: closed, normals outward."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array
from crosstrack.world.polygon import counter_clockwise, triangles

Triangles = NDArray[np.int64]


class Mesh(NamedTuple):
    """A surface of triangles."""

    vertices: Array
    """(n, 3) m, world"""
    triangles: Triangles
    """(m, 3) rows of `vertices`, counter-clockwise seen from outside"""


def join(meshes: list[Mesh]) -> Mesh:
    """Put several surfaces into one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def circle(count: int) -> Array:
    """Return corners (count, 2) on the unit circle, counter-clockwise."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def extrude(outline: Array, lo: float, hi: float) -> Mesh:
    """Return the prism over a simple polygon (n, 2) between two heights (m)."""
    outline = counter_clockwise(np.asarray(outline, dtype=float))
    count = len(outline)
    low, high = (np.column_stack([outline, np.full(count, z)]) for z in (lo, hi))
    here = np.arange(count)
    ahead = np.roll(here, -1)
    caps = triangles(outline)
    walls = [[here, ahead, ahead + count], [here, ahead + count, here + count]]
    sides = np.concatenate([np.column_stack(wall) for wall in walls])
    return Mesh(np.concatenate([low, high]), np.concatenate([caps[:, ::-1], caps + count, sides]))


def ball(center: Array, radius: float, rings: int = 12) -> Mesh:
    """Return a sphere cut along meridians and parallels."""
    around = 2 * rings
    polar = np.pi * np.arange(1, rings) / rings
    ring = np.stack(
        [
            np.outer(np.sin(polar), circle(around)[:, 0]),
            np.outer(np.sin(polar), circle(around)[:, 1]),
            np.outer(np.cos(polar), np.ones(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    vertices = center + radius * np.concatenate([[[0.0, 0.0, 1.0]], ring, [[0.0, 0.0, -1.0]]])
    here = np.arange(around)
    ahead = np.roll(here, -1)
    top, bottom, last = np.zeros(around, dtype=np.int64), len(vertices) - 1, 1 + around * (rings - 2)
    faces = [[top, 1 + here, 1 + ahead], [top + bottom, last + ahead, last + here]]
    for upper in range(1, last, around):
        lower = upper + around
        faces.append([upper + here, lower + here, lower + ahead])
        faces.append([upper + here, lower + ahead, upper + ahead])
    return Mesh(vertices, np.concatenate([np.column_stack(face) for face in faces]).astype(np.int64))


def cells(occupied: NDArray[np.bool_], origin: Array, size: Array) -> Mesh:
    """Return the surface of the occupied cells of a grid, with equal neighbouring faces merged.

    Args:
        occupied: (nx, ny, nz)
        origin: (3,) m, lowest corner of the grid
        size: (3,) m, of a cell
    """
    corners = []
    for axis in range(3):
        turned = np.pad(
            np.moveaxis(occupied, [axis, (axis + 1) % 3, (axis + 2) % 3], [0, 1, 2]), ((1, 1), (0, 0), (0, 0))
        )
        for outward in (False, True):
            faces = turned[:-1] & ~turned[1:] if outward else turned[1:] & ~turned[:-1]
            quads = _rectangles(faces)
            corners.append(np.roll(quads if outward else quads[:, ::-1], axis, axis=2))
    found = np.concatenate(corners).reshape(-1, 3)
    quad = np.arange(0, len(found), 4)[:, None]
    halves = [quad + np.array(half) for half in ((0, 1, 2), (0, 2, 3))]
    return Mesh(origin + found * size, np.concatenate(halves))


def _rectangles(faces: NDArray[np.bool_]) -> Array:
    """Cover the set cells of each layer (layers, n, m) by rectangles: corners (k, 4, 3) in lattice units."""
    edge = np.diff(np.pad(faces, ((0, 0), (0, 0), (1, 1))).astype(np.int8), axis=2)
    layer, row, start = np.nonzero(edge == 1)
    end = np.nonzero(edge == -1)[2]
    order = np.lexsort((row, end, start, layer))
    layer, row, start, end = layer[order], row[order], start[order], end[order]
    same = (np.diff(layer) == 0) & (np.diff(start) == 0) & (np.diff(end) == 0) & (np.diff(row) == 1)
    first = np.flatnonzero(np.concatenate([np.ones(min(len(row), 1), dtype=bool), ~same]))
    last = np.append(first[1:], len(row))[: len(first)] - 1
    a, b, c, d = row[first], row[last] + 1, start[first], end[first]
    level = layer[first]
    return np.stack([np.stack([level, u, v], axis=1) for u, v in ((a, c), (b, c), (b, d), (a, d))], axis=1).astype(
        float
    )
