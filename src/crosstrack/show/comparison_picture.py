"""The picture of a comparison: for every mission the paths over its route, and the spread of errors per tracker."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from crosstrack.campaign.words import CALM, OWN
from crosstrack.show.comparison_flights import Flown, Group, Look, flown, groups, looks, weather
from crosstrack.show.comparison_table import standings
from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import ALARM, GRID, INK, ROUTE

LINES = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-."}
ON_PATH = ("cross_track_rms_captured_m", "cross-track error, RMS once captured (m)")
BY_CLOCK = ("tracking_rms_m", "distance to where the trajectory is by then, RMS (m)")
WIDE = 20.0
"""ratio of the largest error to the least from which an axis is logarithmic"""


def comparison_picture(results: Sequence[Mapping[str, Any]], path: str | Path) -> Path:
    """Write the picture of a comparison as a PNG file and return its path.

    Of every mission its first wind is drawn, and of every tracker the flight in the middle from best to worst; the
    boxes hold all flights that arrived.

    Args:
        results: as for `show.comparison.comparison_page`
        path: its folder is made where it is missing

    Raises:
        OSError: the file cannot be written.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write(draw(flown(results)), path)
    return path


def draw(flights: Sequence[Flown]) -> Figure:
    """Return the figure of some flights, a row for every mission."""
    known = looks([flight.tracker for flight in flights])
    first: dict[str, Group] = {}
    for group in groups(flights):
        first.setdefault(group.mission, group)
    if not first:
        figure = sheet(6, 1)
        figure.text(0.5, 0.5, "No flight came back: there is nothing to compare.", ha="center", va="center")
        return figure
    figure = sheet(12, 1 + max(3.2, 1.2 + 0.32 * len(known)) * len(first))
    rows: Any = figure.subplots(len(first), 2, squeeze=False, width_ratios=[1.2, 1])
    for (left, right), group in zip(rows, first.values(), strict=True):
        paths(left, group, known)
        spreads(right, [flight for flight in flights if flight.mission == group.mission], known)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=max(1, min(5, 120 // longest(labels))), frameon=False
    )
    return figure


def longest(labels: Sequence[str]) -> int:
    """Return the letters of the longest of some labels, and of the line beside it."""
    return max(map(len, labels)) + 6


def paths(axes: Any, group: Group, known: Mapping[str, Look]) -> None:
    """Draw the route and the median flights from above, with equal axes, and where flights ended that failed."""
    axes.plot(*group.flights[0].route[:, :2].T, "--", color=ROUTE, linewidth=1)
    for look in known.values():
        flight = group.median(look.name)
        line = flight.position[:, :2].T if flight is not None else np.full((2, 1), np.nan)
        axes.plot(*line, LINES[look.dash], color=look.color, linewidth=1.5, label=look.name)
    lost = [flight.end for flight in group.flights if not flight.arrived]
    if lost:
        axes.plot(*np.array(lost)[:, :2].T, "X", color=ALARM, markersize=7, label="ended here")
    title = group.mission if group.wind in {CALM, OWN} else f"{group.mission}, {weather(group.wind)}"
    axes.set_title(title, loc="left", fontsize=11, parse_math=False)
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)")
    axes.set_aspect("equal", adjustable="datalim")
    tidy(axes)


def spreads(axes: Any, flights: Sequence[Flown], known: Mapping[str, Look]) -> None:
    """Draw a box and its points for every tracker of a mission, the best on top."""
    rows = standings(flights)
    timed = all(flight.summary[BY_CLOCK[0]] is not None for flight in flights)
    metric, name = BY_CLOCK if timed else ON_PATH
    values = [[flight.summary[metric] for flight in flights if counts(flight, row.tracker, metric)] for row in rows]
    heights = range(len(rows), 0, -1)
    for row, height, found in zip(rows, heights, values, strict=True):
        if found:
            box(axes, found, height, known[row.tracker].color)
    every = [value for found in values for value in found]
    if every and min(every) > 0 and max(every) > WIDE * min(every):
        axes.set_xscale("log")
    elif every:
        axes.set_xlim(0, 1.05 * max(max(every), 1e-6))
    axes.set_yticks(heights, [label(row.tracker, row.failures) for row in rows], parse_math=False)
    axes.set_ylim(0.4, len(rows) + 0.6)
    axes.set_xlabel(name)
    tidy(axes)


def box(axes: Any, values: Sequence[float], height: float, color: str) -> None:
    """Draw the quartiles, the median, the whole range and every one of some values at a height."""
    low, first, middle, third, high = np.quantile(values, [0, 0.25, 0.5, 0.75, 1])
    axes.hlines(height, low, high, color=color, linewidth=1.2, zorder=0.8)
    axes.barh(height, third - first, left=first, height=0.5, facecolor="white", edgecolor=color, linewidth=1.2)
    axes.vlines(middle, height - 0.25, height + 0.25, color=color, linewidth=2.2)
    axes.plot(values, np.full(len(values), height), ".", color=color, markersize=5, alpha=0.6)


def counts(flight: Flown, tracker: str, metric: str) -> bool:
    """Return whether a flight belongs into the box of a tracker."""
    return flight.tracker == tracker and flight.arrived and flight.summary[metric] is not None


def label(tracker: str, failures: str) -> str:
    """Return the name of a tracker, cut into lines, and what became of the flights that its box does not hold."""
    name = tracker.replace(":", ":\n", 1).replace(",", ",\n") if len(tracker) > 24 else tracker
    return f"{name}\n{failures}" if failures else name


def tidy(axes: Any) -> None:
    """Give axes the look of all pictures."""
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    axes.tick_params(colors=INK)
    axes.spines[["top", "right"]].set_visible(False)
