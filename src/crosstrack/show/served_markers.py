"""What clients drew, as traces of the page's figures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene.markers import Marker
from crosstrack.flight.served_calls import clean
from crosstrack.flight.served_markers import CENTIMETRE, RED_GREEN_BLUE, Color, axes
from crosstrack.show.traces import Figure, flat, line2, line3, mark, mark3, points
from crosstrack.types import Array

MOST_POINTS = 50_000
"""of all markers, that are drawn"""
MOST_TEXTS = 500
MOST_COLORS = 24
"""of traces; what has a rarer colour is drawn in the nearest of them"""
LIGHTEST = 0.75
"""of colours on a white page; lighter ones are darkened"""
WIDTH = 4
DOT = (2.0, 8.0)
"""pixels, the smallest and the largest point"""
FARTHEST = 1e9
"""m, beyond which nothing is drawn: single numbers end somewhere"""
SHORTEST_AXIS = 0.02
"""of the longest side of the view, of an axis of a transform"""
BARB, SPREAD = 0.2, 0.08
"""of the length of an arrow: how long its head is, and how wide to either side"""
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""of red, green and blue"""

Kind = Literal["points", "lines", "arrows", "transforms", "strings"]


@dataclass(frozen=True)
class Stroke:
    """What is drawn of one kind in one colour."""

    kind: str
    color: str
    points: Array
    """(n, 3) m, world ENU; of lines with NaN where one ends"""
    size: float
    """pixels, of points"""
    texts: tuple[str, ...] = ()
    """(n,) of strings"""

    def in_space(self) -> Figure:
        """Return it as a trace in space."""
        if self.kind == "strings":
            return self._written("scatter3d", self.texts) | points(self.points)
        if self.kind == "points":
            look = {"size": self.size / 0.7, "color": self.color, "symbol": "circle"}
            return mark3("points", self.points, look)
        return line3(self.points, self.kind, color=self.color, width=WIDTH) | {"hoverinfo": "skip"}

    def from_above(self) -> Figure:
        """Return it as a trace of the view from above."""
        if self.kind == "strings":
            return self._written("scatter", tuple(map(escape, self.texts))) | flat(self.points)
        if self.kind == "points":
            return mark("points", self.points, {"size": self.size, "color": self.color, "symbol": "circle"})
        return line2(self.points, self.kind, color=self.color, width=WIDTH / 2)

    def _written(self, kind: str, texts: tuple[str, ...]) -> Figure:
        look = {"color": self.color, "size": 12}
        return {
            "type": kind,
            "mode": "text",
            "name": "strings",
            "text": list(texts),
            "textfont": look,
            "hoverinfo": "skip",
        }


def strokes(markers: Sequence[Marker], side: float) -> list[Stroke]:
    """Return what is drawn of markers, of one trace for every kind and colour.

    Args:
        markers: not too many, see `shown`
        side: m, the longest of the view
    """
    found: dict[tuple[str, str], list[tuple[Array, float, tuple[str, ...]]]] = {}
    for marker in markers:
        for kind, color, drawn, texts in pieces(marker, side):
            found.setdefault((kind, hexadecimal(color)), []).append((drawn, marker.size, texts))
    return [
        Stroke(
            kind,
            color,
            np.concatenate([drawn for drawn, _, _ in group]).clip(-FARTHEST, FARTHEST),
            float(np.clip(np.median([size for _, size, _ in group]) / 2, *DOT)),
            tuple(text for _, _, texts in group for text in texts),
        )
        for (kind, color), group in fewer(found).items()
    ]


def fewer(
    found: dict[tuple[str, str], list[tuple[Array, float, tuple[str, ...]]]],
) -> dict[tuple[str, str], list[tuple[Array, float, tuple[str, ...]]]]:
    """Return groups of at most `MOST_COLORS` colours: the rarest join the nearest of the others."""
    weight: dict[str, int] = {}
    for (_, color), group in found.items():
        weight[color] = weight.get(color, 0) + sum(len(drawn) for drawn, _, _ in group)
    kept = sorted(weight, key=lambda color: -weight[color])[:MOST_COLORS]
    shades = np.array([rgb(color) for color in kept])
    joined: dict[tuple[str, str], list[tuple[Array, float, tuple[str, ...]]]] = {}
    for (kind, color), group in found.items():
        nearest = color if color in kept else kept[int(np.abs(shades - rgb(color)).sum(axis=1).argmin())]
        joined.setdefault((kind, nearest), []).extend(group)
    return joined


def rgb(color: str) -> Array:
    """Return red, green and blue (3,) of a colour such as #ff0000, in 0 to 255."""
    return np.frombuffer(bytes.fromhex(color[1:]), dtype=np.uint8).astype(float)


def pieces(marker: Marker, side: float) -> Iterator[tuple[str, Color, Array, tuple[str, ...]]]:
    """Yield kind, colour, points (n, 3) m (lines with gaps) and texts of what a marker draws."""
    at = frames.enu_from_ned(marker.points)
    match marker.kind:
        case "points":
            yield "points", marker.color, at, ()
        case "lines":
            yield "lines", marker.color, gapped(at.reshape(-1, 2, 3)), ()
        case "arrows":
            yield "arrows", marker.color, gapped(arrows(at.reshape(-1, 2, 3))), ()
        case "transforms" if marker.orientations is not None:
            length = float(np.clip(CENTIMETRE * marker.size, SHORTEST_AXIS * side, side))
            ends = axes(at, marker.orientations, length).reshape(-1, 3, 2, 3)
            for number, color in enumerate(RED_GREEN_BLUE):
                yield "transforms", color, gapped(ends[:, number]), ()
    if marker.texts:
        yield "strings", marker.color, at, tuple(map(clean, marker.texts))


def arrows(pairs: Array) -> Array:
    """Return the strokes (n, 5, 3) m of arrows (n, 2, 3) m: the shaft, and the head as two barbs."""
    start, tip = pairs[:, 0], pairs[:, 1]
    way = tip - start
    length = np.linalg.norm(way, axis=1, keepdims=True)
    across = np.cross(way, (0.0, 0.0, 1.0))
    steep = np.linalg.norm(across, axis=1, keepdims=True) < 1e-6 * length
    across = np.where(steep, (1.0, 0.0, 0.0), across)
    across = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12) * SPREAD * length
    back = tip - BARB * way
    return np.stack([start, tip, back + across, tip, back - across], axis=1)


def gapped(lines: Array) -> Array:
    """Return lines (n, k, 3) as one (n (k + 1), 3), with NaN where one ends."""
    ends = np.full((len(lines), 1, 3), np.nan)
    return np.concatenate([lines, ends], axis=1).reshape(-1, 3)


def hexadecimal(color: Color) -> str:
    """Return a colour as #rrggbb, darkened where it could not be seen on a white page."""
    shade = np.clip(color[:3], 0.0, 1.0)
    bright = float(shade @ LUMINANCE)
    red, green, blue = (255 * shade * min(1.0, LIGHTEST / max(bright, 1e-9))).round().astype(int).tolist()
    return f"#{red:02x}{green:02x}{blue:02x}"


def shown(markers: Sequence[Marker]) -> list[Marker]:
    """Return the markers that are drawn: the latest, where they have too many points or texts."""
    kept: list[Marker] = []
    points = texts = 0
    for marker in reversed(markers):
        points, texts = points + len(marker.points), texts + len(marker.texts)
        if points > MOST_POINTS:
            break
        if texts <= MOST_TEXTS or not marker.texts:
            kept.append(marker)
    return kept[::-1]
