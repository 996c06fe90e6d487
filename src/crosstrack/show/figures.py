"""The report's figures as plotly.js takes them: plain mappings, numbers packed as base64."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL.Image import Transpose

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.show.extent import extent
from crosstrack.show.footprint import address, footprint
from crosstrack.show.panels import Panel, Role
from crosstrack.show.style import ALARM, FOOTPRINT, GRID, INK, OBSTACLE, ROUTE
from crosstrack.types import Array, Outcome

Figure = dict[str, Any]
FONT = {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif", "size": 13, "color": INK}
TITLES = {"x": "x, east (m)", "y": "y, north (m)", "z": "z (m)"}
DASHES: dict[Role, str] = {"flown": "solid", "planned": "dash", "asked": "dot"}


@dataclass(frozen=True)
class View:
    """A flight with what is drawn of it."""

    flight: Flight
    label: str
    color: str
    rows: NDArray[np.int_]
    """(k,) the samples that are drawn"""
    error: Array
    """(n,) m, cross-track error of every sample"""
    panels: list[Panel]


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


def space(views: Sequence[View], scene: Scene) -> Figure:
    """Return the view in space; the traces of the vehicles are added by the page's script."""
    obstacles = scene.solid()
    traces = [] if obstacles is None else [solid("obstacles", *obstacles)]
    traces.append(line3(scene.route, "route", color=ROUTE, width=2, dash="dash") | {"hoverinfo": "skip"})
    for view in views:
        name = name_of(view, views)
        flown = line3(view.flight.record.position[view.rows], name, color=view.color, width=7)
        flown |= {"hovertemplate": "%{x:.2f}, %{y:.2f}, %{z:.2f} m", "meta": "flown"}
        traces.append(flown | {"legendgroup": name, "showlegend": False})
    for view in views:  # in the legend: a path of many colours is black there
        name = name_of(view, views)
        traces.append(line3(np.full((1, 3), np.nan), name, color=view.color, width=5) | {"legendgroup": name})
    traces += [mark3(*each) for each in marks(views, scene)]
    box = extent([view.flight for view in views], scene)
    sides = box[1] - box[0]
    shares = 1.15 * sides / max(sides.max(), np.linalg.norm(sides) / 1.25)
    ticks = np.maximum(3, np.round(8 * sides / sides.max())).astype(int).tolist()
    axis = {"backgroundcolor": "#f8fafc", "gridcolor": GRID, "showbackground": True, "zeroline": False}
    layout = {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "scene": {
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", shares.tolist(), strict=True)),
            "camera": {"eye": {"x": -0.9, "y": -1.35, "z": 0.9}, "center": {"x": 0.0, "y": 0.0, "z": -0.08}},
            **{
                f"{name}axis": axis
                | {"title": {"text": TITLES[name]}, "range": box[:, index].tolist(), "nticks": ticks[index]}
                for index, name in enumerate("xyz")
            },
        },
        "legend": {"x": 0, "y": 1, "bgcolor": "rgba(255,255,255,0.75)"},
        "uirevision": "keep",
    }
    return {"data": traces, "layout": layout}


def name_of(view: View, views: Sequence[View]) -> str:
    """Return what the path of a flight is called: alone it needs no name of its own."""
    return view.label if len(views) > 1 else "flown"


def solid(name: str, vertices: Array, triangles: NDArray[np.integer]) -> Figure:
    """Return a mesh in space."""
    corners = {axis: packed(triangles[:, index]) for index, axis in enumerate("ijk")}
    return {
        "type": "mesh3d",
        "name": name,
        "color": OBSTACLE,
        "flatshading": True,
        # the limit applies to squared areas in units of the view: by default small faces are left without light
        "lighting": {"ambient": 0.7, "diffuse": 0.5, "specular": 0.05, "facenormalsepsilon": 0},
        "hoverinfo": "skip",
        "showlegend": True,
        **points(vertices),
        **corners,
    }


def plan_view(views: Sequence[View], scene: Scene) -> Figure:
    """Return the view from above, with equal axes."""
    box = extent([view.flight for view in views], scene)
    traces: list[Figure] = [backdrop(scene, box)] if scene.meshes else []
    curve = {"type": "scatter", "mode": "lines"}
    traces.append(curve | flat(scene.route) | {"name": "route", "line": {"color": ROUTE, "dash": "dash", "width": 1.5}})
    for view in views:
        line = {"color": view.color, "width": 2.5}
        traces.append(
            curve | flat(view.flight.record.position[view.rows]) | {"name": name_of(view, views), "line": line}
        )
    for trace in traces:
        trace["hoverinfo"] = "skip"
    if scene.meshes:
        square = {"size": 12, "color": FOOTPRINT, "symbol": "square"}
        traces.append(mark("obstacles", np.full((1, 3), np.nan), square))
    traces += [mark(*each) for each in marks(views, scene)]
    axis = {"gridcolor": GRID, "zeroline": False, "automargin": True, "ticks": "", "constrain": "domain"}
    layout = {
        "font": FONT,
        "margin": {"l": 50, "r": 12, "t": 30, "b": 44},
        "plot_bgcolor": "#fff",
        "xaxis": axis | {"title": {"text": "x, east (m)"}, "range": box[:, 0].tolist()},
        "yaxis": axis | {"title": {"text": "y, north (m)"}, "range": box[:, 1].tolist(), "scaleanchor": "x"},
        "legend": {"orientation": "h", "y": -0.16, "yanchor": "top", "x": 0},
    }
    return {"data": traces, "layout": layout}


