"""The picture of an evaluation: flights from above, those at which the policy failed first."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from crosstrack.campaign.avoidance.trial import built
from crosstrack.learn.evaluation.missions import POLICY
from crosstrack.learn.evaluation.score import LATE
from crosstrack.show.bench_picture import ground
from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import GRID, INK, PALETTE, ROUTE

TILES, COLUMNS = 8, 2
ENDS = {"arrived": "o", "collided": "X", "left bounds": "s", "late or stuck": "D", "otherwise": "P"}
"""markers of ends"""
WORDS = {
    "arrived": "arrived",
    "collided": "collided",
    "left_bounds": "left bounds",
    **dict.fromkeys(LATE, "late or stuck"),
}
"""of outcomes; any other is otherwise"""
Result = Mapping[str, Any]


def evaluation_picture(results: Sequence[Result], path: str | Path) -> None:
    """Write a grid of example flights from above as a PNG file; the failures of the policy come first.

    Args:
        results: at least one, what `learn.evaluation.trial.fly` returned
        path: in a folder that is there

    Raises:
        OSError: the file cannot be written.
    """
    names = list(dict.fromkeys(result["labels"]["contestant"] for result in results))
    tiles = examples(results)
    rows = -(-len(tiles) // COLUMNS)
    figure = sheet(13, 0.8 + 3.3 * rows)
    grid: Any = figure.subplots(rows, COLUMNS, squeeze=False)
    for axes, tile in zip(grid.flat, tiles, strict=False):
        scene(axes, tile, names)
    for axes in grid.flat[len(tiles) :]:
        axes.set_axis_off()
    trails = [Line2D([], [], color=color(name, names), linewidth=2, label=name) for name in names]
    ends = [
        Line2D([], [], color=INK, linestyle="", marker=marker, markersize=7, label=word)
        for word, marker in ENDS.items()
    ]
    for axes in grid[-1]:
        axes.set_xlabel("east, m")
    figure.supylabel("north, m")
    figure.legend(handles=[*trails, *ends], loc="outside lower center", ncols=len(trails) + len(ends), frameon=False)
    write(figure, Path(path))


def examples(results: Sequence[Result]) -> list[list[Result]]:
    """Return the flights of at most TILES worlds, those at which the policy failed first."""
    tiles: dict[tuple[str, int], list[Result]] = {}
    for result in results:
        tiles.setdefault((result["labels"]["world"], result["labels"]["seed"]), []).append(result)
    return sorted(tiles.values(), key=went_well)[:TILES]


def went_well(tile: Sequence[Result]) -> bool:
    """Return whether the policy succeeded in a world, or did not fly there."""
    return all(one["outcome"] == "arrived" for one in tile if one["labels"]["contestant"] == POLICY)


def color(name: str, names: Sequence[str]) -> str:
    """Return the colour of a contestant."""
    return PALETTE[names.index(name) % len(PALETTE)]


def scene(axes: Any, tile: Sequence[Result], names: Sequence[str]) -> None:
    """Draw the flights in one world; the policy above the others."""
    said = tile[0]["document"]
    open_air = not said.get("world")
    start = np.array(said["start"]["position"])
    if open_air:
        axes.plot(*np.array([start, *said["route"]])[:, :2].T, ":", color=ROUTE, linewidth=1.2)
    else:
        ground(axes, built(said["world"]))
    axes.plot(*start[:2], ">", color=INK, markersize=6)
    axes.plot(*(said.get("goal") or said["route"][-1])[:2], "*", color=INK, markersize=11)
    for result in sorted(tile, key=lambda one: one["labels"]["contestant"] == POLICY):
        trail(axes, result, color(result["labels"]["contestant"], names))
    labels, wind = tile[0]["labels"], said.get("wind")
    blows = f", wind from {bearing(wind['mean']):.0f}°" if wind else ""
    axes.set_title(f"{labels['world']}, seed {labels['seed']}{blows}: {told(tile)}", fontsize=9, parse_math=False)
    axes.set_aspect("equal", adjustable="datalim" if open_air else "box")
    axes.tick_params(labelsize=7)
    axes.grid(color=GRID)
    axes.set_axisbelow(True)


def bearing(wind: Sequence[float]) -> float:
    """Return where a wind (east, north, ...) comes from, degrees clockwise from north."""
    return float(np.degrees(np.arctan2(-wind[0], -wind[1])) % 360)


def told(tile: Sequence[Result]) -> str:
    """Return how the policy ended in a world."""
    ends = [one["outcome"] for one in tile if one["labels"]["contestant"] == POLICY]
    return ends[0].replace("_", " ") if ends else "not flown by the policy"


def trail(axes: Any, result: Result, shade: str) -> None:
    """Draw what was flown, and how it ended."""
    if result["trace"] is None:
        return
    first = result["labels"]["contestant"] == POLICY
    flown = np.array(result["trace"]["position"])[:, :2]
    axes.plot(*flown.T, color=shade, linewidth=2.0 if first else 1.1, zorder=3 if first else 2.5)
    marker = ENDS[WORDS.get(result["outcome"], "otherwise")]
    size = 5 if result["outcome"] == "arrived" else 9
    axes.plot(*flown[-1], marker, color=shade, markersize=size, markeredgecolor="white", markeredgewidth=0.6, zorder=4)
