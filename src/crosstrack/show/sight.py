"""Which points of a drawing in space are hidden from a far viewer."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

NEAR = 1e-3
"""m, by which a face has to be nearer to hide a point: what lies on a face is seen"""


def towards(elevation: float, azimuth: float) -> Array:
    """Return the unit vector (3,) to a viewer at an elevation and an azimuth in degrees."""
    up, around = np.radians([elevation, azimuth])
    return np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])


def hidden(points: Array, corners: Array, viewer: Array) -> NDArray[np.bool_]:
    """Return which points lie behind triangles, (n,) bool, seen in parallel projection.

    Args:
        points: (n, 3) m
        corners: (m, 3, 3) m, of the triangles
        viewer: (3,) unit vector from the scene to the viewer, not vertical
    """
    right = np.cross([0.0, 0.0, 1.0], viewer)
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(viewer, right), viewer])
    return behind(np.ascontiguousarray(points @ axes), np.ascontiguousarray(corners @ axes))


@compiled
def behind(points: Array, corners: Array) -> NDArray[np.bool_]:
    """Return which points (n, 3) lie under triangles (m, 3, 3), (n,): right, up and nearness of each, m.

    A triangle covers a point that lies on the same side of all its edges; the areas that the point spans with
    the edges weigh the nearness of the corners.
    """
    found = np.zeros(len(points), dtype=np.bool_)
    for j in range(len(corners)):
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners[j, 0], corners[j, 1], corners[j, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        low_x, high_x = min(ax, bx, cx), max(ax, bx, cx)
        low_y, high_y = min(ay, by, cy), max(ay, by, cy)
        for i in range(len(points)):
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            if found[i] or x < low_x or x > high_x or y < low_y or y > high_y:
                continue
            a = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / area
            b = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / area
            c = 1.0 - a - b
            found[i] = a >= 0.0 and b >= 0.0 and c >= 0.0 and a * az + b * bz + c * cz > z + NEAR
    return found
