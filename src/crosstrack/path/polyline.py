"""Straight legs from point to point."""

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.path.pieces import Pieces
from crosstrack.types import Array

SHORTEST = 1e-6
"""m, points closer to the one before are the same point"""


class Polyline(Pieces):
    """A path of straight legs; self-crossing, closed, reversing and dense paths are all fine.

    Args:
        points: (n, 3) m, or (n, 2) in the plane z = 0; repeated points count once
        closed: whether a last leg leads back to the first point

    Raises:
        InputError: not finite, not of that shape, or fewer than two distinct points.
    """

    points: Array
    """(n, 3) m, the distinct corners in order"""

    def __init__(self, points: object, closed: bool = False) -> None:
        corners = distinct(checked(points), closed)
        legs = np.diff(corners, axis=0)
        lengths = np.linalg.norm(legs, axis=1)
        zeros = np.zeros(len(legs))
        super().__init__(corners[:-1], legs / lengths[:, None], np.zeros_like(legs), zeros, lengths)
        object.__setattr__(self, "points", corners)


def checked(points: object) -> Array:
    """Return points as (n, 3) floats, or raise InputError."""
    try:
        corners = np.array(points, float)
    except (TypeError, ValueError):
        raise InputError("path", [Problem("points", "not an array of numbers")]) from None
    if corners.ndim != 2 or corners.shape[1] not in (2, 3):
        raise InputError("path", [Problem("points", f"shape {corners.shape}, allowed are (n, 2) and (n, 3)")])
    bad = np.flatnonzero(~np.isfinite(corners).all(axis=1))
    if bad.size:
        raise InputError("path", [Problem(f"points[{i}]", f"{corners[i]}, must be finite") for i in bad])
    return corners if corners.shape[1] == 3 else np.column_stack([corners, np.zeros(len(corners))])


def distinct(corners: Array, closed: bool) -> Array:
    """Drop points that repeat the one before, and close the path where asked."""
    if closed:
        corners = np.vstack([corners, corners[:1]])
    keep = [0]
    for i in range(1, len(corners)):
        if np.linalg.norm(corners[i] - corners[keep[-1]]) > SHORTEST:
            keep.append(i)
    if len(keep) < 2:
        raise InputError("path", [Problem("points", "fewer than two distinct points")])
    return corners[keep]
