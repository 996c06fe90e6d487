"""Pictures of potential fields: surface, forces and paths, the bump near the goal, the sides to turn to."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from crosstrack.avoid.potential_field import Terms, attraction, bell
from crosstrack.avoid.potential_run import Law, PotentialRun, potential_at
from crosstrack.protocols import Map
from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import FOOTPRINT, GRID, INK, PALETTE
from crosstrack.types import Array, Outcome

POINTS = 90
"""along each side of a surface"""
ARROWS = 5
"""points of it from one arrow to the next"""


def field_picture(world: Map, goal: Array, law: Law, runs: Mapping[str, PotentialRun], path: str | Path) -> Path:
    """Write the potential of a map of two dimensions with its forces and the paths flown; return the picture's path.

    Args:
        world: within bounds
        goal: (2,) m
        law: whose potential is drawn
        runs: paths by their names, in the plane
        path: of the PNG file

    Raises:
        OSError: the file cannot be written.
    """
    figure = sheet(13, 6)
    x, y, heights = surface(world, goal, law.terms)
    space: Any = figure.add_subplot(1, 2, 1, projection="3d")
    space.plot_surface(x, y, heights, cmap="viridis", rcount=POINTS, ccount=POINTS, linewidth=0, antialiased=False)
    space.set(xlabel="x (m)", ylabel="y (m)", zlabel="potential, root (m/s)", title="Potential")
    space.view_init(elev=48, azim=-125)
    axes: Any = figure.add_subplot(1, 2, 2)
    drawn = axes.contourf(x, y, heights, levels=24, cmap="viridis")
    figure.colorbar(drawn, ax=axes, shrink=0.85, label="root of the potential (m/s)")
    down = -np.array(np.gradient(heights, x[:, 0], y[0]))
    length = np.maximum(np.hypot(*down), 1e-9)
    some = (slice(ARROWS // 2, None, ARROWS),) * 2
    free = world.distance(np.stack([x, y, np.ones_like(x)], axis=-1)) > 0
    arrows = np.where(free, down / length, np.nan)
    axes.quiver(x[some], y[some], *arrows[:, *some], color="white", width=0.002, scale=42, pivot="mid")
    lay_out(axes, world, goal, runs)
    axes.set_title("Direction of the force, and paths")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False)
    return save(figure, path)


def surface(world: Map, goal: Array, terms: Terms) -> tuple[Array, Array, Array]:
    """Return x, y and the root of the potential on a lattice, each (n, n), capped above what the attraction reaches."""
    bounds = world.bounds
    low, high = (np.zeros(3), np.full(3, 100.0)) if bounds is None else bounds
    x, y = np.meshgrid(*(np.linspace(low[k], high[k], POINTS) for k in range(2)), indexing="ij")
    end = np.append(goal, 1.0)
    points = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    heights = np.array([potential_at(world, point, end, terms, planar=True) for point in points])
    most = max(attraction(end - point, terms.attraction, np.inf)[0] for point in points)
    return x, y, np.sqrt(np.minimum(heights, 1.6 * most * terms.boost)).reshape(x.shape)


def sides_picture(world: Map, goal: Array, runs: Mapping[str, PotentialRun], path: str | Path) -> Path:
    """Write the paths of several runs on one map of two dimensions, a panel for each; return the picture's path.

    Args:
        world: within bounds
        goal: (2,) m
        runs: paths by their names, in the plane
        path: of the PNG file

    Raises:
        OSError: the file cannot be written.
    """
    figure = sheet(4.4 * len(runs), 5)
    for k, (name, run) in enumerate(runs.items()):
        axes = figure.add_subplot(1, len(runs), k + 1)
        lay_out(axes, world, goal, {"path": run})
        words = f"{run.length:.0f} m" if run.outcome is Outcome.ARRIVED else run.outcome.name.lower().replace("_", " ")
        axes.set_title(f"{name}: {words}")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=6, frameon=False)
    return save(figure, path)


def bell_picture(path: str | Path) -> Path:
    """Write the factor K_d of the attraction over the distance to the goal; return the picture's path.

    Raises:
        OSError: the file cannot be written.
    """
    figure = sheet(7, 3.6)
    axes: Any = figure.add_subplot()
    distance = np.linspace(0, 6, 400)
    axes.plot(distance, [1 + 3 * bell(d, 0.5) for d in distance], color=PALETTE[0], label="3 exp(-(d - 0.5)²/2) + 1")
    axes.axhline(1.0, color=GRID)
    axes.set(xlabel="distance d to the goal (m)", ylabel="$K_d$ (1)", xlim=(0, 6), ylim=(0, 4.3))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    return save(figure, path)


def lay_out(axes: Any, world: Map, goal: Array, runs: Mapping[str, PotentialRun]) -> None:
    """Draw obstacles, paths, start and goal with equal axes."""
    bounds = world.bounds
    low, high = (np.zeros(3), np.full(3, 100.0)) if bounds is None else bounds
    x, y = np.meshgrid(*(np.linspace(low[k], high[k], 400) for k in range(2)), indexing="ij")
    inside = world.distance(np.stack([x, y, np.ones_like(x)], axis=-1))
    axes.contourf(x, y, inside, levels=[-1e9, 0], colors=[FOOTPRINT])
    axes.plot([], [], "s", color=FOOTPRINT, markersize=9, label="obstacles")
    white = {"color": "white", "markeredgecolor": INK, "linestyle": "none"}
    for k, (name, run) in enumerate(runs.items()):
        axes.plot(*run.points.T, color=PALETTE[1 + k], linewidth=1.8, label=name)
        if k == 0:
            axes.plot(*run.points[0], "o", **white, label="start")
        if run.outcome is not Outcome.ARRIVED:
            axes.plot(*run.points[-1], "X", color=PALETTE[1 + k], markeredgecolor="white", linestyle="none")
    axes.plot(*goal, "s", **white, label="goal")
    axes.set(xlabel="x (m)", ylabel="y (m)", xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal")


def save(figure: Figure, path: str | Path) -> Path:
    """Write a figure and return its path, its folder made where it is missing."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write(figure, path)
    return path
