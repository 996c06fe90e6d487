"""The messages of what clients draw: visualization_msgs/MarkerArray."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene.markers import FOREVER, Marker
from crosstrack.flight import still
from crosstrack.flight.cdr import Builder
from crosstrack.flight.served_calls import clean
from crosstrack.flight.topics import WORLD
from crosstrack.types import Array

Color = tuple[float, float, float, float]
CENTIMETRE = 0.01
"""m, of AirSim's units of size"""
THINNEST = 0.02
"""m, of what is drawn"""
ARROW, LINES, POINTS, TEXT = 0, 5, 8, 9
"""visualization_msgs/Marker: its types"""
HEAD = 3.0
"""thicknesses of the shaft, of the head of an arrow"""
LETTER = 0.5
"""m, height of letters of scale 1"""
RED_GREEN_BLUE: tuple[Color, ...] = ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0))
"""of the axes of transforms"""


@dataclass(frozen=True)
class Part:
    """What one ROS marker draws."""

    kind: int
    points: Array
    """(n, 3) m, world ENU"""
    color: Color
    scale: tuple[float, float, float]
    """m"""
    colors: Array | None = None
    """(n, 4) of every point, where they differ"""
    text: str = ""


def message(markers: Sequence[Marker], first: int) -> bytes:
    """Return visualization_msgs/MarkerArray of markers whose parts are numbered from `first` on."""
    found = [(marker, part) for marker in markers for part in parts(marker)]
    built = Builder()
    built.put("<u4", len(found))
    for number, (marker, part) in enumerate(found, first):
        put(built, number % 2**31, marker, part)
    return bytes(built.data)


def count(markers: Sequence[Marker]) -> int:
    """Return how many parts markers have."""
    return sum(1 for marker in markers for _ in parts(marker))


def parts(marker: Marker) -> Iterator[Part]:
    """Yield what draws a marker: arrows and texts one by one, all else at once."""
    points, size = frames.enu_from_ned(marker.points), max(CENTIMETRE * marker.size, THINNEST)
    match marker.kind:
        case "points":
            yield Part(POINTS, points, marker.color, (size, size, 0.0))
        case "lines":
            yield Part(LINES, points, marker.color, (size, 0.0, 0.0))
        case "arrows":
            for pair in points.reshape(-1, 2, 3):
                yield Part(ARROW, pair, marker.color, (size, HEAD * size, 0.0))
        case "transforms" if marker.orientations is not None:
            ends = axes(points, marker.orientations, CENTIMETRE * marker.size)
            colors = np.tile(np.repeat(RED_GREEN_BLUE, 2, axis=0), (len(points), 1))
            yield Part(LINES, ends, marker.color, (THINNEST, 0.0, 0.0), colors)
    for point, text in zip(points, marker.texts, strict=False):
        yield Part(TEXT, point[None], marker.color, (0.0, 0.0, LETTER), text=clean(text))


def axes(points: Array, orientations: Array, length: float) -> Array:
    """Return the axes of poses as pairs of points (6 n, 3) m, ENU: north, east and down of each, turned.

    Args:
        points: (n, 3) m, ENU
        orientations: (n, 4) xyzw, NED
        length: m, of an axis
    """
    turn = orientations / np.maximum(np.linalg.norm(orientations, axis=1, keepdims=True), 1e-9)
    axis, scalar = turn[:, None, :3], turn[:, None, 3:]
    unit = np.eye(3)[None]
    turned = unit + 2.0 * np.cross(axis, np.cross(axis, unit) + scalar * unit)
    starts = np.repeat(points[:, None], 3, axis=1)
    return np.stack([starts, starts + length * frames.enu_from_ned(turned)], axis=2).reshape(-1, 3)


def put(built: Builder, number: int, marker: Marker, part: Part) -> None:
    """Append one visualization_msgs/Marker."""
    at = part.points[0] if part.kind == TEXT else np.zeros(3)
    drawn = part.points if part.kind != TEXT else np.empty((0, 3))
    lasts = 0 if marker.ends >= FOREVER else max(marker.ends - marker.begins, 1)
    built.put("<i4", marker.begins // 10**9 % 2**31)
    built.put("<u4", marker.begins % 10**9)
    built.text(WORLD)
    built.text(marker.kind)
    built.put("<i4", number, part.kind, 0)
    built.put("<f8", *at, *still.IDENTITY)
    built.put("<f8", *part.scale)
    built.put("<f4", *part.color)
    built.put("<i4", min(lasts // 10**9, 2**31 - 1))
    built.put("<u4", lasts % 10**9)
    built.put("u1", 0)
    built.put("<u4", len(drawn))
    built.array(np.ascontiguousarray(drawn, dtype="<f8"))
    colors = np.empty((0, 4)) if part.colors is None else part.colors
    built.put("<u4", len(colors))
    built.array(np.ascontiguousarray(colors, dtype="<f4"))
    still.trimmings(built, part.text)
