"""What is drawn of a planned trajectory: in space, from above, and its derivatives over time."""

from collections.abc import Iterator

import numpy as np

from crosstrack.flight.scene import Scene, scene
from crosstrack.mission.certified import Certified
from crosstrack.show.extent import around
from crosstrack.show.layouts import DASHES, curve, plan_layout, space_layout, times_layout
from crosstrack.show.panels import Panel, Series
from crosstrack.show.style import ALARM, FOOTPRINT, INK, PALETTE, ROUTE, SCALE
from crosstrack.show.traces import Figure, backdrop, line2, line3, mark, mark3, solid
from crosstrack.show.tube import band, tube
from crosstrack.types import Array

DRAWN = 3000
"""instants at which a trajectory is drawn"""
NAMES = {1: "speed", 2: "acceleration", 3: "jerk", 4: "snap"}
UNITS = {1: "m/s", 2: "m/s²", 3: "m/s³", 4: "m/s⁴"}


def figures(found: Certified) -> dict[str, Figure]:
    """Return all that the page's script draws."""
    drawn = scene(found.plan)
    instants = np.linspace(0.0, found.trajectory.duration, DRAWN)
    return {
        "space": space(found, drawn, instants),
        "plan": plan_view(found, drawn, instants),
        "times": times(found, instants),
    }


def space(found: Certified, drawn: Scene, instants: Array) -> Figure:
    """Return the view in space: corridor, route, and the trajectory coloured by its speed."""
    path = found.trajectory(instants)
    obstacles = drawn.solid()
    traces = [] if obstacles is None else [solid("obstacles", *obstacles)]
    traces.append(line3(drawn.route, "route", color=ROUTE, width=2, dash="dash") | {"hoverinfo": "skip"})
    speed = np.linalg.norm(found.trajectory(instants, 1), axis=1)
    bar = {"title": {"text": "speed (m/s)", "side": "right"}, "thickness": 12, "len": 0.7, "x": 1}
    scale = {"cmin": 0, "cmax": float(speed.max()), "colorscale": [list(step) for step in SCALE], "colorbar": bar}
    flown = line3(path, "trajectory", color=speed.round(3).tolist(), width=6, showscale=True, **scale)
    traces.append(flown | {"hovertemplate": "%{x:.2f}, %{y:.2f}, %{z:.2f} m", "showlegend": False})
    traces.append(line3(np.full((1, 3), np.nan), "trajectory", color=PALETTE[0], width=5))
    if found.allowed is not None:
        traces.append(tube(found.plan.route.points, found.allowed))
    traces += [mark3(*each) for each in marks(found)]
    return {"data": traces, "layout": space_layout(around([path], drawn))}


def plan_view(found: Certified, drawn: Scene, instants: Array) -> Figure:
    """Return the view from above, with equal axes."""
    path = found.trajectory(instants)
    box = around([path], drawn)
    traces = [backdrop(drawn, box)] if drawn.meshes else []
    if found.allowed is not None:
        traces.append(band(found.plan.route.points, found.allowed))
    traces.append(line2(drawn.route, "route", color=ROUTE, dash="dash", width=1.5))
    traces.append(line2(path, "trajectory", color=PALETTE[0], width=2.5))
    if drawn.meshes:
        square = {"size": 12, "color": FOOTPRINT, "symbol": "square"}
        traces.append(mark("obstacles", np.full((1, 3), np.nan), square))
    traces += [mark(*each) for each in marks(found)]
    return {"data": traces, "layout": plan_layout(box)}


def marks(found: Certified) -> Iterator[tuple[str, Array, Figure]]:
    """Yield name, points (n, 3) m and marker of start, goal, and the waypoints between."""
    white = {"size": 9, "color": "#fff", "line": {"color": INK, "width": 2}}
    waypoints = found.task.waypoints
    if len(waypoints) > 2:
        yield "waypoints", waypoints[1:-1], {"size": 6, "color": ROUTE, "symbol": "circle"}
    yield "start", waypoints[:1], white | {"symbol": "circle"}
    yield "goal", waypoints[-1:], white | {"symbol": "square"}


def times(found: Certified, instants: Array) -> Figure:
    """Return the derivatives, the deviation and the clearance under one another over a common time axis."""
    shown = list(panels(found, instants))
    traces = [
        curve(
            instants,
            series.values,
            index,
            series.label,
            panel.unit,
            line={"color": color, "width": 1.6, "dash": DASHES[series.role]},
            showlegend=len(panel.series) > 1,
        )
        for index, panel in enumerate(shown)
        for color, series in zip(panel.colors, panel.series, strict=True)
    ]
    return {"data": traces, "layout": times_layout(shown)}


def panels(found: Certified, instants: Array) -> Iterator[Panel]:
    """Yield a panel for each quantity, with the limits that there are."""
    task, envelope = found.task, found.task.envelope
    limits = {1: (task.speed, envelope.speed_vertical), 2: (envelope.acceleration, envelope.acceleration_vertical)}
    for order in NAMES:
        yield derivative(found, instants, order, limits.get(order))
    path = found.trajectory(instants)
    deviation = [Series("from the legs", found.plan.route.trace(path)[1])]
    if found.allowed is not None:
        deviation.append(level("allowed", found.allowed))
    yield Panel("Deviation from the route", "m", tuple(deviation))
    clearance = task.world.distance(path)
    if np.isfinite(clearance).any():
        series = (Series("of the trajectory", clearance), level("radius of the vehicle", task.radius))
        yield Panel("Clearance", "m", series)


def derivative(found: Certified, instants: Array, order: int, limits: tuple[float, float] | None) -> Panel:
    """Return the size of a derivative, and of its vertical part where that has a limit of its own."""
    vectors = found.trajectory(instants, order)
    series = [Series("all", np.linalg.norm(vectors, axis=1))]
    if limits is not None:
        series.append(Series("vertical", np.abs(vectors[:, 2]), "planned"))
        series += [level("limit", limits[0]), level("vertical limit", limits[1], PALETTE[1])]
    return Panel(NAMES[order].capitalize(), UNITS[order], tuple(series))


def level(label: str, value: float, color: str = ALARM) -> Series:
    """Return a limit as a line."""
    return Series(label, np.full(DRAWN, value), "limit", color)