def marks(views: Sequence[View], scene: Scene) -> list[tuple[str, Array, Figure]]:
    """Return name, points (n, 3) m and marker of start, goal, and where a flight ended that did not arrive."""
    lost = [view.flight for view in views if view.flight.outcome is not Outcome.ARRIVED]
    ends = [flight.record.position[np.isfinite(flight.record.position).all(axis=1)][-1] for flight in lost]
    white = {"size": 9, "color": "#fff", "line": {"color": INK, "width": 2}}
    found = [
        ("start", np.array([view.flight.record.position[0] for view in views]), white | {"symbol": "circle"}),
        ("goal", scene.route[-1:], white | {"symbol": "square"}),
    ]
    if ends:
        found.append(("ended here", np.array(ends), {"size": 11, "color": ALARM, "symbol": "x"}))
    return found


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


def backdrop(scene: Scene, box: Array) -> Figure:
    """Return the obstacles as an image over the grid of the view from above, its first row in the south."""
    image = footprint(scene, box)
    pixel = (box[1] - box[0])[:2] / image.size
    (x, y), (dx, dy) = (box[0, :2] + pixel / 2).tolist(), pixel.tolist()
    source = address(image.transpose(Transpose.FLIP_TOP_BOTTOM))
    return {
        "type": "image",
        "name": "footprint",
        "source": source,
        "x0": x,
        "y0": y,
        "dx": dx,
        "dy": dy,
        "zsmooth": "fast",
    }


def times(views: Sequence[View]) -> Figure:
    """Return all panels under one another over a common time axis."""
    titles = [panel.title for panel in max((view.panels for view in views), key=len)]
    layout: Figure = {
        "font": FONT,
        "margin": {"l": 56, "r": 16, "t": 30, "b": 44},
        "height": 80 + 165 * len(titles),
        "plot_bgcolor": "#fff",
        "hovermode": "x",
        "xaxis": {
            "title": {"text": "time (s)"},
            "gridcolor": GRID,
            "zeroline": False,
            "anchor": anchor(len(titles) - 1),
        },
        "annotations": [],
    }
    traces: list[Figure] = []
    for index, title in enumerate(titles):
        found = [(view, panel) for view in views for panel in view.panels if panel.title == title]
        furnish(layout, found[0][1], index, len(titles))
        for view, panel in found:
            traces += curves(view, panel, index, alone=len(views) == 1)
    return {"data": traces, "layout": layout}


def furnish(layout: Figure, panel: Panel, index: int, count: int) -> None:
    """Give a panel its place in the layout: axis, heading and legend."""
    top = 1 - index / count - 0.14 / count
    layout[anchor(index, "yaxis")] = {
        "domain": [top - 0.8 / count, top],
        "gridcolor": GRID,
        "zeroline": False,
        "rangemode": "tozero" if panel.from_zero else "normal",
        "autorangeoptions": {"include": panel.headroom()},
    }
    if (limits := panel.range()) is not None:
        layout[anchor(index, "yaxis")]["range"] = limits
    beside = {"y": top, "yanchor": "bottom"}
    heading = {"text": f"<b>{panel.title}</b> ({panel.unit})", "x": 0, "xanchor": "left", "showarrow": False}
    layout["annotations"].append(heading | beside | {"xref": "paper", "yref": "paper"})
    layout[anchor(index, "legend")] = {"orientation": "h", "x": 1, "xanchor": "right"} | beside


def anchor(index: int, word: str = "y") -> str:
    """Return plotly's name for the axis or legend of a panel: y, y2, y3, ..."""
    return word if index == 0 else f"{word}{index + 1}"


def curves(view: View, panel: Panel, index: int, alone: bool) -> list[Figure]:
    """Return the lines of one panel; beside other flights only the first series, under the flight's name."""
    time = packed(view.flight.record.time[view.rows])
    shown = panel.series if alone else panel.series[:1]
    traces = []
    for number, series in enumerate(shown):
        color = panel.colors[number] if alone else view.color
        traces.append(
            {
                "type": "scatter",
                "mode": "lines",
                "x": time,
                "y": packed(series.values[view.rows]),
                "yaxis": anchor(index),
                "legend": anchor(index, "legend"),
                "name": series.label if alone else view.label,
                "showlegend": not alone or len(shown) > 1,
                "line": {"color": color, "width": 1.6, "dash": DASHES[series.role] if alone else "solid"},
                "hovertemplate": f"%{{y:.3f}} {escape(panel.unit)}",
            }
        )
    return traces
