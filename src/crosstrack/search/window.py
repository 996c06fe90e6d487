"""The part of space that is searched, as a lattice of distances."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.protocols import Field, Map
from crosstrack.types import Array

OUTSIDE = np.float32(-1.0)
"""m, the value of points that may not be passed"""
SOUND = 3.0**-0.5
"""cells for each metre of clearance, up to which every edge between points that may hold a way is free"""
MOST_POINTS = 6_000_000
"""of a lattice"""
HALF = 0.5 * 3.0**0.5
"""cells, from the middle of a cube of one to its corner"""


@dataclass(frozen=True, eq=False)
class Window:
    """Distances at the points of a lattice whose outermost points on every side may not be passed."""

    box: Array
    """(2, 3) m, lowest and highest corner of the space that may be passed"""
    low: Array
    """(3,) m, the first point"""
    cell: float
    """m"""
    values: Field
    """(nx, ny, nz) m, at most `reach`; `OUTSIDE` where a point may not be passed"""
    reach: float
    """m"""

    def index(self, point: Array) -> int:
        """Return the index of the point nearest to a point (3,) of the box, row-major."""
        at = np.rint((point - self.low) / self.cell).astype(int)
        inside = np.clip(at, 1, np.array(self.values.shape) - 2)
        return int(np.ravel_multi_index(tuple(inside), self.values.shape))

    def points(self, indices: NDArray[np.int32]) -> Array:
        """Return where points of some indices are, (n, 3) m, moved into the box."""
        at = np.stack(np.unravel_index(indices, self.values.shape), axis=1)
        return np.clip(self.low + at * self.cell, *self.box)


def cell_for(box: Array, clearance: float) -> float:
    """Return the cell (m) of a lattice over a box: the largest that misses no way, or what the memory allows."""
    size = np.maximum(box[1] - box[0], clearance)
    return max(SOUND * clearance, float((np.prod(size) / MOST_POINTS) ** (1 / 3)))


def look(world: Map, box: Array, clearance: float, reach: float) -> Window:
    """Return the window of a map: points with less than the clearance, less half a diagonal, may not be passed.

    Every point with the clearance is within half a diagonal of a point of the lattice that may be passed.

    Args:
        world: what is in the way
        box: (2, 3) m
        clearance: m
        reach: m, at least the clearance
    """
    cell = cell_for(box, clearance)
    spans = np.floor((box[1] - box[0]) / cell).astype(int) + 1  # that they overhang by at most half a cell
    low = box[0] - 0.5 * (spans * cell - (box[1] - box[0])) - cell
    counts = (int(spans[0]) + 3, int(spans[1]) + 3, int(spans[2]) + 3)
    values = world.field(low, cell, counts, reach)
    values[values < max(clearance - HALF * cell, 0.0)] = OUTSIDE
    for side in (0, -1):
        values[side] = values[:, side] = values[:, :, side] = OUTSIDE
    return Window(box, low, cell, values, reach)
