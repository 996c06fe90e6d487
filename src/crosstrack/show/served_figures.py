"""The figures of a served session: in space, from above, over time."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import cycle

import numpy as np
from numpy.typing import NDArray

from crosstrack import frames
from crosstrack.airsim.scene.markers import Marker
from crosstrack.flight.served import Session
from crosstrack.flight.served_calls import Call
from crosstrack.flight.served_track import Track
from crosstrack.show.extent import around
from crosstrack.show.layouts import curve, plan_layout, space_layout, times_layout
from crosstrack.show.panels import Panel, Series
from crosstrack.show.served_markers import Stroke, hexadecimal, shown, strokes
from crosstrack.show.style import ALARM, FOOTPRINT, INK, PALETTE
from crosstrack.show.traces import Figure, backdrop, line2, line3, mark, mark3, packed, solid
from crosstrack.types import Array

DRAWN = 60_000
"""rows of all tracks together that are drawn at most"""
LEAST = 500
"""rows of one track, however many tracks there are"""
FAR = 2.0
"""times the longest side of what flew and stands there, beyond which markers do not widen the view"""
MOST_NAMES = 16
"""moves that have a line of their own over time"""
LANE, THICK = 0.6, 8.0
"""of the distance between two moves, and pixels: what the lines of all vehicles take in beside one another"""
STOPS = 400
"""of the time slider"""
NOWHERE = np.full((1, 3), np.nan)
"""m, a point that is not drawn, for an entry of a legend"""
OBSTACLES, COLLISIONS = "objects", "collisions"


@dataclass(frozen=True)
class Way:
    """A track with what is drawn of it."""

    name: str
    color: str
    track: Track
    rows: NDArray[np.int_]
    """(k,) that are drawn"""
    jumps: NDArray[np.int_]
    """of the drawn rows: those that no line leads to"""

    def line(self) -> Array:
        """Return the points of it (k + jumps, 3) m, with NaN where it was moved without flying."""
        return np.insert(self.track.position[self.rows], self.jumps, np.nan, axis=0)

    def time(self) -> Array:
        """Return the time (k + jumps,) s of every point of the line."""
        time = self.track.time[self.rows]
        return np.insert(time, self.jumps, time[self.jumps])

    def with_gaps(self, values: Array) -> Array:
        """Return values (n,) of all rows as those of the points of the line."""
        return np.insert(values[self.rows], self.jumps, np.nan)


def ways(session: Session) -> list[Way]:
    """Return the tracks with their colours: that of its trace, where a client gave it one."""
    most = max(LEAST, DRAWN // max(len(session.tracks), 1))
    found = []
    for (name, track), color in zip(session.tracks.items(), cycle(PALETTE), strict=False):
        trace = session.traces.get(name)
        jumps = track.jumps
        even = np.linspace(0, len(track.time) - 1, min(most, len(track.time))).round().astype(int)
        rows = np.union1d(even, np.concatenate([jumps - 1, jumps])) if len(jumps) < most else even
        gaps = np.unique(np.searchsorted(rows, jumps))
        shade = color if trace is None else hexadecimal(trace.color)
        found.append(Way(escape(name), shade, track, rows, gaps[gaps < len(rows)]))
    return found


def figures(session: Session) -> dict[str, object]:
    """Return all that the page's script draws."""
    flown, markers = ways(session), shown(session.markers)
    box = view(session, flown, markers)
    drawn = strokes(markers, float((box[1] - box[0]).max()))
    stops = np.linspace(0.0, max(session.duration, 1e-3), STOPS)
    return {
        "space": space(session, flown, drawn, box),
        "plan": plan_view(session, flown, drawn, box),
        "times": times(session, flown),
        "stops": stops.round(3).tolist(),
        "vehicles": [{"color": way.color, "name": way.name, "position": packed(at(way, stops))} for way in flown],
    }


def view(session: Session, flown: Sequence[Way], markers: Sequence[Marker]) -> Array:
    """Return the box (2, 3) m that is drawn: vehicles, objects, and markers that are not too far off."""
    paths = [way.track.position for way in flown]
    box = around([np.zeros((1, 3)), *paths], session.scene)
    reach = FAR * float((box[1] - box[0]).max())
    drawn = [frames.enu_from_ned(marker.points) for marker in markers]
    near = [one[((one > box[0] - reach) & (one < box[1] + reach)).all(axis=1)] for one in drawn]
    return around([np.zeros((1, 3)), *paths, *near], session.scene)


def space(session: Session, flown: Sequence[Way], drawn: Sequence[Stroke], box: Array) -> Figure:
    """Return the view in space."""
    obstacles = session.scene.solid()
    traces = [] if obstacles is None else [solid(OBSTACLES, *obstacles)]
    traces += [grouped(stroke.in_space(), stroke.kind, first) for stroke, first in firsts(drawn)]
    for way in flown:
        hover = {"hovertemplate": "%{x:.2f}, %{y:.2f}, %{z:.2f} m"}
        traces.append(line3(way.line(), way.name, color=way.color, width=5) | hover)
    traces += [mark3(*each) for each in marks(session, flown)]
    return {"data": traces, "layout": space_layout(box)}


