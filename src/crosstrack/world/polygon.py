"""Plane polygons: whether one is simple, its area, its triangles."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of plane vectors (..., 2): (...)."""
    product: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def area(corners: Array) -> float:
    """Return the signed area of a polygon (n, 2), m²; positive when counter-clockwise."""
    relative = corners - corners[0]
    return 0.5 * float(np.sum(cross(relative, np.roll(relative, -1, axis=0))))


def counter_clockwise(corners: Array) -> Array:
    """Return the polygon (n, 2) in counter-clockwise order."""
    return corners if area(corners) > 0 else corners[::-1]


def fault(corners: Array) -> str:
    """Say what keeps corners (n, 2) from being a simple polygon; empty when nothing does."""
    count = len(corners)
    if count < 3:
        return f"a polygon needs at least 3 points; found {count}"
    ahead = np.roll(corners, -1, axis=0) - corners
    same = np.flatnonzero(~ahead.any(axis=1))
    if same.size:
        return f"point {(same[0] + 1) % count} repeats the point before it: {corners[same[0]].tolist()}"
    turn, along = cross(ahead, np.roll(ahead, -1, axis=0)), np.sum(ahead * np.roll(ahead, -1, axis=0), axis=1)
    back = np.flatnonzero((turn == 0) & (along < 0))
    if back.size:
        corner = (back[0] + 1) % count
        return f"the polygon doubles back on itself at point {corner}: {corners[corner].tolist()}"
    for i in range(count - 2):
        last = count - 1 if i == 0 else count
        met = np.flatnonzero(_meet(corners[i], ahead[i], corners[i + 2 : last], ahead[i + 2 : last]))
        if met.size:
            j = i + 2 + met[0]
            return f"edges {i} and {j} of the polygon meet; a simple polygon does not touch itself"
    return ""


def _meet(start: Array, along: Array, starts: Array, alongs: Array) -> NDArray[np.bool_]:
    """Return which closed segments (n, 2) share a point with a closed segment (2,)."""
    a, b = np.sign(cross(along, starts - start)), np.sign(cross(along, starts + alongs - start))
    c, d = np.sign(cross(alongs, start - starts)), np.sign(cross(alongs, start + along - starts))
    low, high = np.minimum(start, start + along), np.maximum(start, start + along)
    lows, highs = np.minimum(starts, starts + alongs), np.maximum(starts, starts + alongs)
    boxes = np.all((low <= highs) & (lows <= high), axis=1)
    found: NDArray[np.bool_] = boxes & (a * b <= 0) & (c * d <= 0)
    return found


def triangles(corners: Array) -> NDArray[np.int64]:
    """Cut a simple counter-clockwise polygon (n, 2) into triangles by clipping ears: indices (n - 2, 3)."""
    left = list(range(len(corners)))
    cut = []
    while len(left) > 3:
        ear = next((i for i in range(len(left)) if _is_ear(corners, left, i)), 0)
        cut.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    return np.array([*cut, left], dtype=np.int64)


def _is_ear(corners: Array, left: list[int], i: int) -> bool:
    """Return whether the triangle at position `i` is convex with no other corner in it or on it."""
    names = left[i - 1], left[i], left[(i + 1) % len(left)]
    a, b, c = (corners[name] for name in names)
    if cross(b - a, c - b) <= 0:
        return False
    others = corners[[name for name in left if name not in names]]
    within = (cross(b - a, others - a) >= 0) & (cross(c - b, others - b) >= 0) & (cross(a - c, others - c) >= 0)
    return not within.any()
