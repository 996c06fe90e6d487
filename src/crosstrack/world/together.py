"""Several maps as one: what a vehicle was told of the world and what it has seen, or what stands and what moves."""

from dataclasses import dataclass

import numpy as np

from crosstrack.protocols import Field, Map
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Together:
    """The union of the obstacles of some maps; ground and bounds are those of the first."""

    maps: tuple[Map, ...]
    """at least one"""

    @property
    def ground(self) -> float:
        """m, height of the ground, which is no obstacle"""
        return self.maps[0].ground

    @property
    def bounds(self) -> Array | None:
        """(2, 3) m, lowest and highest corner of the space that may be flown, which are no obstacle"""
        return self.maps[0].bounds

    @property
    def optimism(self) -> float:
        """m, by which the distance may exceed the true one"""
        return max(part.optimism for part in self.maps)

    def distance(self, points: Array) -> Array:
        """Return the signed distance from `points` (..., 3) to the nearest obstacle, (...), m; inf without any."""
        return np.asarray(np.minimum.reduce([part.distance(points) for part in self.maps]))

    def gradient(self, points: Array) -> Array:
        """Return the gradient of the distance, (..., 3): away from the nearest obstacle; zero without any."""
        nearest = np.argmin([part.distance(points) for part in self.maps], axis=0)
        gradients = np.array([part.gradient(points) for part in self.maps])
        return np.asarray(np.take_along_axis(gradients, nearest[None, ..., None], axis=0)[0])

    def swept(self, start: Array, end: Array) -> float:
        """Return the least signed distance along the straight segment between two points (3,), m."""
        return min(part.swept(start, end) for part in self.maps)

    def field(self, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
        """Return the distance at the points of a lattice, see `protocols.Map`."""
        return np.asarray(np.minimum.reduce([part.field(low, cell, counts, reach) for part in self.maps]))

    def cast(self, origin: Array, directions: Array, reach: float) -> Array:
        """Return how far (n,) m rays go until they hit an obstacle, see `protocols.Map`."""
        return np.asarray(np.minimum.reduce([part.cast(origin, directions, reach) for part in self.maps]))
