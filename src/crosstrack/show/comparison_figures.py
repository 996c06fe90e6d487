"""The figures of a comparison, for plotly.js."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.scene import Scene
from crosstrack.show.comparison_flights import Flown, Group, Look
from crosstrack.show.extent import around
from crosstrack.show.layouts import FONT, curve, plan_layout, times_layout
from crosstrack.show.panels import Panel, Series
from crosstrack.show.style import GRID, INK, ROUTE
from crosstrack.show.traces import Figure, flat, line2, mark, packed

BINS = 14
"""of speed"""
LEAST = 3
"""samples of a bin that counts"""
WIDE = 20.0
"""ratio of the largest error to the least from which an axis is logarithmic"""
WRAP = 24
"""letters of a tracker's name in a line"""
Looks = Mapping[str, Look]


def plan_view(group: Group, looks: Looks, rows: int) -> Figure:
    """Return the median flights over the route from above, with equal axes, and where flights ended that failed."""
    drawn = medians(group, looks)
    route = group.flights[0].route
    lost = [flight for flight in group.flights if not flight.arrived]
    box = around([*(flight.position for _, flight in drawn), *(flight.end[None] for flight in lost)], still(route))
    traces = [line2(route, "route", color=ROUTE, dash="dash", width=1.5)]
    for look, flight in drawn:
        line = line2(flight.position[thinned(flight, rows)], escape(look.name), **stroke(look, 2.2))
        traces.append(line | {"meta": look.index, "showlegend": False})
    traces += [ends(looks[name], lost) for name in dict.fromkeys(flight.tracker for flight in lost)]
    white = {"size": 9, "color": "#fff", "line": {"color": INK, "width": 2}}
    traces += [
        mark("start", drawn[0][1].position[:1], white | {"symbol": "circle"}),
        mark("goal", route[-1:], white | {"symbol": "square"}),
    ]
    if lost:
        traces.append(mark("ended here", np.full((1, 3), np.nan), {"size": 10, "color": INK, "symbol": "x"}))
    across, along = (box[1] - box[0])[:2]
    height = 130 + 480 * min(1.0, max(0.25, float(along / across)))
    layout = plan_layout(box) | {"height": round(height)}
    layout["margin"] |= {"b": 84}
    layout["legend"] = {"orientation": "h", "yref": "container", "y": 0, "yanchor": "bottom", "x": 0}
    return {"data": traces, "layout": layout}


def ends(look: Look, lost: Sequence[Flown]) -> Figure:
    """Return where the flights of a tracker ended that did not arrive."""
    mine = [flight for flight in lost if flight.tracker == look.name]
    words = [f"{escape(look.name)}, {escape(flight.case)}:<br>{sentence(flight)}" for flight in mine]
    return flat(np.array([flight.end for flight in mine])) | {
        "type": "scatter",
        "mode": "markers",
        "name": escape(look.name),
        "meta": look.index,
        "showlegend": False,
        "marker": {"size": 10, "color": look.color, "symbol": "x", "line": {"color": "#fff", "width": 1}},
        "text": words,
        "hovertemplate": "%{text}<extra></extra>",
    }


def sentence(flight: Flown) -> str:
    """Return how and when a flight ended, as a text for a figure."""
    return f"{escape(flight.summary['outcome_text'])} ({flight.summary['flight_time_s']:.1f} s)"


def times(group: Group, looks: Looks, rows: int) -> Figure:
    """Return error, height and speed of the median flights over time."""
    drawn = [(look, flight, thinned(flight, rows)) for look, flight in medians(group, looks)]
    shown: list[tuple[str, str, float, Any]] = [
        ("Cross-track error", "m", 0.0, lambda flight: flight.cross_track),
        ("Distance to the trajectory's point", "m", 0.0, lambda flight: flight.tracking),
        ("Speed", "m/s", 0.0, lambda flight: flight.speed),
        ("Height", "m", 1.0, lambda flight: flight.position[:, 2]),
    ]
    panels, traces = [], []
    for title, unit, span, values in shown:
        having = [(look, flight, at) for look, flight, at in drawn if values(flight) is not None]
        if not having:
            continue
        series = tuple(Series(look.name, values(flight)) for look, flight, _ in having)
        panels.append(Panel(title, unit, series, from_zero=title != "Height", span=span))
        for look, flight, at in having:
            name, line = escape(look.name), {"line": stroke(look, 1.6), "meta": look.index, "showlegend": False}
            traces.append(curve(flight.time[at], values(flight)[at], len(panels) - 1, name, unit, **line))
    return {"data": traces, "layout": times_layout(panels) | {"hovermode": "closest"}}


def speeds(group: Group, looks: Looks) -> Figure:
    """Return the error against the speed flown, RMS over all flights of a tracker in bins of speed."""
    top = max((float(np.nanmax(flight.speed, initial=0.0)) for flight in group.flights), default=0.0)
    traces = []
    for look in present(group, looks):
        speed, error = binned(group.of(look.name), np.linspace(0.0, max(top, 0.1), BINS + 1))
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "name": escape(look.name),
                "meta": look.index,
                "showlegend": False,
                "x": packed(speed),
                "y": packed(error),
                "line": stroke(look, 1.6),
                "marker": {"size": 6, "color": look.color},
                "hovertemplate": f"{escape(look.name)}<br>at %{{x:.2f}} m/s: %{{y:.3f}} m<extra></extra>",
            }
        )
    layout = axes({"title": {"text": "speed (m/s)"}, "rangemode": "tozero"}, {"rangemode": "tozero"})
    layout["yaxis"]["title"] = {"text": "cross-track error, RMS (m)"}
    return {"data": traces, "layout": layout}


