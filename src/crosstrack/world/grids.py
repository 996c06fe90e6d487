"""Grids of free and occupied cells, and their Euclidean signed distance.

The obstacle is the union of the occupied cells as full squares or cubes. The point of a cell nearest to any
corner of the grid is itself a corner, so the distance transform between corners is exact there, inside as
outside; half-cell offsets do not arise. Between the corners the distance is interpolated:

- It is never negative in free cells and never positive in occupied ones. What is one cell wide, a wall or a way
  through, has its corners at 0 and reads 0 throughout: choose cells of at most half of what matters.
- In free cells and outside the grid it exceeds the true distance by at most `optimism`: the most by which
  interpolating |p - q| over a cell can exceed it, which is where q is a corner of the cell.
- Along an axis it changes no faster than the distance itself, so its slope is at most √2 (plane) or √3
  (space). The swept check counts on these slopes rather than on 1.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array
from crosstrack.world.mesh import Mesh, cells

Occupied = NDArray[np.bool_]
MOST_CELLS = 16_000_000
PLANE_OPTIMISM = (2 - math.sqrt(2)) / 4
SPACE_OPTIMISM = 0.2594


def signed_distance(occupied: Occupied, cell: float) -> Array:
    """Return the signed distance from every corner of a grid's cells to its occupied cells, m.

    Args:
        occupied: (n, m) or (n, m, k) cells; what lies around them is free
        cell: m, edge of a cell

    Returns:
        (n + 1, m + 1[, k + 1]) m, negative inside
    """
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - takes long to import, and few missions need it

    outside = distance_transform_edt(~_corners(np.pad(occupied, 1)))
    inside = distance_transform_edt(~_corners(np.pad(~occupied, 1, constant_values=True)))
    distance: Array = (outside - inside) * cell
    return distance


def _corners(padded: Occupied) -> Occupied:
    """Return which corners belong to a set cell, of the grid inside the padding."""
    touched = np.zeros(np.array(padded.shape) - 1, dtype=bool)
    for shift in product((slice(None, -1), slice(1, None)), repeat=padded.ndim):
        touched |= padded[shift]
    return touched


def _span(occupied: Occupied, axis: int) -> tuple[int, int]:
    """Return the first and one past the last occupied layer along an axis."""
    layers = np.flatnonzero(occupied.any(axis=tuple(i for i in range(occupied.ndim) if i != axis)))
    return int(layers[0]), int(layers[-1]) + 1


@dataclass(frozen=True, eq=False)
class Relief:
    """Squares of the plane that stand as walls between two heights; its distance in height is exact."""

    occupied: Occupied
    """(nx, ny) cells"""
    origin: tuple[float, float]
    """m, lowest corner"""
    cell: float
    """m, edge of a cell"""
    z: tuple[float, float]
    """m, heights of the lower and the upper end"""

    @property
    def optimism(self) -> float:
        """m, by which the distance may exceed the true one outside the obstacles"""
        return PLANE_OPTIMISM * self.cell

    @property
    def box(self) -> list[float]:
        """m, lowest and highest corner of the box around the obstacles"""
        spans = [np.array(_span(self.occupied, axis)) * self.cell + self.origin[axis] for axis in range(2)]
        return [spans[0][0], spans[1][0], self.z[0], spans[0][1], spans[1][1], self.z[1]]

    @cached_property
    def values(self) -> Array:
        """(nx + 1, ny + 1) m, signed distance in the plane at the corners"""
        return signed_distance(self.occupied, self.cell)

    def mesh(self) -> Mesh:
        """Return the surface of the obstacles."""
        size = np.array([self.cell, self.cell, self.z[1] - self.z[0]])
        return cells(self.occupied[:, :, None], np.array([*self.origin, self.z[0]]), size)


@dataclass(frozen=True, eq=False)
class Voxels:
    """Cubes of space."""

    occupied: Occupied
    """(nx, ny, nz) cells"""
    origin: tuple[float, float, float]
    """m, lowest corner"""
    cell: float
    """m, edge of a cell"""

    @property
    def optimism(self) -> float:
        """m, by which the distance may exceed the true one outside the obstacles"""
        return SPACE_OPTIMISM * self.cell

    @property
    def box(self) -> list[float]:
        """m, lowest and highest corner of the box around the obstacles"""
        spans = [np.array(_span(self.occupied, axis)) * self.cell + self.origin[axis] for axis in range(3)]
        return [*(span[0] for span in spans), *(span[1] for span in spans)]

    @cached_property
    def values(self) -> Array:
        """(nx + 1, ny + 1, nz + 1) m, signed distance at the corners"""
        return signed_distance(self.occupied, self.cell)

    def mesh(self) -> Mesh:
        """Return the surface of the obstacles."""
        return cells(self.occupied, np.array(self.origin), np.full(3, self.cell))


Grid = Relief | Voxels
