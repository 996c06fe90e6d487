"""Pictures of the avoidance benchmark: a flight from above, and the shares of successes."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from crosstrack.campaign.avoidance.score import Score
from crosstrack.campaign.avoidance.trial import built
from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import ALARM, FOOTPRINT, GRID, INK, PALETTE, PLANNED, ROUTE
from crosstrack.types import Outcome
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

ROOM = 1.0
"""m, drawn around the bounds"""


def flight_picture(result: Mapping[str, Any], path: str | Path) -> None:
    """Write a flight from above as a PNG file: obstacles, the shortest way, what was planned, what was flown.

    Args:
        result: what `campaign.avoidance.trial.fly` returned
        path: in a folder that is there

    Raises:
        OSError: the file cannot be written.
    """
    document, summary = result["document"], result["summary"]
    wide, deep = np.diff(np.array(document["world"]["bounds"])[:, :2], axis=0)[0] + 2 * ROOM
    figure = sheet(9, 1.9 + 8 * min(1.0, deep / wide))
    axes: Any = figure.add_subplot()
    ground(axes, built(document["world"]))
    lines(axes, result)
    start, goal = document["start"]["position"], document.get("goal") or document["route"][-1]
    axes.plot(*start[:2], "o", color=INK, markersize=8, label="start")
    axes.plot(*goal[:2], "*", color=INK, markersize=13, label="goal")
    sentence = Outcome[result["outcome"].upper()].value
    after = f", after {summary['flight_time_s']:.1f} s" if summary else ""
    axes.set_title(f"{document['name']}{after}\n{sentence}", loc="left", fontsize=10, parse_math=False)
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)")
    axes.set_aspect("equal")
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    write(figure, Path(path))


def ground(axes: Any, world: World) -> None:
    """Draw obstacles and bounds."""
    assert world.bounds is not None
    low, high = world.bounds[:, :2]
    for shape in world.shapes:
        if isinstance(shape, Cylinder):
            axes.add_patch(Circle(shape.center, shape.radius, color=FOOTPRINT, linewidth=0))
        elif isinstance(shape, Box):
            sides = np.subtract(shape.max, shape.min)
            axes.add_patch(Rectangle(shape.min[:2], sides[0], sides[1], color=FOOTPRINT, linewidth=0))
    axes.add_patch(Rectangle(low, *(high - low), fill=False, edgecolor=ROUTE, linewidth=1))
    axes.set(xlim=(low[0] - ROOM, high[0] + ROOM), ylim=(low[1] - ROOM, high[1] + ROOM))


def lines(axes: Any, result: Mapping[str, Any]) -> None:
    """Draw the shortest way, the first and the last course, the flight, and where it ended."""
    if result["optimum"] is not None:
        points = np.array(result["optimum"]["points"])
        axes.plot(*points.T, ":", color=ROUTE, linewidth=1.6, label="shortest way that keeps 0.25 m")
    courses = [np.array(course) for course in result["courses"]]
    for course in courses[1:-1]:
        axes.plot(*course[:, :2].T, "--", color=PLANNED, linewidth=0.5, alpha=0.4)
    for course, width, label in zip(
        [*courses[:1], *courses[1:][-1:]], (0.9, 1.6), ("first plan", "last plan"), strict=False
    ):
        axes.plot(*course[:, :2].T, "--", color=PLANNED, linewidth=width, label=label)
    if result["trace"] is None:
        return
    flown, steered = np.array(result["trace"]["position"]), np.array(result["trace"]["steered"])
    axes.plot(*flown[:, :2].T, color=PALETTE[0], linewidth=1.8, label="flown")
    if steered.any():
        held = np.where(steered[:, None], flown, np.nan)
        axes.plot(*held[:, :2].T, color=PALETTE[1], linewidth=2.6, label="an avoider stepped in")
    if result["outcome"] != "arrived":
        axes.plot(*flown[-1, :2], "X", color=ALARM, markersize=10, label="ended here")


def share_picture(scores: Sequence[Score], path: str | Path) -> None:
    """Write the shares of successes with their 95 % intervals as a PNG file.

    Raises:
        OSError: the file cannot be written.
    """
    write(shares(scores), Path(path))


def shares(scores: Sequence[Score]) -> Figure:
    """Return the figure of the shares of successes: a group for every family, a point for every contestant."""
    families = list(dict.fromkeys(row.family for row in scores))
    names = list(dict.fromkeys(row.contestant for row in scores))
    figure = sheet(9, 1.6 + 0.22 * len(families) * (len(names) + 1))
    axes: Any = figure.add_subplot()
    for k, name in enumerate(names):
        mine = [row for row in scores if row.contestant == name]
        heights = [-families.index(row.family) - (k + 1) / (len(names) + 1) for row in mine]
        share = np.array([100 * row.succeeded / row.flights for row in mine])
        low, high = 100 * np.array([row.interval for row in mine]).T
        color = PALETTE[k % len(PALETTE)]
        axes.errorbar(share, heights, xerr=[share - low, high - share], fmt="o", color=color, capsize=3, label=name)
    axes.set_yticks([-k - 0.5 for k in range(len(families))], families, parse_math=False)
    axes.set_yticks([-k for k in range(len(families) + 1)], minor=True)
    axes.grid(axis="y", which="minor", color=GRID)
    axes.grid(axis="x", color=GRID)
    axes.set(xlabel="succeeded, with 95 % interval (%)", xlim=(-2, 102), ylim=(-len(families), 0))
    axes.tick_params(axis="y", which="both", length=0)
    axes.spines[["top", "right", "left"]].set_visible(False)
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure
