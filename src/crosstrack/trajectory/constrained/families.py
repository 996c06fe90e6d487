"""Constraints on every instant, by kind: the convex set of each piece as rows of a cone, and where a curve leaves it.

All is relative: rows are divided by the size of what they bound, so an excess of 0.01 is 1 % of a radius or of a limit.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from crosstrack.trajectory.certified.extremes import Peaks, halfspace_peaks, norm_peaks
from crosstrack.trajectory.certified.polyline_distance import deviation_peaks
from crosstrack.trajectory.constrained.cones import Indices
from crosstrack.trajectory.constrained.corridor import Boxes, Corridor, Polytopes, Tube
from crosstrack.trajectory.limits import Bound
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TOLERANCE = 1e-7
"""relative, of certified extremes"""


@dataclass(frozen=True, eq=False)
class Sets:
    """The convex set of each piece, {v: b - N v - c θ in a cone}."""

    first: Indices
    """(N + 1,) first row of each piece, and how many there are"""
    round: int
    """how many rows of a piece, from its first on, form a second-order cone"""
    normals: Array
    """(rows, d)"""
    slides: Array
    """(rows,)"""
    bounds: Array
    """(rows,)"""
    firm: Array
    """(rows,) by how much a bound shrinks when its set is tightened by 1: 1 or 0"""
    sizes: Array
    """(rows,) m or m/s^k, what the row was divided by"""


@dataclass(frozen=True, eq=False)
class Excess:
    """Where a curve comes nearest to leaving the sets, or is outside by the most: several entries a piece."""

    piece: Indices
    """(n,)"""
    tau: Array
    """(n,) unit time"""
    bound: Array
    """(n,) certified: nowhere on the piece more than this, relative; positive is outside"""
    size: Array
    """(n,) m or m/s^k, what it is relative to"""


class Family(Protocol):
    """One kind of constraint on every instant of a trajectory."""

    @property
    def name(self) -> str:
        """What it is called in messages."""

    @property
    def order(self) -> int:
        """The derivative it holds."""

    @property
    def sets(self) -> Sets:
        """The sets of all pieces."""

    @property
    def finite(self) -> bool:
        """Whether it is held at the knots only, at the start of each piece, and not at every instant."""

    def excess(self, curve: PiecewisePolynomial) -> Excess:
        """Return where a curve is least inside."""


@dataclass(frozen=True, eq=False)
class Faces:
    """The position lies in polytopes."""

    sets: Sets
    piece: Indices
    """(rows,) of each face"""
    name: str = "corridor"
    order: int = 0
    finite: bool = False

    def excess(self, curve: PiecewisePolynomial) -> Excess:
        """Return one entry a face."""
        rows = self.sets
        found = halfspace_peaks(curve, 0, self.piece, rows.normals, rows.bounds, tolerance=TOLERANCE)
        return entries(curve, found, found.bound, rows.sizes)


@dataclass(frozen=True, eq=False)
class Capsules:
    """The position lies within a radius of the chord of its piece."""

    sets: Sets
    corners: Array
    """(N + 1, d) m"""
    radius: Array
    """(N,) m"""
    name: str = "corridor"
    order: int = 0
    finite: bool = False

    def excess(self, curve: PiecewisePolynomial) -> Excess:
        """Return one entry a piece."""
        found = deviation_peaks(curve, self.corners, tolerance=TOLERANCE * float(self.radius.min()))
        return entries(curve, found, found.bound / self.radius - 1.0, self.radius)


@dataclass(frozen=True, eq=False)
class Norms:
    """The norm of a derivative over some axes is limited."""

    sets: Sets
    limit: Bound

    @property
    def name(self) -> str:
        """What it is called in messages."""
        return self.limit.name

    @property
    def order(self) -> int:
        """The derivative it holds."""
        return self.limit.order

    @property
    def finite(self) -> bool:
        """Held at every instant."""
        return False

    def excess(self, curve: PiecewisePolynomial) -> Excess:
        """Return one entry a piece."""
        found = norm_peaks(curve, self.order, self.limit.axes, tolerance=TOLERANCE)
        return entries(curve, found, found.bound / self.limit.most - 1.0, np.full(len(found.bound), self.limit.most))


@dataclass(frozen=True, eq=False)
class Knots:
    """The position at the inner knots, and there only, lies in a box around the waypoint."""

    sets: Sets
    corners: Array
    """(N + 1, d) m"""
    radius: float
    """m, half the side"""
    name: str = "corridor"
    order: int = 0
    finite: bool = True

    def excess(self, curve: PiecewisePolynomial) -> Excess:
        """Return one entry an inner knot, as the start of the piece after it."""
        off = np.abs(curve.coefficients[1:, 0] - self.corners[1:-1]).max(axis=1, initial=0.0)
        count = len(off)
        return Excess(np.arange(1, count + 1), np.zeros(count), off / self.radius - 1.0, np.full(count, self.radius))


def entries(curve: PiecewisePolynomial, found: Peaks, bound: Array, size: Array) -> Excess:
    """Return peaks on the time of the curve as entries."""
    tau = np.clip((found.time - curve.knots[found.piece]) / curve.durations[found.piece], 0.0, 1.0)
    return Excess(found.piece, tau, bound, size)


def knot_family(radius: float, points: Array) -> Knots:
    """Return boxes of half side r around the inner points of (N + 1, d), at the start of pieces 1 to N - 1."""
    count, dimensions = len(points) - 2, points.shape[1]
    sides = np.concatenate([np.eye(dimensions), -np.eye(dimensions)]) / radius
    bounds = 1.0 + (points[1:-1] @ sides.T).ravel()
    first = np.maximum(np.arange(count + 2) - 1, 0) * len(sides)
    rows = np.tile(sides, (count, 1)), np.zeros(len(bounds)), bounds, np.ones(len(bounds)), np.full(len(bounds), radius)
    return Knots(Sets(first, 0, *rows), points, radius)


def corridor_family(corridor: float | Corridor, points: Array, origin: Array) -> Family:
    """Return a corridor as constraints on positions relative to an origin, for waypoints (N + 1, d) relative to it."""
    if not isinstance(corridor, Corridor):
        return knot_family(float(corridor), points)
    if isinstance(corridor, Tube):
        radius = np.broadcast_to(np.asarray(corridor.radius, float), len(points) - 1)
        return Capsules(capsules(points, radius), points, radius)
    if isinstance(corridor, Boxes):
        return box_faces(np.asarray(corridor.low, float) - origin, np.asarray(corridor.high, float) - origin)
    return polytope_faces(corridor, points, origin)


def capsules(points: Array, radius: Array) -> Sets:
    """Return ‖p - a - θ (b - a)‖ <= r, 0 <= θ <= 1 for radii (N,) and the chords of points (N + 1, d)."""
    count, dimensions = len(points) - 1, points.shape[1]
    size = dimensions + 3
    normals, slides, bounds, firm = np.zeros((count, size, dimensions)), *np.zeros((3, count, size))
    normals[:, 1 : dimensions + 1] = -np.eye(dimensions) / radius[:, None, None]
    chord = np.diff(points, axis=0)
    slides[:, 1 : dimensions + 1] = chord / radius[:, None]
    bounds[:, 0], firm[:, 0] = 1.0, 1.0
    bounds[:, 1 : dimensions + 1] = -points[:-1] / radius[:, None]
    slides[:, dimensions + 1], slides[:, dimensions + 2] = -1.0, 1.0
    bounds[:, dimensions + 2] = 1.0
    sizes = np.repeat(radius, size)
    rows = normals.reshape(-1, dimensions), slides.ravel(), bounds.ravel(), firm.ravel(), sizes
    return Sets(np.arange(count + 1) * size, dimensions + 1, *rows)


def box_faces(low: Array, high: Array) -> Faces:
    """Return boxes (N, d) as faces; open sides have none."""
    dimensions = low.shape[1]
    half = np.where(np.isfinite(high - low), 0.5 * (high - low), 1.0)
    normals = np.concatenate([np.eye(dimensions), -np.eye(dimensions)])
    offsets = np.concatenate([high, -low], axis=1)
    piece, side = np.nonzero(np.isfinite(offsets))
    size = np.concatenate([half, half], axis=1)[piece, side]
    first = np.concatenate([[0], np.cumsum(np.isfinite(offsets).sum(axis=1))])
    rows = normals[side] / size[:, None], np.zeros(len(piece)), offsets[piece, side] / size
    return Faces(Sets(first, 0, *rows, np.ones(len(piece)), size), piece)


def polytope_faces(corridor: Polytopes, points: Array, origin: Array) -> Faces:
    """Return polytopes as faces, each divided by how far it is from the middle of its chord."""
    counts = np.array([len(np.asarray(offsets)) for _, offsets in corridor.faces])
    piece = np.repeat(np.arange(len(counts)), counts)
    normals = np.concatenate([np.asarray(a, float) for a, _ in corridor.faces])
    offsets = np.concatenate([np.asarray(b, float) for _, b in corridor.faces]) - normals @ origin
    length = np.linalg.norm(normals, axis=1)
    normals, offsets = normals / length[:, None], offsets / length
    middle = 0.5 * (points[:-1] + points[1:])
    room = np.abs(offsets - np.einsum("nd,nd->n", normals, middle[piece]))
    size = np.maximum(room, 1e-3 * np.maximum.reduceat(room, np.cumsum(counts) - counts)[piece])
    size = np.where(size > 0.0, size, 1.0)
    first = np.concatenate([[0], np.cumsum(counts)])
    rows = normals / size[:, None], np.zeros(len(piece)), offsets / size
    return Faces(Sets(first, 0, *rows, np.ones(len(piece)), size), piece)


def limit_family(limit: Bound, count: int, dimensions: int) -> Norms:
    """Return a limit as constraints of the norm on each of `count` pieces."""
    size = len(limit.axes) + 1
    normals, bounds, firm = np.zeros((count, size, dimensions)), *np.zeros((2, count, size))
    for row, axis in enumerate(limit.axes, start=1):
        normals[:, row, axis] = -1.0 / limit.most
    bounds[:, 0] = firm[:, 0] = 1.0
    rows = normals.reshape(-1, dimensions), np.zeros(count * size), bounds.ravel(), firm.ravel()
    return Norms(Sets(np.arange(count + 1) * size, size, *rows, np.full(count * size, limit.most)), limit)


def inside(sets: Sets, points: Array) -> Array:
    """Return how far inside the sets points (N, d), one a piece, are, (N,) relative; infinity where it depends on θ."""
    count = len(sets.first) - 1
    piece = np.repeat(np.arange(count), np.diff(sets.first))
    if sets.slides.any():
        return np.full(count, np.inf)
    slack = sets.bounds - np.einsum("nd,nd->n", sets.normals, points[piece])
    if sets.round:
        rows = slack.reshape(count, sets.round)
        return np.asarray(rows[:, 0] - np.linalg.norm(rows[:, 1:], axis=1))
    depth = np.full(count, np.inf)
    np.minimum.at(depth, piece, slack)
    return depth
