"""The report's figures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.show.avoiding import (
    SEEN_FROM_ABOVE,
    SEEN_IN_SPACE,
    SIGHTED,
    Intervention,
    interventions,
    replanned,
    seen,
)
from crosstrack.show.extent import extent
from crosstrack.show.layouts import DASHES, curve, plan_layout, space_layout, times_layout
from crosstrack.show.panels import Panel
from crosstrack.show.stage import NOWHERE, groups
from crosstrack.show.style import ALARM, INK, MOVING, PLANNED, ROUTE, SEEN
from crosstrack.show.traces import Figure, backdrop, cloud2, cloud3, line2, line3, mark, mark3, patch, solid
from crosstrack.show.traffic import MOVERS, tracks
from crosstrack.types import Array, Outcome

LEGEND_BESIDE = 8
"""entries, from which on the legend has room of its own beside the view in space"""


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
    box = extent([view.flight for view in views], scene)
    traces = [solid(group.name, *group.mesh, group.color) for group in groups(scene)]
    traces += [
        line3(line, name, **look) | {"hoverinfo": "skip"} | more for name, line, look, more in courses(views, scene)
    ]
    if len(points := seen_by(views, box, SEEN_IN_SPACE)):
        traces.append(cloud3(points, SIGHTED, SEEN) | {"legendgroup": SIGHTED, "showlegend": False})
        traces.append(
            mark3(SIGHTED, NOWHERE, {"size": 6, "color": SEEN, "symbol": "circle"}) | {"legendgroup": SIGHTED}
        )
    for each, band in stepped_in(views, guards=False):
        look = line3(band, f"{each.name} stepped in", color=each.color, width=18)
        traces.append(look | {"opacity": 0.3, "hoverinfo": "skip"})
    for view in views:
        name = name_of(view, views)
        flown = line3(view.flight.record.position[view.rows], name, color=view.color, width=7)
        flown |= {"hovertemplate": "%{x:.2f}, %{y:.2f}, %{z:.2f} m", "meta": "flown"}
        traces.append(flown | {"legendgroup": name, "showlegend": False})
    for view in views:  # in the legend: a path of many colours is black there
        name = name_of(view, views)
        traces.append(line3(NOWHERE, name, color=view.color, width=5) | {"legendgroup": name})
    traces += [mark3(*each) for each in (*guarded(views), *marks(views))]
    for track in tracks([view.flight for view in views], box):
        way = line3(track.line, MOVERS, color=MOVING, width=3, dash="dot")
        traces.append(way | {"legendgroup": MOVERS, "showlegend": False, "hoverinfo": "skip"})
        moving = solid(MOVERS, *track.mesh, MOVING)
        traces.append(moving | {"legendgroup": MOVERS, "showlegend": track.first, "meta": "mover"})
    entries = sum(trace.get("showlegend", True) for trace in traces)
    return {"data": traces, "layout": space_layout(box, aside=entries > LEGEND_BESIDE)}


def courses(views: Sequence[View], scene: Scene) -> Iterator[tuple[str, Array, Figure, Figure]]:
    """Yield name, line (n, 3) m, look and legend of what was to be flown: the route, the plan, and later plans."""
    yield "route", scene.route, {"color": ROUTE, "width": 2, "dash": "dash"}, {}
    first = views[0].flight.plan
    others = [
        view.flight.plan for view in views[1:] if not np.array_equal(view.flight.plan.route.points, first.route.points)
    ]
    for plan in others:
        yield "route", plan.route.points, {"color": ROUTE, "width": 2, "dash": "dash"}, {"showlegend": False}
    if first.course.trajectory is not None:
        yield "trajectory", scene.course, {"color": PLANNED, "width": 3}, {}
    again = np.concatenate([replanned(view.flight) for view in views])
    if len(again):
        yield "planned again", again, {"color": PLANNED, "width": 2, "dash": "dot"}, {}


def seen_by(views: Sequence[View], box: Array, most: int) -> Array:
    """Return what the sensors of all vehicles saw within a box (2, 3) m, (n, 3) m, about `most` points."""
    return np.concatenate([seen(view.flight, box, most // len(views)) for view in views])


def stepped_in(views: Sequence[View], guards: bool) -> Iterator[tuple[Intervention, Array]]:
    """Yield the avoiders, those that guard or the others, and the paths of all vehicles where they stepped in."""
    found: dict[str, tuple[Intervention, list[Array]]] = {}
    for view in views:
        for each in interventions(view.flight):
            if each.guards is guards and each.rows[view.rows].any():
                band = each.band(view.flight.record.position)[view.rows]
                found.setdefault(each.name, (each, []))[1].extend((band, NOWHERE))
    for each, bands in found.values():
        yield each, np.concatenate(bands)


def guarded(views: Sequence[View]) -> Iterator[tuple[str, Array, Figure]]:
    """Yield name, points (n, 3) m and marker of where each avoider that guards stepped in."""
    for each, band in stepped_in(views, guards=True):
        known = np.isfinite(band).all(axis=1)
        yield f"{each.name} stepped in", band[known], {"size": 6, "color": each.color, "symbol": "circle"}


def name_of(view: View, views: Sequence[View]) -> str:
    """Return what the path of a flight is called: alone it needs no name of its own."""
    return view.label if len(views) > 1 else "flown"


def plan_view(views: Sequence[View], scene: Scene) -> Figure:
    """Return the view from above, with equal axes."""
    box = extent([view.flight for view in views], scene)
    standing = list(groups(scene))
    traces = [backdrop(group.scene, box, group.footprint) for group in standing]
    for name, line, look, more in courses(views, scene):
        traces.append(line2(line, name, **look | {"width": 1.5}) | more)
    if len(points := seen_by(views, box, SEEN_FROM_ABOVE)):
        traces.append(cloud2(points, SIGHTED, SEEN) | {"legendgroup": SIGHTED, "showlegend": False})
        traces.append(mark(SIGHTED, NOWHERE, {"size": 6, "color": SEEN, "symbol": "circle"}) | {"legendgroup": SIGHTED})
    for each, band in stepped_in(views, guards=False):
        traces.append(line2(band, f"{each.name} stepped in", color=each.color, width=10) | {"opacity": 0.3})
    traces += [
        line2(view.flight.record.position[view.rows], name_of(view, views), color=view.color, width=2.5)
        for view in views
    ]
    for group in standing:
        traces.append(mark(group.name, NOWHERE, {"size": 12, "color": group.footprint, "symbol": "square"}))
    traces += [mark(*each) for each in (*guarded(views), *marks(views))]
    for track in tracks([view.flight for view in views], box):
        way = line2(track.line, MOVERS, color=MOVING, width=1.5, dash="dot")
        traces.append(way | {"legendgroup": MOVERS, "showlegend": False})
        moving = patch(track.outline(track.mesh.vertices), MOVERS, MOVING)
        traces.append(moving | {"legendgroup": MOVERS, "showlegend": track.first, "meta": "mover"})
    return {"data": traces, "layout": plan_layout(box)}


def marks(views: Sequence[View]) -> list[tuple[str, Array, Figure]]:
    """Return name, points (n, 3) m and marker of start, goal, and where a flight ended that did not arrive."""
    lost = [view.flight for view in views if view.flight.outcome is not Outcome.ARRIVED]
    ends = [flight.record.position[np.isfinite(flight.record.position).all(axis=1)][-1] for flight in lost]
    white = {"size": 9, "color": "#fff", "line": {"color": INK, "width": 2}}
    found = [
        ("start", np.array([view.flight.record.position[0] for view in views]), white | {"symbol": "circle"}),
        ("goal", np.array([view.flight.plan.route.points[-1] for view in views]), white | {"symbol": "square"}),
    ]
    if ends:
        found.append(("ended here", np.array(ends), {"size": 11, "color": ALARM, "symbol": "x"}))
    return found


def times(views: Sequence[View]) -> Figure:
    """Return all panels under one another over a common time axis."""
    common = [panel for panel in max((view.panels for view in views), key=len) if len(views) == 1 or not panel.names]
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
            showlegend=not alone or (len(shown) > 1 and not panel.names),
            line={
                "color": panel.colors[number] if alone else view.color,
                "width": 6 if panel.names else 1.6,
                "dash": DASHES[series.role] if alone else "solid",
            },
        )
        for number, series in enumerate(shown)
    ]
