"""What scans have shown of the world: a window around the vehicle, as points of surfaces."""

import math
from collections.abc import Sequence

import numpy as np

from crosstrack.protocols import Field, Map, Sensor
from crosstrack.sense import nearest_point
from crosstrack.sense.beyond import assume, beyond
from crosstrack.sense.blocks import SIDE, empty, forget, gathered, grown, move
from crosstrack.sense.clearing import clear
from crosstrack.sense.integrate import add_hits, free_lengths, off_ground
from crosstrack.sense.point_field import lattice_distances
from crosstrack.sense.pose import axes, turned_all
from crosstrack.sense.range_image import RangeImage, image_of, least_around
from crosstrack.sense.ranging import Ranging
from crosstrack.types import Array, Scan, State

FIRST_BLOCKS = 32768
MOST_IMAGES = 8
WIDEST = 64.0
"""m, of a window: what sensors see beyond half of that is not kept"""
GROUND_TOLERANCE = 0.15
"""m, above the ground up to which a hit is one of the ground"""
MARGIN = 1.5
"""voxels, beyond a point that a ray must have gone to have gone through it"""
MEMORY = 5.0
"""s, after which a point goes that rays pass by closely and that was not seen again"""
CELL = 0.05
"""m, edge of a voxel of the map for some sensors"""
KNOWN = 0.15
"""m, from an obstacle of the map told within which a hit is one of it"""


class LocalMap:
    """Obstacles as scans have shown them, around where the last scan was made; a `protocols.Map`.

    Each voxel that was hit holds one point, the mean of the last hits in it, and distances are to these points: what is
    seen is not blown up to whole voxels. Distances are never negative and at most `reach`; the unknown is free.

    Args:
        size: m, edge of the window, rounded up to whole coarse cubes of 16 voxels
        cell: m, edge of a voxel
        told: what is known of the world; hits of its obstacles are left out, its ground and its bounds are those here
        reach: m, beyond which distances are not looked for
        clearance: m, least distance at which `optimism` holds
    """

    def __init__(self, size: float, cell: float, told: Map, *, reach: float = 5.0, clearance: float = 0.2) -> None:
        self.told, self.cell, self.reach, self.clearance = told, cell, reach, clearance
        self._blocks = empty(cell, math.ceil(size / (cell * SIDE)), FIRST_BLOCKS)
        self._around = nearest_point.around(reach, cell * SIDE)
        self._images: dict[int, RangeImage] = {}

    @classmethod
    def around(cls, sensors: Sequence[Sensor], told: Map) -> "LocalMap":
        """Return the empty map for some sensors: as wide as they see to both sides, at most `WIDEST`."""
        local = cls(min(2.0 * max(sensor.range for sensor in sensors) + 2.0, WIDEST), CELL, told)
        for sensor in sensors:
            if isinstance(sensor, Ranging):  # before the flight: it takes longer than a decision may
                local._image(sensor.directions, sensor.rows)
        return local

    @property
    def ground(self) -> float:
        """m, height of the ground, which is no obstacle"""
        return self.told.ground

    @property
    def bounds(self) -> Array | None:
        """(2, 3) m, lowest and highest corner of the space that may be flown, which are no obstacle"""
        return self.told.bounds

    @property
    def optimism(self) -> float:
        """m, by which a distance of at least `clearance` may exceed that to a surface of which every voxel was hit.

        A point is then at most a voxel's edge c beside the nearest spot of a flat surface, √(d² + c²) - d, and as the
        mean of its hits at most c/2 inside a sharp edge.
        """
        return max(math.hypot(self.clearance, self.cell) - self.clearance, 0.5 * self.cell)

    @property
    def points(self) -> Array:
        """(n, 3) m, all that is held"""
        return gathered(self._blocks)

    def add(self, scan: Scan, state: State) -> None:
        """Take in a scan made in a state, as estimated."""
        turned = axes(state.attitude)
        origin = state.position + turned @ scan.origin
        move(self._blocks, *state.position.tolist())
        forget(self._blocks)
        image = self._image(scan.directions, scan.rows)
        free = free_lengths(scan.ranges, scan.max_range)
        height = float(origin[2]) - self.ground
        hits = off_ground(scan.ranges, scan.directions, turned, height, GROUND_TOLERANCE)
        when, margin = (scan.time, scan.time - MEMORY), MARGIN * self.cell
        shield = least_around(hits, image.rows)
        clear(self._blocks, image, free, shield, turned, origin, when, margin)
        hits = self._unknown(hits, scan, turned, origin)
        done = 0
        while (done := add_hits(self._blocks, hits, scan.directions, turned, origin, scan.time, done)) < len(hits):
            self._blocks = grown(self._blocks)
        if image.rows > 1:
            points = beyond(hits, scan.directions, turned, origin, image.rows, self.ground + GROUND_TOLERANCE)
            done = 0
            while (done := assume(self._blocks, points, scan.time, done)) < len(points):
                self._blocks = grown(self._blocks)

    def _image(self, directions: Array, rows: int) -> RangeImage:
        """Return the picture of rays (n, 3) in the body, kept for as long as scans come with the same ones."""
        key = id(directions)
        image = self._images.get(key)
        if image is None or image.directions is not directions:
            if len(self._images) >= MOST_IMAGES:
                self._images.clear()
            image = self._images[key] = image_of(directions, rows)
        return image

    def _unknown(self, hits: Array, scan: Scan, turned: Array, origin: Array) -> Array:
        """Return the ranges with inf for those that hit what is known: as far as expected, or near it."""
        if float(self.told.distance(origin)) > scan.max_range:
            return hits
        directions, out = turned_all(turned, scan.directions), np.full(len(hits), np.inf)
        left = np.flatnonzero(hits < np.inf)
        left = left[hits[left] < self.told.cast(origin, directions[left], scan.max_range) - KNOWN]
        left = left[self.told.distance(origin + hits[left, None] * directions[left]) > KNOWN]
        out[left] = hits[left]
        return out

    def distance(self, points: Array) -> Array:
        """Return the distance from `points` (..., 3) to the nearest point held, (...) m; `reach` beyond that."""
        points = np.asarray(points, dtype=float)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        return nearest_point.distances(self._blocks, self._around, flat, self.reach).reshape(points.shape[:-1])

    def gradient(self, points: Array) -> Array:
        """Return the gradient of the distance, (..., 3): away from the nearest point held; zero beyond `reach`."""
        points = np.asarray(points, dtype=float)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        return nearest_point.gradients(self._blocks, self._around, flat, self.reach).reshape(points.shape)

    def swept(self, start: Array, end: Array) -> float:
        """Return the least distance along the straight segment between two points (3,), m, at most `reach`; exact."""
        start, end = np.ascontiguousarray(start, dtype=float), np.ascontiguousarray(end, dtype=float)
        return nearest_point.swept(self._blocks, self._around, start, end, self.reach)

    def field(self, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
        """Return the distance at the points of a lattice, see `protocols.Map`; exact."""
        low = np.asarray(low, dtype=float)
        points = self.points
        high = low + cell * (np.array(counts) - 1)
        near = np.all((points > low - reach) & (points < high + reach), axis=1)
        return lattice_distances(points[near], low, cell, counts, reach)

    def cast(self, origin: Array, directions: Array, reach: float) -> Array:
        """Return how far (n,) m rays go until they are within a voxel's edge of a point held, see `protocols.Map`."""
        origin, directions = np.ascontiguousarray(origin, dtype=float), np.ascontiguousarray(directions, dtype=float)
        return nearest_point.cast(self._blocks, self._around, origin, directions, reach, self.cell)
