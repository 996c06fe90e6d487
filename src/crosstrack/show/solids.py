"""Obstacles in a picture in space: their faces turned to the viewer, in the light, and what they hide."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.colors import LightSource, to_rgb
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from crosstrack.flight.scene import Scene
from crosstrack.show.sight import hidden, towards
from crosstrack.show.stage import groups
from crosstrack.show.style import MOVING
from crosstrack.show.traffic import Track
from crosstrack.types import Array

ELEVATION, AZIMUTH = 32.0, -122.0
"""degrees, where the view in space is taken from"""


def faces(drawn: Scene, moving: Sequence[Track]) -> tuple[Array, Array]:
    """Return the faces of obstacles turned to the viewer, so that none shines through another, and their colours.

    Moving ones are where they came nearest to the vehicle.

    Returns:
        (n, 3, 3) m and (n, 3)
    """
    meshes = [(group.mesh, group.color) for group in groups(drawn)]
    meshes += [((track.met, track.mesh.triangles), MOVING) for track in moving]
    corners = [vertices[triangles] for (vertices, triangles), _ in meshes]
    colors = [np.tile(to_rgb(color), (len(triangles), 1)) for (_, triangles), color in meshes]
    every = np.concatenate([np.empty((0, 3, 3)), *corners])
    normals = np.cross(every[:, 1] - every[:, 0], every[:, 2] - every[:, 0])
    turned = normals @ towards(ELEVATION, AZIMUTH) > 0.0
    return every[turned], np.concatenate([np.empty((0, 3)), *colors])[turned]


def lit(corners: Array, colors: Array) -> Poly3DCollection:
    """Return faces (n, 3, 3) m, at least one, in the light."""
    light = LightSource(azdeg=200, altdeg=50)
    look: dict[str, Any] = {"shade": True, "lightsource": light, "antialiased": False, "zorder": 1}
    return Poly3DCollection(corners, facecolors=colors, **look)


def behind(points: Array, corners: Array) -> NDArray[np.bool_]:
    """Return which points (n, 3) m are hidden by faces (m, 3, 3) m, (n,)."""
    return hidden(points, corners, towards(ELEVATION, AZIMUTH))


def unhidden(points: Array, corners: Array) -> Array:
    """Return points (n, 3) m with NaN for those that faces (m, 3, 3) m hide."""
    return np.where(behind(points, corners)[:, None], np.nan, points)
