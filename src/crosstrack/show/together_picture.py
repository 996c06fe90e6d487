"""Several vehicles in one picture: their paths from above, and how near they came to one another."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.show.extent import extent
from crosstrack.show.footprint import footprint
from crosstrack.show.pictures import sheet, write
from crosstrack.show.stage import groups, stage
from crosstrack.show.style import ALARM, GRID, INK, PALETTE
from crosstrack.types import Array, Outcome

NAMED = 8
"""vehicles that are told apart in the legend, at most"""


def picture_together(flights: Sequence[Flight], path: Path) -> Path:
    """Write a picture of vehicles that flew at the same time, and return its path.

    Raises:
        OSError: the file cannot be written.
    """
    drawn = stage(flights[0].plan)
    box = extent(flights, drawn)
    across, along = (box[1] - box[0])[:2]
    tall = 1.2 + 6.6 * min(1.2, max(0.3, along / across))
    figure = sheet(8, tall + 2)
    above, below = figure.subplots(2, 1, height_ratios=(tall, 2))
    from_above(above, flights, drawn, box)
    separation(below, flights)
    arrived = sum(flight.outcome is Outcome.ARRIVED for flight in flights)
    figure.suptitle(f"{arrived} of {len(flights)} arrived")
    write(figure, path)
    return path


def from_above(axes: Any, flights: Sequence[Flight], drawn: Scene, box: Array) -> None:
    """Draw the paths with equal axes, starts as rings and goals as squares."""
    for group in groups(drawn):
        image = footprint(group.scene, box, group.footprint).convert("RGBA")
        axes.imshow(image, extent=box[:, :2].T.ravel(), zorder=0.6)
    for flight, color in zip(flights, cycle(PALETTE), strict=False):
        route, position = flight.plan.route, flight.record.position
        label = flight.plan.name if len(flights) <= NAMED else None
        axes.plot(*position[:, :2].T, color=color, linewidth=1.2, label=label)
        axes.plot(*position[0, :2], "o", color=color, markerfacecolor="white", markersize=5)
        lost = flight.outcome is not Outcome.ARRIVED
        axes.plot(*position[-1, :2], "x" if lost else ".", color=ALARM if lost else color, markersize=6)
        axes.plot(*route(route.length)[:2], "s", color=color, markerfacecolor="none", markersize=7)
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)", xlim=box[:, 0], ylim=box[:, 1])
    axes.set_title("paths from above; rings: starts, squares: goals", fontsize=10)
    axes.set_aspect("equal")
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    if len(flights) <= NAMED:
        axes.legend(loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)


def separation(axes: Any, flights: Sequence[Flight]) -> None:
    """Draw the least distance between the centres of any two against time, and the sum of their radii."""
    longest = max(flights, key=lambda flight: len(flight.record.time))
    least = np.full(len(longest.record.time), np.inf)
    for flight in flights:
        own: Array = flight.record.separation
        least[: len(own)] = np.minimum(least[: len(own)], own)
    axes.plot(longest.record.time, np.where(np.isfinite(least), least, np.nan), color=PALETTE[0], linewidth=1.2)
    touching = 2 * longest.plan.vehicle.radius
    axes.axhline(touching, color=INK, linestyle="--", linewidth=1)
    axes.set_title(f"dashed: two radii, {touching:g} m", fontsize=10)
    axes.set(xlabel="time (s)", ylabel="least separation (m)", ylim=(0, None))
    axes.margins(x=0)
    axes.grid(color=GRID)
