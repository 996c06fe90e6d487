"""Layouts of the pages' figures: axes, legends, panels under one another."""

from collections.abc import Sequence
from html import escape

import numpy as np

from crosstrack.show.panels import Panel, Role
from crosstrack.show.style import GRID, INK
from crosstrack.show.traces import Figure, packed
from crosstrack.types import Array

FONT = {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif", "size": 13, "color": INK}
TITLES = {"x": "x, east (m)", "y": "y, north (m)", "z": "z (m)"}
DASHES: dict[Role, str] = {"flown": "solid", "planned": "dash", "asked": "dot", "limit": "dashdot"}


EYE, MIDDLE = np.array([-0.9, -1.35, 0.9]), np.array([0.0, 0.0, -0.08])
"""where the view in space is taken from and what is in its middle, in its units"""
ASIDE = np.array([-0.17, 0.11, 0.0])
"""to the left, by which the viewer moves to leave room for a long legend"""


def space_layout(box: Array, aside: bool = False) -> Figure:
    """Return the layout of the view in space of a box (2, 3) m, a metre as long along each axis.

    Args:
        box: lowest and highest corner
        aside: whether there is a long legend to the left
    """
    eye, middle = (1.15 * EYE + ASIDE, MIDDLE + ASIDE) if aside else (EYE, MIDDLE)
    sides = box[1] - box[0]
    shares = 1.15 * sides / max(sides.max(), np.linalg.norm(sides) / 1.25)
    ticks = np.maximum(3, np.round(8 * sides / sides.max())).astype(int).tolist()
    axis = {"backgroundcolor": "#f8fafc", "gridcolor": GRID, "showbackground": True, "zeroline": False}
    return {
        "font": FONT,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "scene": {
            "aspectmode": "manual",
            "aspectratio": dict(zip("xyz", shares.tolist(), strict=True)),
            "camera": {
                "eye": dict(zip("xyz", eye.tolist(), strict=True)),
                "center": dict(zip("xyz", middle.tolist(), strict=True)),
            },
            **{
                f"{name}axis": axis
                | {"title": {"text": TITLES[name]}, "range": box[:, index].tolist(), "nticks": ticks[index]}
                for index, name in enumerate("xyz")
            },
        },
        "legend": {"x": 0, "y": 1, "bgcolor": "rgba(255,255,255,0.75)"},
        "uirevision": "keep",
    }


def plan_layout(box: Array) -> Figure:
    """Return the layout of the view from above of a box (2, 3) m, with equal axes."""
    axis = {"gridcolor": GRID, "zeroline": False, "automargin": True, "ticks": "", "constrain": "domain"}
    return {
        "font": FONT,
        "margin": {"l": 50, "r": 12, "t": 30, "b": 44},
        "plot_bgcolor": "#fff",
        "xaxis": axis | {"title": {"text": "x, east (m)"}, "range": box[:, 0].tolist()},
        "yaxis": axis | {"title": {"text": "y, north (m)"}, "range": box[:, 1].tolist(), "scaleanchor": "x"},
        "legend": {"orientation": "h", "y": -0.16, "yanchor": "top", "x": 0},
    }


def times_layout(panels: Sequence[Panel]) -> Figure:
    """Return the layout of panels under one another over a common time axis."""
    layout: Figure = {
        "font": FONT,
        "margin": {"l": 56, "r": 16, "t": 30, "b": 44},
        "height": 80 + 165 * len(panels),
        "plot_bgcolor": "#fff",
        "hovermode": "x",
        "xaxis": {
            "title": {"text": "time (s)"},
            "gridcolor": GRID,
            "zeroline": False,
            "anchor": anchor(len(panels) - 1),
        },
        "annotations": [],
    }
    for index, panel in enumerate(panels):
        furnish(layout, panel, index, len(panels))
    return layout


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
    if panel.names:
        ticks = {"tickvals": list(range(1, len(panel.names) + 1)), "ticktext": list(panel.names)}
        layout[anchor(index, "yaxis")] |= ticks | {"automargin": True}
    beside = {"y": top, "yanchor": "bottom"}
    heading = {
        "text": panel.heading.replace(panel.title, f"<b>{panel.title}</b>", 1),
        "x": 0,
        "xanchor": "left",
        "showarrow": False,
    }
    layout["annotations"].append(heading | beside | {"xref": "paper", "yref": "paper"})
    layout[anchor(index, "legend")] = {"orientation": "h", "x": 1, "xanchor": "right"} | beside


def anchor(index: int, word: str = "y") -> str:
    """Return plotly's name for the axis or legend of a panel: y, y2, y3, ..."""
    return word if index == 0 else f"{word}{index + 1}"


def curve(time: Array, values: Array, index: int, name: str, unit: str, **look: object) -> Figure:
    """Return a line of the panel at an index: values (n,) over times (n,) s."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": packed(time),
        "y": packed(values),
        "yaxis": anchor(index),
        "legend": anchor(index, "legend"),
        "name": name,
        "hovertemplate": f"%{{y:.3f}} {escape(unit)}" if unit else name,
        **look,
    }
