"""Curves made of straight lines and circular arcs, by arc length."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

SAME = 1e-9
"""m, distances that differ by less are equal: the earlier point wins, so that legs flown twice do not mix"""


@dataclass(frozen=True, eq=False)
class Pieces:
    """A path of lines and arcs: piece k is o + sin(κu)/κ t + (1 - cos κu)/κ n for u in [0, l], a line where κ = 0."""

    origins: Array
    """(pieces, 3) m"""
    tangents: Array
    """(pieces, 3) unit, at the start of each piece"""
    normals: Array
    """(pieces, 3) unit, towards the centre of an arc; zero for a line"""
    curvatures: Array
    """(pieces,) 1/m, not negative"""
    lengths: Array
    """(pieces,) m, positive"""

    @cached_property
    def knots(self) -> Array:
        """(pieces + 1,) m, arc length where each piece starts, and the whole length"""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def length(self) -> float:
        """m"""
        return float(self.knots[-1])

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (m, shape (...)): point, unit tangent or curvature vector for order 0, 1, 2."""
        if isinstance(s, float):
            return evaluated(s, order, self.knots, *self.arrays)
        s = np.asarray(s, float)
        out = np.empty((s.size, 3))
        evaluate(s.ravel(), order, self.knots, *self.arrays, out)
        return out.reshape((*s.shape, 3))

    def project(self, point: Array, near: float, reach: float) -> float:
        """Return the arc length in [near, near + reach] whose point is closest to `point` (3,), the first of equals."""
        return float(closest(point, near, near + reach, self.knots, *self.arrays)[0])

    def trace(self, points: Array, start: float = 0.0) -> tuple[Array, Array]:
        """Follow a flown track: progress and cross-track error, both (n,) m, for `points` (n, 3) m in their order.

        Progress never goes back. The reach ahead grows with the cross-track error and with the distance flown since
        progress last kept up with the vehicle, so that corners may be cut, hairpins too, but crossings do not jump.
        The error is the distance to the path within that reach of the progress, ahead and behind.
        """
        progress, errors = np.empty(len(points)), np.empty(len(points))
        walk(points, start, self.knots, *self.arrays, progress, errors)
        return progress, errors

    @cached_property
    def arrays(self) -> tuple[Array, Array, Array, Array, Array]:
        """The fields in the order the compiled functions take them."""
        return self.origins, self.tangents, self.normals, self.curvatures, self.lengths


@compiled
def piece_at(s: float, knots: Array) -> int:
    """Return which piece holds the arc length `s` (m); the first and the last reach beyond the ends."""
    return min(max(int(np.searchsorted(knots, s, side="right")) - 1, 0), knots.size - 2)


@compiled
def fill(
    s: float,
    order: int,
    knots: Array,
    origins: Array,
    tangents: Array,
    normals: Array,
    curvatures: Array,
    lengths: Array,
    out: Array,
) -> None:
    """Fill `out` (3,) with the point, tangent or curvature vector at `s`."""
    k = piece_at(s, knots)
    u = min(max(s - knots[k], 0.0), lengths[k])
    curvature = curvatures[k]
    sine, cosine = np.sin(curvature * u), np.cos(curvature * u)
    for j in range(3):
        t, n = tangents[k, j], normals[k, j]
        if order == 0:
            along = sine / curvature if curvature > 0 else u
            aside = (1 - cosine) / curvature if curvature > 0 else 0.0
            out[j] = origins[k, j] + along * t + aside * n
        elif order == 1:
            out[j] = cosine * t + sine * n
        else:
            out[j] = curvature * (cosine * n - sine * t)


@compiled
def evaluated(
    s: float,
    order: int,
    knots: Array,
    origins: Array,
    tangents: Array,
    normals: Array,
    curvatures: Array,
    lengths: Array,
) -> Array:
    """Return the point, tangent or curvature vector (3,) at `s`."""
    out = np.empty(3)
    fill(s, order, knots, origins, tangents, normals, curvatures, lengths, out)
    return out


@compiled
def evaluate(
    s: Array,
    order: int,
    knots: Array,
    origins: Array,
    tangents: Array,
    normals: Array,
    curvatures: Array,
    lengths: Array,
    out: Array,
) -> None:
    """Fill `out` (n, 3) with points, tangents or curvature vectors at `s` (n,)."""
    for i in range(s.size):
        fill(s[i], order, knots, origins, tangents, normals, curvatures, lengths, out[i])


@compiled
def foot(px: float, py: float, curvature: float, low: float, high: float) -> float:
    """Return the u in [low, high] of a piece closest to the point with coordinates px along t and py along n."""
    if curvature <= 0:
        return min(max(px, low), high)
    angle, middle = math.atan2(px, 1 / curvature - py), 0.5 * (low + high) * curvature
    if angle < middle - math.pi:
        angle += 2 * math.pi
    return min(max(angle / curvature, low), high)


@compiled
def closest(
    point: Array,
    low: float,
    high: float,
    knots: Array,
    origins: Array,
    tangents: Array,
    normals: Array,
    curvatures: Array,
    lengths: Array,
) -> tuple[float, float]:
    """Return arc length and distance of the point of the path within [low, high] closest to a point (3,)."""
    low = min(max(low, 0.0), knots[-1])
    high = min(max(high, low), knots[-1])
    best_s, best = low, np.inf
    k = piece_at(low, knots)
    while k < lengths.size and knots[k] <= high:
        x, y, z = point[0] - origins[k, 0], point[1] - origins[k, 1], point[2] - origins[k, 2]
        t, n, curvature = tangents[k], normals[k], curvatures[k]
        px = x * t[0] + y * t[1] + z * t[2]
        py = x * n[0] + y * n[1] + z * n[2]
        u = foot(px, py, curvature, max(0.0, low - knots[k]), min(lengths[k], high - knots[k]))
        along = np.sin(curvature * u) / curvature if curvature > 0 else u
        aside = (1 - np.cos(curvature * u)) / curvature if curvature > 0 else 0.0
        dx = x - along * t[0] - aside * n[0]
        dy = y - along * t[1] - aside * n[1]
        dz = z - along * t[2] - aside * n[2]
        distance = np.sqrt(dx * dx + dy * dy + dz * dz)
        if distance < best - SAME:
            best_s, best = knots[k] + u, distance
        k += 1
    return best_s, best


@compiled
def walk(
    points: Array,
    start: float,
    knots: Array,
    origins: Array,
    tangents: Array,
    normals: Array,
    curvatures: Array,
    lengths: Array,
    progress: Array,
    errors: Array,
) -> None:
    """Fill progress and errors (n,) of a track (n, 3), see `Pieces.trace`."""
    near, astray = start, 0.0
    _, error = closest(points[0], near, near, knots, origins, tangents, normals, curvatures, lengths)
    for i in range(points.shape[0]):
        j = max(i - 1, 0)
        dx, dy, dz = points[i, 0] - points[j, 0], points[i, 1] - points[j, 1], points[i, 2] - points[j, 2]
        moved = np.sqrt(dx * dx + dy * dy + dz * dz)
        before, reach = near, reach_of(error, astray + moved)
        near, _ = closest(points[i], near, near + reach, knots, origins, tangents, normals, curvatures, lengths)
        _, error = closest(
            points[i], near - reach, near + reach, knots, origins, tangents, normals, curvatures, lengths
        )
        astray = astray + moved if near - before < 0.5 * moved else 0.0
        progress[i], errors[i] = near, error


@compiled
def reach_of(error: float, moved: float) -> float:
    """Return how far ahead (m) to look for the closest point after a move (m) at a cross-track error (m)."""
    return 0.1 + 2 * moved + 3 * error
