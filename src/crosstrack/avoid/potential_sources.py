"""What repels: the nearest point of each obstacle around, from a map, from a distance field, or from a scan."""

import math
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.protocols import Field
from crosstrack.types import Array, Others, Scan, State

APART = 0.9
"""greatest cosine of the angle between two obstacles that count as two, seen from the vehicle: 26°"""
MOST = 32
"""obstacles that count at once"""
SHARES = (0.08, 0.2, 0.5, 1.0)
"""of the reach, how far the points lie from which obstacles are looked for"""
HALVINGS = 3
"""times that they are moved half way to the vehicle"""
ON_SURFACE = 0.1
"""m, from the surface, that a foot may be: where a map of cells has a ridge between obstacles, it is nowhere"""
ABOVE = 0.01
"""m, over a surface, where its normal is taken"""
INSIDE = 1e-6
"""m, gap of a point on or within an obstacle"""


class Distances(Protocol):
    """Whatever knows how far obstacles are: a map, or a distance field."""

    def distance(self, points: Array) -> Array:
        """Return the signed distance from `points` (..., 3) to the nearest obstacle, (...) m."""

    def gradient(self, points: Array) -> Array:
        """Return its gradient, (..., 3)."""


@dataclass(frozen=True)
class DistanceField:
    """Distances on a lattice, between its points by linear interpolation; a `Distances`."""

    values: Field
    """(x, y, z) m"""
    low: Array
    """(3,) m, the first point"""
    cell: float
    """m, between two points along each axis"""

    def distance(self, points: Array) -> Array:
        """Return the distance at `points` (..., 3), (...) m; inf outside the lattice."""
        points = np.asarray(points, dtype=float)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        return interpolated(self.values, self.low, self.cell, flat)[:, 0].reshape(points.shape[:-1])

    def gradient(self, points: Array) -> Array:
        """Return the gradient at `points` (..., 3) of the distance, scaled to length 1; zero where it is flat."""
        points = np.asarray(points, dtype=float)
        flat = np.ascontiguousarray(points.reshape(-1, 3))
        slopes = interpolated(self.values, self.low, self.cell, flat)[:, 1:]
        length = np.linalg.norm(slopes, axis=1, keepdims=True)
        return (slopes / np.where(length > 0, length, 1.0)).reshape(points.shape)


@compiled
def interpolated(values: Field, low: Array, cell: float, points: Array) -> Array:
    """Return value and slopes (n, 4) of a lattice at points (n, 3) m."""
    out = np.empty((len(points), 4))
    index, part = np.empty(3, dtype=np.int64), np.empty(3)
    for i in range(len(points)):
        out[i] = 0.0
        for k in range(3):
            last = values.shape[k] - 1
            u = (points[i, k] - low[k]) / cell
            if not 0.0 <= u <= last:
                out[i, 0] = math.inf
            index[k] = min(max(int(u), 0), max(last - 1, 0))
            part[k] = u - index[k]
        if out[i, 0] > 0.0:
            continue
        for corner in range(8):
            a, b, c = corner & 1, (corner >> 1) & 1, corner >> 2
            wa, wb, wc = part[0] if a else 1 - part[0], part[1] if b else 1 - part[1], part[2] if c else 1 - part[2]
            x, y, z = (
                min(index[0] + a, values.shape[0] - 1),
                min(index[1] + b, values.shape[1] - 1),
                min(index[2] + c, values.shape[2] - 1),
            )
            value = float(values[x, y, z])
            out[i, 0] += wa * wb * wc * value
            out[i, 1] += (2 * a - 1) * wb * wc * value / cell
            out[i, 2] += (2 * b - 1) * wa * wc * value / cell
            out[i, 3] += (2 * c - 1) * wa * wb * value / cell
    return out


@dataclass(frozen=True)
class Near:
    """The nearest point of each obstacle around a vehicle, nearest first."""

    gaps: Array
    """(n,) m, to it"""
    away: Array
    """(n, 3) unit, from it to the vehicle"""
    facing: Array
    """(n,) 1, cosine between the surface's normal there and `away`: 1 but for points on the flank of an obstacle"""

    def grown(self, radius: float) -> "Near":
        """Return the same of obstacles that are thicker by a radius (m): of a vehicle that is a ball, not a point."""
        return Near(np.maximum(self.gaps - radius, INSIDE), self.away, self.facing)

    def within(self, reach: float) -> "Near":
        """Return those nearer than a reach (m)."""
        kept = self.gaps < reach
        return Near(self.gaps[kept], self.away[kept], self.facing[kept])


def facing(gaps: Array, away: Array) -> Near:
    """Return obstacles whose surfaces face the vehicle."""
    return Near(gaps, away, np.ones(len(gaps)))


