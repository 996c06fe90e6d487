"""Many obstacles as one table of numbers, with a tree of boxes over them."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array
from crosstrack.world.grids import Grid, Occupied, Relief, Voxels
from crosstrack.world.polygon import counter_clockwise
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere

BOX, CYLINDER, SPHERE, PRISM, RELIEF, VOXELS = range(6)
LEAF = 4


class Table(NamedTuple):
    """Obstacles in the order of the tree's leaves; what a row of `numbers` means depends on its kind."""

    kinds: NDArray[np.int64]
    """(n,) one of BOX, CYLINDER, SPHERE, PRISM, RELIEF, VOXELS"""
    numbers: Array
    """(n, 8)"""
    boxes: Array
    """(n, 6) m, lowest and highest corner of the box around each"""
    corners: Array
    """(m, 2) m, of all prisms, each counter-clockwise"""
    values: Array
    """(k,) m, signed distances at the corners of all grids, row-major"""
    occupied: Occupied
    """(k,) whether the cell above each of these corners is occupied"""
    nodes: Array
    """(q, 6) m, box around each node of the tree; the first is the root"""
    links: NDArray[np.int64]
    """(q, 2) a leaf's first obstacle and how many; a fork's second child and 0: the first child follows it"""
    places: NDArray[np.int64]
    """(n,) where each was among the shapes and the occupied grids that the table was made from"""


def tabulate(shapes: Sequence[Shape], grids: Sequence[Grid]) -> Table | None:
    """Return the table of shapes and grids; None without any obstacle."""
    grids = [grid for grid in grids if grid.occupied.any()]
    if not shapes and not grids:
        return None
    polygons = [counter_clockwise(np.array(shape.polygon)) for shape in shapes if isinstance(shape, Prism)]
    firsts = iter(np.cumsum([0, *(len(polygon) for polygon in polygons)]))
    rows = [_row(shape, firsts) for shape in shapes]
    starts = np.cumsum([0, *(grid.values.size for grid in grids)])
    rows += [_grid_row(grid, float(start)) for grid, start in zip(grids, starts, strict=False)]
    numbers = np.zeros((len(rows), 8))
    for i, (_, row, _) in enumerate(rows):
        numbers[i, : len(row)] = row
    boxes = np.array([box for _, _, box in rows], dtype=float)
    order, nodes, links = _tree(boxes)
    return Table(
        np.array([kind for kind, _, _ in rows], dtype=np.int64)[order],
        numbers[order],
        boxes[order],
        np.concatenate([np.empty((0, 2)), *polygons]),
        np.concatenate([np.empty(0), *(grid.values.ravel() for grid in grids)]),
        np.concatenate([np.empty(0, dtype=bool), *(np.pad(grid.occupied, (0, 1)).ravel() for grid in grids)]),
        nodes,
        links,
        order,
    )


Row = tuple[int, Sequence[float], Sequence[float]]


def _row(shape: Shape, firsts: Iterator[np.int64]) -> Row:
    """Return kind, numbers and box of a shape."""
    match shape:
        case Box():
            return BOX, [*shape.min, *shape.max], [*shape.min, *shape.max]
        case Cylinder(center=(x, y), radius=r, z=(lo, hi)):
            return CYLINDER, [x, y, r, lo, hi], [x - r, y - r, lo, x + r, y + r, hi]
        case Sphere(center=(x, y, z), radius=r):
            return SPHERE, [x, y, z, r], [x - r, y - r, z - r, x + r, y + r, z + r]
        case Prism(z=(lo, hi)):
            low, high = np.min(shape.polygon, axis=0), np.max(shape.polygon, axis=0)
            return PRISM, [float(next(firsts)), len(shape.polygon), lo, hi], [*low, lo, *high, hi]


def _grid_row(grid: Grid, first: float) -> Row:
    """Return kind, numbers and box of a grid."""
    counts = [float(count) for count in grid.values.shape]
    match grid:
        case Relief():
            return RELIEF, [first, *counts, grid.cell, *grid.origin, *grid.z], grid.box
        case Voxels():
            return VOXELS, [first, *counts, grid.cell, *grid.origin], grid.box


def _tree(boxes: Array) -> tuple[NDArray[np.int64], Array, NDArray[np.int64]]:
    """Halve the obstacles along the longest side of their box until few are left: order, nodes, links."""
    middle = (boxes[:, :3] + boxes[:, 3:]) / 2
    order: list[int] = []
    nodes: list[Array] = []
    links: list[tuple[int, int]] = []

    def grow(members: NDArray[np.int64]) -> None:
        box = np.concatenate([boxes[members, :3].min(axis=0), boxes[members, 3:].max(axis=0)])
        at = len(nodes)
        nodes.append(box)
        links.append((len(order), len(members)))
        if len(members) <= LEAF:
            order.extend(members.tolist())
            return
        axis = int(np.argmax(np.ptp(middle[members], axis=0)))
        members = members[np.argsort(middle[members, axis], kind="stable")]
        half = len(members) // 2
        grow(members[:half])
        links[at] = (len(nodes), 0)
        grow(members[half:])

    grow(np.arange(len(boxes)))
    return np.array(order, dtype=np.int64), np.array(nodes), np.array(links, dtype=np.int64)
