"""The messages that the log holds once: the route and the course as paths, the world as markers."""

from collections.abc import Sequence

import numpy as np

from crosstrack.flight.cdr import Builder
from crosstrack.flight.scene import Mesh
from crosstrack.flight.topics import WORLD
from crosstrack.types import Array

TRIANGLES = 11
"""visualization_msgs/Marker: TRIANGLE_LIST"""
IDENTITY = (0.0, 0.0, 0.0, 1.0)


def header(message: Builder) -> None:
    """Append a std_msgs/Header of time zero in the world frame."""
    message.put("<i4", 0)
    message.put("<u4", 0)
    message.text(WORLD)


def path(points: Array) -> bytes:
    """Return nav_msgs/Path through points (n, 3) m."""
    message = Builder()
    header(message)
    message.put("<u4", len(points))
    for x, y, z in points.tolist():
        header(message)
        message.put("<f8", x, y, z, *IDENTITY)
    return bytes(message.data)


def markers(meshes: Sequence[Mesh]) -> bytes:
    """Return visualization_msgs/MarkerArray of triangle lists."""
    message = Builder()
    message.put("<u4", len(meshes))
    for number, mesh in enumerate(meshes):
        marker(message, number, mesh)
    return bytes(message.data)


def marker(message: Builder, number: int, mesh: Mesh) -> None:
    """Append one visualization_msgs/Marker."""
    name, vertices, triangles = mesh
    corners = np.asarray(vertices, dtype="<f8")[triangles.reshape(-1)]
    header(message)
    message.text(name)
    message.put("<i4", number, TRIANGLES, 0)
    message.put("<f8", 0.0, 0.0, 0.0, *IDENTITY)
    message.put("<f8", 1.0, 1.0, 1.0)
    message.put("<f4", 0.55, 0.58, 0.62, 1.0)
    message.put("<i4", 0)
    message.put("<u4", 0)
    message.put("u1", 0)
    message.put("<u4", len(corners))
    message.array(corners)
    message.put("<u4", 0)
    trimmings(message)


def trimmings(message: Builder, text: str = "") -> None:
    """Append the end of a Marker, from texture_resource on, all empty but its text."""
    message.text("")
    header(message)
    message.text("")
    message.put("<u4", 0, 0)
    message.text(text)
    message.text("")
    message.text("")
    message.put("<u4", 0)
    message.put("u1", 0)
