"""The picture of a trade-off study: curves, speed and acceleration for several weights, and what nearness costs."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import GRID, INK, ROUTE
from crosstrack.trajectory.weights.study import Study, Tradeoff

SAMPLES = 1000
"""points drawn of a curve"""


def study_picture(study: Study, path: str | Path) -> Path:
    """Write the picture of a study as a PNG file and return its path.

    Args:
        study: curves of two dimensions or more; the first two are drawn
        path: its folder is made where it is missing

    Raises:
        OSError: the file cannot be written.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write(draw(study), path)
    return path


def draw(study: Study) -> Figure:
    """Return the figure of a study."""
    figure = sheet(13, 8.5)
    grid = figure.add_gridspec(4, 3, width_ratios=[1.25, 1, 0.85])
    colors = colormaps["viridis_r"](np.linspace(0.12, 1, len(study.rows)))
    plan(figure.add_subplot(grid[:, 0]), study, colors)
    over_time(figure.add_subplot(grid[:2, 1]), study, colors, 1, "speed (m/s)")
    over_time(figure.add_subplot(grid[2:, 1]), study, colors, 2, "acceleration (m/s²)")
    front(figure.add_subplot(grid[:2, 2]), study, colors, [row.max_speed for row in study.rows], "peak speed (m/s)")
    peaks = [row.max_acceleration for row in study.rows]
    front(figure.add_subplot(grid[2:, 2]), study, colors, peaks, "peak acceleration (m/s²)")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 8), frameon=False)
    return figure


def plan(axes: Any, study: Study, colors: Any) -> None:
    """Draw the curves over the waypoints, their straight legs and their corridor, with equal axes."""
    points = study.waypoints[:, :2]
    axes.plot(*points.T, "--", color=ROUTE, linewidth=1, label="straight legs", zorder=1.5)
    if (half := study.corridor) is not None:
        for x, y in points[1:-1].tolist():
            box = Rectangle((x - half, y - half), 2 * half, 2 * half)
            axes.add_patch(box)
            box.set(facecolor=GRID, edgecolor=ROUTE, linewidth=0.4)
    for row, color in zip(study.rows, colors, strict=True):
        line = row.curve(np.linspace(0, row.curve.duration, SAMPLES))[:, :2]
        axes.plot(*line.T, color=color, linewidth=1.5, label=name(row), zorder=2)
    axes.plot(
        *points.T, "o", color="white", markeredgecolor=INK, markersize=4, linestyle="none", label="waypoints", zorder=3
    )
    axes.set(xlabel="x (m)", ylabel="y (m)", title="Trajectories")
    axes.set_aspect("equal", adjustable="datalim")
    tidy(axes)


def over_time(axes: Any, study: Study, colors: Any, order: int, label: str) -> None:
    """Draw the norm of a derivative over time."""
    for row, color in zip(study.rows, colors, strict=True):
        t = np.linspace(0, row.curve.duration, SAMPLES)
        axes.plot(t, np.linalg.norm(row.curve(t, order), axis=1), color=color, linewidth=1.2)
    axes.set(xlabel="time (s)", ylabel=label)
    axes.margins(x=0)
    axes.set_ylim(bottom=0)
    tidy(axes)


def front(axes: Any, study: Study, colors: Any, peaks: list[float], label: str) -> None:
    """Draw the largest deviation against a peak, a point for every weight."""
    deviations = [row.max_deviation for row in study.rows]
    axes.plot(peaks, deviations, color=GRID, linewidth=1.5, zorder=1)
    axes.scatter(peaks, deviations, c=colors, s=45, edgecolors=INK, linewidths=0.6, zorder=2)
    axes.set(xlabel=label, ylabel="largest deviation (m)")
    axes.set_ylim(bottom=0)
    axes.margins(x=0.15)
    tidy(axes)


def name(row: Tradeoff) -> str:
    """Return what a curve is called."""
    return f"λ = {row.weight:g}"


def tidy(axes: Any) -> None:
    """Give axes the look of all pictures."""
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