def binned(flights: Sequence[Flown], edges: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return mean speed (k,) m/s and RMS cross-track error (k,) m of the samples in every bin that holds some."""
    speed = np.concatenate([flight.speed for flight in flights])
    error = np.concatenate([flight.cross_track for flight in flights])
    known = np.isfinite(speed) & np.isfinite(error)
    speed, error = speed[known], error[known]
    bins = np.clip(np.searchsorted(edges, speed, side="right") - 1, 0, len(edges) - 2)
    count = np.bincount(bins, minlength=len(edges) - 1)
    held = count >= LEAST
    totals = [np.bincount(bins, weights, len(edges) - 1)[held] / count[held] for weights in (speed, error**2)]
    return totals[0], np.sqrt(totals[1])


def boxes(flights: Sequence[Flown], looks: Looks, order: Sequence[str], metric: str, title: str) -> Figure | None:
    """Return the spread of a metric over the flights of a mission that arrived, a box and its points per tracker.

    Args:
        flights: of one mission, in all winds and from all seeds
        looks: of the trackers
        order: of the trackers, from the top
        metric: of the summary
        title: of the axis

    Returns:
        None where no flight that arrived has a value.
    """
    traces = []
    values: list[float] = []
    for name in order:
        mine = [flight for flight in flights if flight.tracker == name]
        shown = [flight for flight in mine if flight.arrived and flight.summary[metric] is not None]
        if mine:
            values += [flight.summary[metric] for flight in shown]
            traces.append(box(looks[name], shown, len(mine), metric))
    if not values:
        return None
    log = min(values) > 0 and max(values) > WIDE * min(values)
    across = {"title": {"text": title}, **({"type": "log", "dtick": "D2"} if log else {"rangemode": "tozero"})}
    layout = axes(across, {"automargin": True, "autorange": "reversed", "type": "category", "ticks": ""})
    lines = max(trace["name"].count("<br>") for trace in traces) + 1
    return {"data": traces, "layout": layout | {"height": 90 + max(46, 18 * lines + 10) * len(traces)}}


def box(look: Look, shown: Sequence[Flown], count: int, metric: str) -> Figure:
    """Return the box of one tracker; its label tells how many of its flights have no value to show."""
    missing = count - len(shown)
    name = wrapped(look.name) + (f"<br><i>{missing} of {count} not shown</i>" if missing else "")
    values: list[float | None] = [flight.summary[metric] for flight in shown]
    return {
        "type": "box",
        "orientation": "h",
        "name": name,
        "meta": look.index,
        "x": values or [None],
        "y": [name] * max(len(values), 1),
        "text": [escape(flight.case) for flight in shown],
        "hovertemplate": "%{x:.3f} m, %{text}<extra></extra>",
        "hoveron": "points",
        "boxpoints": "all",
        "jitter": 0.5,
        "pointpos": 0,
        "line": {"color": look.color, "width": 1.6},
        "fillcolor": "rgba(148,163,184,0.18)",
        "marker": {"color": look.color, "size": 5, "opacity": 0.75},
        "showlegend": False,
    }


def wrapped(name: str) -> str:
    """Return a tracker's name for a figure, its parameters in lines of their own where it is long."""
    if len(name) <= WRAP:
        return escape(name)
    return escape(name).replace(":", ":<br>", 1).replace(",", ",<br>")


def axes(across: Figure, up: Figure) -> Figure:
    """Return the layout of a figure with one pair of axes."""
    plain = {"gridcolor": GRID, "zeroline": False, "automargin": True}
    return {
        "font": FONT,
        "margin": {"l": 56, "r": 16, "t": 16, "b": 44},
        "plot_bgcolor": "#fff",
        "xaxis": plain | across,
        "yaxis": plain | up,
    }


def medians(group: Group, looks: Looks) -> list[tuple[Look, Flown]]:
    """Return the trackers that flew a group and the median flight of each."""
    found = [(look, group.median(look.name)) for look in looks.values()]
    return [(look, flight) for look, flight in found if flight is not None]


def present(group: Group, looks: Looks) -> list[Look]:
    """Return the trackers that flew a group."""
    return [look for look, _ in medians(group, looks)]


def thinned(flight: Flown, most: int) -> NDArray[np.int_]:
    """Return evenly spaced samples of a flight, at most `most`, and the one with the largest error."""
    even = np.linspace(0, len(flight.time) - 1, min(most, len(flight.time))).round().astype(int)
    error = flight.cross_track
    return np.union1d(even, [int(np.nanargmax(error))] if np.isfinite(error).any() else [0])


def still(route: NDArray[np.float64]) -> Scene:
    """Return a scene of a route alone."""
    return Scene(route=route, course=route, meshes=())


def stroke(look: Look, width: float) -> Figure:
    """Return how the lines of a tracker are drawn."""
    return {"color": look.color, "dash": look.dash, "width": width}
