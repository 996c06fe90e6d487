"""The world of a mission: what is in the way, and how far it is."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosstrack.protocols import Field
from crosstrack.types import Array
from crosstrack.world import nearest, sectors
from crosstrack.world.field import stamped
from crosstrack.world.grids import Grid, Relief
from crosstrack.world.mesh import Mesh, Triangles, join
from crosstrack.world.shapes import Shape
from crosstrack.world.table import Table, tabulate


@dataclass(frozen=True, eq=False)
class World:
    """Obstacles and the space around them; a `protocols.Map`.

    The distance to several obstacles is the least of their distances. That is exact outside them; where they
    overlap, its size is at most the true depth, since a way out of one may lead into another. It is
    1-Lipschitz for shapes; for grids see `crosstrack.world.grids`.
    """

    shapes: tuple[Shape, ...] = ()
    """obstacles whose distance is exact"""
    grids: tuple[Grid, ...] = ()
    """obstacles made of cells"""
    bounds: Array | None = None
    """(2, 3) m, lowest and highest corner of the space that may be flown, which are no obstacle"""
    ground: float = 0.0
    """m, height of the ground, which is no obstacle"""

    @cached_property
    def table(self) -> Table | None:
        """All obstacles as numbers for compiled code; None without any."""
        return tabulate(self.shapes, self.grids)

    @property
    def optimism(self) -> float:
        """m, by which a distance may exceed the true one outside the obstacles: 0 for shapes"""
        return max((grid.optimism for grid in self.grids if grid.occupied.any()), default=0.0)

    def distance(self, points: Array) -> Array:
        """Return the signed distance from `points` (..., 3) to the nearest obstacle, (...) m, or inf."""
        points = np.asarray(points, dtype=float)
        if self.table is None:
            return np.full(points.shape[:-1], np.inf)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        return nearest.distances(self.table, flat).reshape(points.shape[:-1])

    def gradient(self, points: Array) -> Array:
        """Return the gradient of the distance, (..., 3): away from the nearest obstacle; zero without any.

        Where it is not defined, such as at equal distances, it is that of one of the sides.
        """
        points = np.asarray(points, dtype=float)
        if self.table is None:
            return np.zeros(points.shape)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        return nearest.gradients(self.table, flat).reshape(points.shape)

    def swept(self, start: Array, end: Array) -> float:
        """Return the least signed distance along the straight segment between two points (3,), m.

        At most 1 mm above the least (1 µm for boxes, cylinders and spheres), however thin an obstacle is.
        """
        if self.table is None:
            return np.inf
        start, end = np.ascontiguousarray(start, dtype=float), np.ascontiguousarray(end, dtype=float)
        return nearest.swept(self.table, start, end)

    def field(self, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
        """Return the distance at the points of a lattice, (counts) m: where it is below `reach`; `reach` elsewhere.

        Args:
            low: (3,) m, the first point
            cell: m, between two points along each axis
            counts: of points along each axis
            reach: m, above zero
        """
        return stamped(self.table, low, cell, counts, reach)

    def cast(self, origin: Array, directions: Array, reach: float) -> Array:
        """Return how far (n,) m rays go from a point (3,) along unit vectors (n, 3) until they hit an obstacle.

        inf where that is not within `reach` (m); 0 from inside an obstacle. Exact; grids are the union of their cells.
        """
        if self.table is None:
            return np.full(len(directions), np.inf)
        origin, directions = np.ascontiguousarray(origin, dtype=float), np.ascontiguousarray(directions, dtype=float)
        return sectors.cast(self.table, origin, directions, reach)

    def meshes(self) -> list[tuple[str, Array, Triangles]]:
        """Return the surfaces to draw, one for each kind of obstacle: name, vertices (m), triangles."""
        parts: dict[str, list[Mesh]] = {}
        for shape in self.shapes:
            parts.setdefault(type(shape).__name__.lower(), []).append(shape.mesh())
        for grid in self.grids:
            if grid.occupied.any():
                parts.setdefault("walls" if isinstance(grid, Relief) else "voxels", []).append(grid.mesh())
        return [(name, *join(meshes)) for name, meshes in parts.items()]