def plan_view(session: Session, flown: Sequence[Way], drawn: Sequence[Stroke], box: Array) -> Figure:
    """Return the view from above, with equal axes."""
    traces = [backdrop(session.scene, box)] if session.scene.meshes else []
    traces += [grouped(stroke.from_above(), stroke.kind, first) for stroke, first in firsts(drawn)]
    traces += [line2(way.line(), way.name, color=way.color, width=2.2) for way in flown]
    if session.scene.meshes:
        traces.append(mark(OBSTACLES, NOWHERE, {"size": 12, "color": FOOTPRINT, "symbol": "square"}))
    traces += [mark(*each) for each in marks(session, flown)]
    return {"data": traces, "layout": plan_layout(box)}


def firsts(drawn: Sequence[Stroke]) -> Iterator[tuple[Stroke, bool]]:
    """Yield strokes, and whether each is the first of its kind."""
    kinds: set[str] = set()
    for stroke in drawn:
        yield stroke, stroke.kind not in kinds
        kinds.add(stroke.kind)


def grouped(trace: Figure, kind: str, first: bool) -> Figure:
    """Return a trace that shares an entry of the legend with all of its kind."""
    return trace | {"legendgroup": kind, "showlegend": first}


def marks(session: Session, flown: Sequence[Way]) -> Iterator[tuple[str, Array, Figure]]:
    """Yield name, points (n, 3) m and marker of starts and collisions."""
    starts = [way.track.position[0] for way in flown if len(way.track.time)]
    if starts:
        look = {"size": 9, "color": "#fff", "line": {"color": INK, "width": 2}, "symbol": "circle"}
        yield "start", np.array(starts), look
    if session.collisions:
        at = np.array([touch.position for touch in session.collisions])
        yield COLLISIONS, at, {"size": 10, "color": ALARM, "symbol": "x"}


def times(session: Session, flown: Sequence[Way]) -> Figure:
    """Return height, speed and moves under one another over a common time axis."""
    shown = panels(session, flown)
    traces = []
    for index, panel in enumerate(shown):
        for way, series in zip(flown, panel.series, strict=True):
            traces.append(
                curve(
                    way.time(),
                    series.values,
                    index,
                    way.name,
                    panel.unit,
                    line={"color": way.color, "width": 1.6},
                    showlegend=len(flown) > 1,
                )
            )
    names = move_names(session.calls)
    if names:
        for number, way in enumerate(flown):
            moving = {"color": way.color, "width": max(2.0, THICK / len(flown))}
            time, values = under_way(session, way.name, names)
            values += LANE * ((len(flown) - 1) / 2 - number) / len(flown)
            traces.append(curve(time, values, len(shown), way.name, "", line=moving, showlegend=False))
        shown.append(Panel("Moves", "", (Series("moves", np.arange(1.0, len(names) + 1)),), names=names))
    return {"data": traces, "layout": times_layout(shown)}


def panels(session: Session, flown: Sequence[Way]) -> list[Panel]:
    """Return the panels of quantities, a series for every vehicle."""
    heights = tuple(Series(way.name, way.with_gaps(way.track.position[:, 2])) for way in flown)
    speeds = tuple(Series(way.name, way.with_gaps(np.linalg.norm(way.track.velocity, axis=1))) for way in flown)
    return [Panel("Height", "m", heights, from_zero=False, span=1.0), Panel("Speed", "m/s", speeds)]


def move_names(calls: Sequence[Call]) -> tuple[str, ...]:
    """Return the names of the moves that are shown over time, the first called at the top."""
    names = dict.fromkeys(call.name for call in calls if call.vehicle)
    return tuple(reversed(list(names)[:MOST_NAMES]))


def under_way(session: Session, vehicle: str, names: Sequence[str]) -> tuple[Array, Array]:
    """Return times (n,) s and values (n,) of a line that shows when each move of a vehicle was under way."""
    found = [
        (call.begins, call.ends if np.isfinite(call.ends) else session.duration, names.index(call.name) + 1.0)
        for call in session.calls
        if escape(call.vehicle) == vehicle and call.name in names
    ]
    spans = np.array(found).reshape(-1, 3)
    time = np.column_stack([spans[:, 0], spans[:, 1], spans[:, 1]]).ravel()
    values = np.column_stack([spans[:, 2], spans[:, 2], np.full(len(spans), np.nan)]).ravel()
    return time, values


def at(way: Way, stops: Array) -> Array:
    """Return where a vehicle is at some times (n,) s, (3 n,) m, end to end."""
    rows = np.clip(np.searchsorted(way.track.time, stops, side="right") - 1, 0, len(way.track.time) - 1)
    return way.track.position[rows].ravel()
