"""Shapes as voxels."""

import math

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.types import Array, Vector
from crosstrack.world.grids import MOST_CELLS, Voxels
from crosstrack.world.world import World


def rasterise(world: World, low: Vector, high: Vector, cell: float) -> Voxels:
    """Return the voxels between two corners (m) that the obstacles of a world may touch.

    A voxel is occupied when its middle is within half its diagonal of an obstacle: the voxels cover the
    obstacles in the box, and reach at most √3 `cell` beyond them.

    Raises:
        InputError: the box is empty, or more than 16 million voxels are needed.
    """
    counts = np.ceil((np.array(high) - low) / cell)
    if not (counts > 0).all():
        raise InputError("rasterise", [Problem("high", f"{high} must be above low, {low}, on every axis")])
    if not np.prod(counts) <= MOST_CELLS:
        message = f"{cell} m gives {np.prod(counts):.3g} voxels; at most {MOST_CELLS}"
        raise InputError("rasterise", [Problem("cell", message)])
    shape = counts.astype(int)
    occupied = np.zeros(shape, dtype=bool)
    y, z = (low[axis] + (np.arange(shape[axis]) + 0.5) * cell for axis in (1, 2))
    layer: Array = np.stack(np.broadcast_arrays(0.0, y[:, None], z[None, :]), axis=-1)
    for i in range(shape[0]):
        layer[..., 0] = low[0] + (i + 0.5) * cell
        occupied[i] = world.distance(layer) <= math.sqrt(3) / 2 * cell
    return Voxels(occupied, low, cell)
