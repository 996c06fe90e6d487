"""The page of a served session: one HTML file that needs nothing else."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np
from plotly.offline import get_plotlyjs

from crosstrack import frames
from crosstrack.flight.served import Session
from crosstrack.flight.served_calls import Call, clean
from crosstrack.show.report import environment, script_safe
from crosstrack.show.served_figures import figures, ways
from crosstrack.show.served_markers import shown
from crosstrack.show.words import NOTHING

LISTED = 500
"""rows of a table that are written out"""
AXES = "Axes here are east, north and up; positions in the tables are north, east and down, as in calls."
CAPTION = "Objects are shown as they were at the end, markers whenever they were drawn."


@dataclass(frozen=True)
class Table:
    """A table, written out."""

    title: str
    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    note: str = ""
    """what is left out"""


def served_page(session: Session, path: str | Path, title: str = "AirSim session") -> Path:
    """Write the page of a session and return its path.

    Args:
        session: what was recorded
        path: the HTML file; its folder is made where it is missing
        title: of the page

    Raises:
        OSError: the file cannot be written.
    """
    path = Path(path)
    text = (
        environment()
        .get_template("served.html")
        .render(
            title=title,
            sentence=sentence(session),
            vehicles=[(name, way.color) for name, way in zip(session.tracks, ways(session), strict=True)],
            cards=list(cards(session)),
            tables=[table for table in (moves(session), collisions(session), objects(session)) if table.rows],
            notes=[*session.notes, *left_out(session), CAPTION, AXES],
            plotly=get_plotlyjs(),
            data=script_safe(figures(session)),
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def sentence(session: Session) -> str:
    """Return what happened in a sentence."""
    calls = sum(call.count for call in session.calls)
    parts = (
        counted(len(session.tracks), "vehicle"),
        counted(calls, "call") + " of moves",
        counted(len(session.collisions), "collision"),
        counted(len(session.markers), "marker") + " drawn",
    )
    return f"{', '.join(parts)}, in {session.duration:.1f} s of simulated time."


def counted(count: int, noun: str) -> str:
    """Return how many there are of something."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def cards(session: Session) -> Iterator[tuple[str, str, str]]:
    """Yield label, value and unit of the numbers that head the page."""
    tracks = session.tracks.values()
    yield "Simulated time", f"{session.duration:.1f}", "s"
    yield "Length flown", f"{sum(track.length for track in tracks):.1f}", "m"
    speeds = [np.linalg.norm(track.velocity, axis=1).max() for track in tracks if len(track.time)]
    yield "Top speed", f"{max(speeds, default=0.0):.2f}", "m/s"
    heights = [track.position[:, 2].max() for track in tracks if len(track.time)]
    yield "Greatest height", f"{max(heights, default=0.0):.2f}", "m"
    yield "Collisions", str(len(session.collisions)), ""


def moves(session: Session) -> Table:
    """Return the table of moves."""
    rows = [
        (
            f"{call.begins:.2f}",
            f"{call.ends:.2f}" if isfinite(call.ends) else NOTHING,
            call.vehicle or "all",
            called(call),
            call.answer or ("under way at the end" if not isfinite(call.ends) else NOTHING),
        )
        for call in session.calls[:LISTED]
    ]
    heads = ("from, s", "to, s", "vehicle", "call", "answer")
    return Table("Moves", heads, rows, more(len(session.calls)))


def called(call: Call) -> str:
    """Return a call as text."""
    return (
        f"{call.name}({call.arguments})"
        if call.count == 1
        else f"{call.name}({call.arguments}) and on, {call.count} calls"
    )


def collisions(session: Session) -> Table:
    """Return the table of collisions."""
    rows = [
        (
            f"{touch.begins:.2f}",
            touch.vehicle,
            touch.thing,
            triple(frames.ned_from_enu(touch.position)),
            str(touch.count),
        )
        for touch in session.touches[:LISTED]
    ]
    heads = ("at, s", "vehicle", "object", "position, m", "times")
    return Table("Contacts", heads, rows, more(len(session.touches)))


def objects(session: Session) -> Table:
    """Return the table of objects, by name."""
    standing = [thing for thing in session.things if thing.solid is not None]
    rows = []
    for thing in standing[:LISTED]:
        low, high = thing.box
        centre, size = frames.ned_from_enu((low + high) / 2), np.abs(frames.ned_from_enu(high - low))
        rows.append((clean(thing.name), triple(centre), triple(size)))
    return Table("Objects", ("name", "centre, m", "size, m"), rows, more(len(standing)))


def triple(vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    """Return a vector (3,) as text."""
    return ", ".join(f"{round(float(part), 2) + 0.0:.2f}" for part in vector)


def more(count: int) -> str:
    """Return how many rows a table leaves out."""
    return f"{count - LISTED} more are not listed." if count > LISTED else ""


def left_out(session: Session) -> Iterator[str]:
    """Yield what the page does not draw."""
    missing = len(session.markers) - len(shown(session.markers))
    if missing:
        yield f"{counted(missing, 'earlier marker')} left out of the page."
