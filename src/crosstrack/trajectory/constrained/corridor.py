"""Corridors: convex sets, one for each segment of a trajectory, that its whole piece must stay in.

Boxes, tubes around the chords, or polytopes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import Problem
from crosstrack.trajectory.arguments import as_numbers
from crosstrack.trajectory.conditions import numbers
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Boxes:
    """Keep each piece in a box of its own, low <= p(t) <= high on every axis."""

    low: ArrayLike
    """(segments, d) m; -inf is open"""
    high: ArrayLike
    """(segments, d) m; inf is open"""

    def faults(self, points: Array) -> list[Problem]:
        """Return what is wrong with them for waypoints (n, d)."""
        shape = (len(points) - 1, points.shape[1])
        sides = [as_numbers(side) for side in (self.low, self.high)]
        names = ("corridor.low", "corridor.high")
        wrong = [
            Problem(name, f"must have the shape {shape}, found {side.shape}")
            for name, side in zip(names, sides, strict=True)
            if side.shape != shape
        ]
        if wrong:
            return wrong
        bad = np.argwhere(~(sides[0] < sides[1]))
        return [
            Problem(f"corridor.low[{i}, {d}]", f"must be below high, found {sides[0][i, d]:g} and {sides[1][i, d]:g} m")
            for i, d in bad[:5]
        ]


@dataclass(frozen=True, eq=False)
class Tube:
    """Keep each piece within a distance of its chord, the straight line between its waypoints.

    So the trajectory is nowhere farther than that from the line through the waypoints.
    """

    radius: ArrayLike
    """m, or (segments,) m"""

    def faults(self, points: Array) -> list[Problem]:
        """Return what is wrong with it for waypoints (n, d)."""
        radius, count = as_numbers(self.radius), len(points) - 1
        if radius.shape not in {(), (count,)} or not ((radius > 0) & np.isfinite(radius)).all():
            return [Problem("corridor.radius", f"must be one or {count} numbers above 0, found {self.radius!r:.60}")]
        return []


@dataclass(frozen=True, eq=False)
class Polytopes:
    """Keep each piece in a convex polytope of its own, A p(t) <= b."""

    faces: Sequence[tuple[ArrayLike, ArrayLike]]
    """for every segment A (m, d), outward normals of any length but zero, and b (m,)"""

    def faults(self, points: Array) -> list[Problem]:
        """Return what is wrong with them for waypoints (n, d)."""
        count, dimensions = len(points) - 1, points.shape[1]
        if len(self.faces) != count:
            return [Problem("corridor.faces", f"must be one for each of the {count} segments, found {len(self.faces)}")]
        found: list[Problem] = []
        for i, face in enumerate(self.faces):
            place = f"corridor.faces[{i}]"
            if not isinstance(face, Sequence) or len(face) != 2:
                found.append(Problem(place, f"must be a pair of A (m, {dimensions}) and b (m,), found {face!r:.60}"))
                continue
            normals, offsets = face
            a = numbers(f"{place}.A", normals, 2, found)
            b = numbers(f"{place}.b", offsets, 1, found)
            if a.size and b.size and (a.shape[1] != dimensions or len(a) != len(b)):
                shapes = f"found {a.shape} and {b.shape}"
                found.append(Problem(place, f"must be A (m, {dimensions}) and b (m,), {shapes}"))
            elif a.size and not np.linalg.norm(a, axis=1).all():
                found.append(Problem(f"{place}.A", "must not have a row of zeros"))
        return found


Corridor = Boxes | Tube | Polytopes


def subdivide(waypoints: ArrayLike, times: ArrayLike, spacing: float) -> tuple[Array, Array]:
    """Split every leg into the fewest equal parts no longer than a spacing, each of equal time.

    More knots let a trajectory follow its legs more closely.

    Args:
        waypoints: (n, d) m
        times: (n,) s
        spacing: m, at most between neighbours

    Returns:
        waypoints (k, d) and times (k,), with those given among them.

    Example:
        >>> from crosstrack.trajectory.constrained.corridor import subdivide
        >>> points, times = subdivide([[0, 0], [1, 0], [1, 0.5]], [0, 2, 3], 0.5)
        >>> points.tolist(), times.tolist()
        ([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5]], [0.0, 1.0, 2.0, 3.0])
    """
    points, moments = np.asarray(waypoints, float), np.asarray(times, float)
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    parts = np.maximum(np.ceil(lengths / spacing - 1e-9).astype(int), 1)
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[leg]
    inner = points[leg] + share[:, None] * (points[leg + 1] - points[leg])
    between = moments[leg] + share * (moments[leg + 1] - moments[leg])
    return np.concatenate([inner, points[-1:]]), np.concatenate([between, moments[-1:]])