NOTHING = facing(np.empty(0), np.empty((0, 3)))


@cache
def probes(planar: bool) -> Array:
    """Return where to look for obstacles, (n, 3), the reach as unit: 16 directions level, 10 more in space."""
    angle = np.arange(16) * np.pi / 8
    ways = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(16)])
    if not planar:
        steep = np.array(
            [(x, y, z) for z in (-1, 1) for x, y in ((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1))], dtype=float
        )
        ways = np.concatenate([ways, steep / np.linalg.norm(steep, axis=1, keepdims=True)])
    return np.concatenate([np.zeros((1, 3)), *(share * ways for share in SHARES)])


def near_map(world: Distances, position: Array, reach: float, planar: bool = False) -> Near:
    """Return the obstacles within `reach` (m) of a position (3,).

    The foot of a point around, the point less its distance times the gradient, lies on the obstacle nearest to it. The
    feet of points half way from there to the vehicle come closer to what is nearest to the vehicle.

    Args:
        world: knows distances
        position: (3,) m
        reach: m
        planar: whether only what is at the same height counts
    """
    points = position + reach * probes(planar)
    distance = world.distance(points)
    if not distance[0] < reach:
        return NOTHING
    if distance[0] <= 0:
        return facing(np.array([INSIDE]), world.gradient(position[None]))
    seen = np.abs(distance) < reach
    found = select(points[seen] - distance[seen, None] * world.gradient(points[seen]) - position, reach, planar)
    for _halving in range(HALVINGS):
        middle = -0.5 * found.gaps[:, None] * found.away
        feet = middle - world.distance(position + middle)[:, None] * world.gradient(position + middle)
        found = select(np.concatenate([feet, 2.0 * middle]), reach, planar)
    real = np.abs(world.distance(position - found.gaps[:, None] * found.away)) < ON_SURFACE
    found = Near(found.gaps[real], found.away[real], found.facing[real])
    normal = world.gradient(position + (ABOVE - found.gaps)[:, None] * found.away)
    return Near(found.gaps, found.away, np.maximum(0.0, (normal * found.away).sum(axis=1)))


def near_scan(scan: Scan, state: State, reach: float, planar: bool = False) -> Near:
    """Return the obstacles within `reach` (m) of a vehicle as a sensor sees them.

    Args:
        scan: seen from where the vehicle is
        state: of the vehicle
        reach: m
        planar: whether only what is at the same height counts
    """
    hit = np.isfinite(scan.ranges)
    offsets = scan.origin + scan.ranges[hit, None] * scan.directions[hit]
    return select(offsets @ body_axes(state.attitude), reach, planar)


def body_axes(attitude: Array) -> Array:
    """Return the axes of the body in the world, the rows of (3, 3), of a unit quaternion xyzw (4,)."""
    x, y, z, w = attitude
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
            [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
            [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def near_others(others: Others, position: Array, reach: float) -> tuple[Near, Array]:
    """Return the balls within `reach` (m) of a position (3,) that move, and their velocities (n, 3) m/s."""
    ways = position - others.position
    distance = np.linalg.norm(ways, axis=1)
    gaps = np.maximum(distance - others.radius, INSIDE)
    seen = (gaps < reach) & (distance > 0)
    return facing(gaps[seen], ways[seen] / distance[seen, None]), others.velocity[seen]


def select(offsets: Array, reach: float, planar: bool) -> Near:
    """Return the obstacles that points of their surfaces at offsets (n, 3) m from the vehicle belong to."""
    if planar:
        offsets = offsets * [1.0, 1.0, 0.0]
    gaps = np.linalg.norm(offsets, axis=1)
    kept = (gaps < reach) & (gaps > 0)
    gaps, away = gaps[kept], -offsets[kept] / gaps[kept, None]
    chosen = distinct(gaps, away, APART, MOST)
    return facing(gaps[chosen], away[chosen])


@compiled
def distinct(gaps: Array, away: Array, cosine: float, most: int) -> NDArray[np.int64]:
    """Return which points (n,) are the nearest of their surroundings, nearest first.

    A point that lies within the angle of a nearer one that was chosen counts as the same obstacle.
    """
    free = np.ones(len(gaps), dtype=np.bool_)
    chosen = np.empty(most, dtype=np.int64)
    count = 0
    while count < most:
        best = -1
        for i in range(len(gaps)):
            if free[i] and (best < 0 or gaps[i] < gaps[best]):
                best = i
        if best < 0:
            break
        chosen[count] = best
        count += 1
        for i in range(len(gaps)):
            if free[i] and (
                away[i, 0] * away[best, 0] + away[i, 1] * away[best, 1] + away[i, 2] * away[best, 2] >= cosine
            ):
                free[i] = False
        free[best] = False
    return chosen[:count]
