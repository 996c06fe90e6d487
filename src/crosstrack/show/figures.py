"""The report's figures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.show.extent import extent
from crosstrack.show.layouts import DASHES, curve, plan_layout, space_layout, times_layout
from crosstrack.show.panels import Panel
from crosstrack.show.style import ALARM, FOOTPRINT, INK, PLANNED, ROUTE
from crosstrack.show.traces import Figure, backdrop, line2, line3, mark, mark3, solid
from crosstrack.types import Array, Outcome


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


def space(views: Sequence[View], scene: Scene) -> Figure:
    """Return the view in space; the traces of the vehicles are added by the page's script."""
    obstacles = scene.solid()
    traces = [] if obstacles is None else [solid("obstacles", *obstacles)]
    traces.append(line3(scene.route, "route", color=ROUTE, width=2, dash="dash") | {"hoverinfo": "skip"})
    if views[0].flight.plan.course.trajectory is not None:
        traces.append(line3(scene.course, "trajectory", color=PLANNED, width=3) | {"hoverinfo": "skip"})
    for view in views:
        name = name_of(view, views)
        flown = line3(view.flight.record.position[view.rows], name, color=view.color, width=7)
        flown |= {"hovertemplate": "%{x:.2f}, %{y:.2f}, %{z:.2f} m", "meta": "flown"}
        traces.append(flown | {"legendgroup": name, "showlegend": False})
    for view in views:  # in the legend: a path of many colours is black there
        name = name_of(view, views)
        traces.append(line3(np.full((1, 3), np.nan), name, color=view.color, width=5) | {"legendgroup": name})
    traces += [mark3(*each) for each in marks(views, scene)]
    return {"data": traces, "layout": space_layout(extent([view.flight for view in views], scene))}


def name_of(view: View, views: Sequence[View]) -> str:
    """Return what the path of a flight is called: alone it needs no name of its own."""
    return view.label if len(views) > 1 else "flown"


def plan_view(views: Sequence[View], scene: Scene) -> Figure:
    """Return the view from above, with equal axes."""
    box = extent([view.flight for view in views], scene)
    traces: list[Figure] = [backdrop(scene, box)] if scene.meshes else []
    traces.append(line2(scene.route, "route", color=ROUTE, dash="dash", width=1.5))
    if views[0].flight.plan.course.trajectory is not None:
        traces.append(line2(scene.course, "trajectory", color=PLANNED, width=1.5))
    traces += [
        line2(view.flight.record.position[view.rows], name_of(view, views), color=view.color, width=2.5)
        for view in views
    ]
    if scene.meshes:
        square = {"size": 12, "color": FOOTPRINT, "symbol": "square"}
        traces.append(mark("obstacles", np.full((1, 3), np.nan), square))
    traces += [mark(*each) for each in marks(views, scene)]
    return {"data": traces, "layout": plan_layout(box)}


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


def times(views: Sequence[View]) -> Figure:
    """Return all panels under one another over a common time axis."""
    common = max((view.panels for view in views), key=len)
    traces: list[Figure] = []
    firsts = []
    for index, title in enumerate(panel.title for panel in common):
        found = [(view, panel) for view in views for panel in view.panels if panel.title == title]
        firsts.append(found[0][1])
        for view, panel in found:
            traces += curves(view, panel, index, alone=len(views) == 1)
    return {"data": traces, "layout": times_layout(firsts)}


def curves(view: View, panel: Panel, index: int, alone: bool) -> list[Figure]:
    """Return the lines of one panel; beside other flights only the first series, under the flight's name."""
    time = view.flight.record.time[view.rows]
    shown = panel.series if alone else panel.series[:1]
    return [
        curve(
            time,
            series.values[view.rows],
            index,
            series.label if alone else view.label,
            panel.unit,
            showlegend=not alone or len(shown) > 1,
            line={
                "color": panel.colors[number] if alone else view.color,
                "width": 1.6,
                "dash": DASHES[series.role] if alone else "solid",
            },
        )
        for number, series in enumerate(shown)
    ]
