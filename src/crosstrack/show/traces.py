"""Traces of the pages' figures as plotly.js takes them: plain mappings, numbers packed as base64."""

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL.Image import Transpose

from crosstrack.flight.scene import Scene
from crosstrack.show.footprint import address, footprint
from crosstrack.show.style import FOOTPRINT, INK, OBSTACLE
from crosstrack.types import Array

Figure = dict[str, Any]


def packed(values: NDArray[Any]) -> Figure:
    """Pack numbers as plotly.js unpacks them: float32 or int32 in base64."""
    kind = "i4" if np.issubdtype(values.dtype, np.integer) else "f4"
    data = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
    return {"dtype": kind, "bdata": base64.b64encode(data).decode()}


def points(positions: Array) -> Figure:
    """Return positions (n, 3) as the x, y and z of a trace."""
    return {axis: packed(positions[:, index]) for index, axis in enumerate("xyz")}


def flat(positions: Array) -> Figure:
    """Return positions (n, 3) as the x and y of a trace."""
    return {axis: packed(positions[:, index]) for index, axis in enumerate("xy")}


def line3(positions: Array, name: str, **line: Any) -> Figure:
    """Return a curve in space."""
    return {"type": "scatter3d", "mode": "lines", "name": name, "line": line, **points(positions)}


def line2(positions: Array, name: str, **line: Any) -> Figure:
    """Return a curve of the view from above."""
    return {"type": "scatter", "mode": "lines", "name": name, "line": line, "hoverinfo": "skip", **flat(positions)}


def solid(name: str, vertices: Array, triangles: NDArray[np.integer], color: str = OBSTACLE) -> Figure:
    """Return a mesh in space."""
    corners = {axis: packed(triangles[:, index]) for index, axis in enumerate("ijk")}
    return {
        "type": "mesh3d",
        "name": name,
        "color": color,
        "flatshading": True,
        # the limit applies to squared areas in units of the view: by default small faces are left without light
        "lighting": {"ambient": 0.7, "diffuse": 0.5, "specular": 0.05, "facenormalsepsilon": 0},
        "hoverinfo": "skip",
        "showlegend": True,
        **points(vertices),
        **corners,
    }


def mark(name: str, positions: Array, marker: Figure) -> Figure:
    """Return positions (n, 3) as points of the view from above."""
    return flat(positions) | {
        "type": "scatter",
        "mode": "markers",
        "name": name,
        "marker": marker,
        "hovertemplate": f"{name}: %{{x:.2f}}, %{{y:.2f}} m<extra></extra>",
    }


def mark3(name: str, positions: Array, marker: Figure) -> Figure:
    """Return positions (n, 3) as points in space."""
    outlined = {"color": INK, "symbol": f"{marker['symbol']}-open"} if "line" in marker else {}
    return points(positions) | {
        "type": "scatter3d",
        "mode": "markers",
        "name": name,
        "marker": {"size": 0.7 * marker["size"], "color": marker["color"], "symbol": marker["symbol"]} | outlined,
        "hovertemplate": f"{name}: %{{x:.2f}}, %{{y:.2f}}, %{{z:.2f}} m<extra></extra>",
    }


def cloud3(positions: Array, name: str, color: str) -> Figure:
    """Return many positions (n, 3) as small dots in space."""
    look = {"size": 1.2, "color": color, "opacity": 0.7}
    return {
        "type": "scatter3d",
        "mode": "markers",
        "name": name,
        "marker": look,
        "hoverinfo": "skip",
        **points(positions),
    }


def cloud2(positions: Array, name: str, color: str) -> Figure:
    """Return many positions (n, 3) as small dots of the view from above."""
    look = {"size": 1.6, "color": color, "opacity": 0.6}
    return {"type": "scatter", "mode": "markers", "name": name, "marker": look, "hoverinfo": "skip", **flat(positions)}


def patch(outline: Array, name: str, color: str) -> Figure:
    """Return a closed outline (n, 2) as an area of the view from above."""
    return {
        "type": "scatter",
        "mode": "lines",
        "name": name,
        "fill": "toself",
        "fillcolor": f"{color}99",
        "line": {"color": color, "width": 1},
        "hoverinfo": "skip",
        **flat(outline),
    }


def backdrop(scene: Scene, box: Array, color: str = FOOTPRINT) -> Figure:
    """Return the obstacles as an image over the grid of the view from above, its first row in the south."""
    image = footprint(scene, box, color)
    pixel = (box[1] - box[0])[:2] / image.size
    (x, y), (dx, dy) = (box[0, :2] + pixel / 2).tolist(), pixel.tolist()
    source = address(image.transpose(Transpose.FLIP_TOP_BOTTOM))
    return {
        "type": "image",
        "name": "footprint",
        "hoverinfo": "skip",
        "source": source,
        "x0": x,
        "y0": y,
        "dx": dx,
        "dy": dy,
        "zsmooth": "fast",
    }
