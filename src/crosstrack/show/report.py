"""The report of some flights: one HTML file that needs nothing else."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jinja2 import Environment, PackageLoader, select_autoescape
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.flight.summary import summary
from crosstrack.show.figures import View, plan_view, space, times
from crosstrack.show.panels import panels
from crosstrack.show.stage import stage
from crosstrack.show.style import LEAST_TOP, PALETTE, SCALE
from crosstrack.show.traces import packed
from crosstrack.show.traffic import movers, shifts
from crosstrack.show.words import AVOIDING_CARDS, CARDS, CHASED, NOTHING, rows
from crosstrack.types import Array

DRAWN = 4000
"""samples of one flight that are drawn at most, besides the one with the largest error"""
FRAMES = 200
"""stops of the time slider"""
LISTED = 200
"""items of one list of the mission that are written out"""
TRAIL = 3.0
"""s, behind the vehicle"""


@dataclass(frozen=True)
class Page:
    """What the template shows of one flight."""

    name: str
    color: str
    outcome: str
    """key of the outcome"""
    sentence: str
    mission: str
    """YAML"""


def report(flights: Sequence[Flight], path: str | Path) -> Path:
    """Write the report of one or several flights and return its path.

    The world, the route and the course are those of the first flight.

    Args:
        flights: at least one
        path: the HTML file; its folder is made where it is missing

    Raises:
        OSError: the file cannot be written.
    """
    path, drawn = Path(path), stage(flights[0].plan)
    names = [flight.plan.name for flight in flights]
    labels = [f"{index + 1}: {name}" for index, name in enumerate(names)] if len(names) > 1 else names
    views = [view(*each) for each in zip(flights, labels, cycle(PALETTE), strict=False)]
    summaries = [summary(flight) for flight in flights]
    text = (
        environment()
        .get_template("report.html")
        .render(
            title=", ".join(dict.fromkeys(names)),
            pages=[page(view, numbers) for view, numbers in zip(views, summaries, strict=True)],
            cards=[row for row in rows(summaries, headline(flights)) if row.values != (NOTHING,)],
            rows=rows(summaries),
            plotly=get_plotlyjs(),
            data=script_safe(figures(views, drawn)),
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def headline(flights: Sequence[Flight]) -> tuple[str, ...]:
    """Return the metrics that head the report; of several flights none, the table has them."""
    if len(flights) > 1:
        return ()
    return (*CARDS, *(AVOIDING_CARDS if flights[0].plan.avoiders else ()))


def environment() -> Environment:
    """Return the templates; everything that is put into one is escaped unless the template says otherwise."""
    return Environment(
        loader=PackageLoader("crosstrack.show"),
        autoescape=select_autoescape(default=True),
        trim_blocks=True,
        lstrip_blocks=True,
    )


def page(view: View, numbers: dict[str, Any]) -> Page:
    """Return what the template shows of a flight."""
    plan = view.flight.plan
    return Page(plan.name, view.color, numbers["outcome"], numbers["outcome_text"], mission_text(plan.document))


def mission_text(document: Mapping[str, Any]) -> str:
    """Return a mission's document as YAML, without the far end of long lists."""
    short = shortened(dict(document))
    return yaml.safe_dump(short, sort_keys=False, allow_unicode=True, width=100, default_flow_style=None)


def shortened(value: Any) -> Any:
    """Return a document with the first `LISTED` items of its longer lists, and how many more there are."""
    if isinstance(value, dict):
        return {name: shortened(inner) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        rest = len(value) - LISTED
        return [*map(shortened, value[:LISTED]), *([f"... and {rest} more"] if rest > 0 else [])]
    return value


def view(flight: Flight, label: str, color: str) -> View:
    """Return a flight with what is drawn of it."""
    error = flight.cross_track
    return View(
        flight=flight,
        label=escape(label),
        color=color,
        rows=thinned(error),
        error=error,
        panels=panels(flight, error),
    )


def thinned(error: Array, most: int = DRAWN) -> NDArray[np.int_]:
    """Return evenly spaced samples, at most `most`, and the one with the largest error."""
    last = len(error) - 1
    even = np.linspace(0, last, min(most, len(error))).round().astype(int)
    worst = int(np.nanargmax(error)) if np.isfinite(error).any() else 0
    return np.union1d(even, [worst])


def figures(views: Sequence[View], drawn: Scene) -> dict[str, Any]:
    """Return all that the page's script draws."""
    end = max(float(view.flight.record.time[-1]) for view in views)
    start = min(float(view.flight.record.time[0]) for view in views)
    stops = np.linspace(start, end, FRAMES).round(3)
    return {
        "space": space(views, drawn),
        "plan": plan_view(views, drawn),
        "times": times(views),
        "scale": [list(step) for step in SCALE],
        "least": LEAST_TOP,
        "aim": CHASED[views[0].flight.plan.course.trajectory is not None],
        "stops": stops.tolist(),
        "vehicles": [vehicle(view, stops) for view in views],
        "shifts": [packed(shifts(mover, stops).ravel()) for mover in movers(views[0].flight.plan)],
    }


def vehicle(view: View, stops: Array) -> dict[str, Any]:
    """Return where a vehicle is at every stop of the slider, and what its path can be coloured by."""
    record = view.flight.record
    at = np.clip(np.searchsorted(record.time, stops, side="right") - 1, 0, len(record.time) - 1)
    speed = np.linalg.norm(record.velocity, axis=1)
    return {
        "color": view.color,
        "label": view.label,
        "position": packed(record.position[at].ravel()),
        "attitude": packed(record.attitude[at].ravel()),
        "aim": packed(record.aim[at].ravel()),
        "head": packed(np.searchsorted(view.rows, at)),
        "tail": packed(np.searchsorted(view.rows, np.searchsorted(record.time, record.time[at] - TRAIL))),
        "speed": packed(speed[view.rows]),
        "error": packed(view.error[view.rows]),
        "speed_at": packed(speed[at]),
        "error_at": packed(view.error[at]),
    }


def script_safe(data: dict[str, Any]) -> str:
    """Return JSON that may stand in a script element: nothing in it can close the element."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
