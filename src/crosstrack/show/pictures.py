"""The figures of a flight as PNG files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from PIL import Image, ImageChops, ImageOps

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.show.avoiding import (
    SEEN_FROM_ABOVE,
    SEEN_IN_SPACE,
    SIGHTED,
    Intervention,
    interventions,
    replanned,
    seen,
)
from crosstrack.show.extent import extent
from crosstrack.show.footprint import footprint
from crosstrack.show.panels import HEADROOM, Panel, Role, panels
from crosstrack.show.solids import AZIMUTH, ELEVATION, behind, faces, lit, unhidden
from crosstrack.show.stage import ABSENT, groups, stage
from crosstrack.show.style import ALARM, GRID, INK, LEAST_TOP, MOVING, PALETTE, PLANNED, ROUTE, SCALE, SEEN
from crosstrack.show.traffic import MOVERS, tracks
from crosstrack.show.words import CHASED
from crosstrack.types import Array, Outcome

DPI = 130
MARGIN = 40
"""pixels, around a picture"""
HIDDEN = 0.25
"""opacity of a path behind obstacles"""
STYLES: dict[Role, str] = {"flown": "-", "planned": "--", "asked": ":", "limit": "-."}


def pictures(flight: Flight, folder: str | Path) -> list[Path]:
    """Write the view in space, the view from above and the panels over time; return their paths.

    Args:
        flight: what to draw
        folder: made where it is missing

    Raises:
        OSError: the folder or a file cannot be written.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    drawn, error = stage(flight.plan), flight.cross_track
    made: dict[str, Callable[[], Figure]] = {
        "space.png": lambda: space(flight, drawn, error),
        "plan.png": lambda: plan_view(flight, drawn),
        "times.png": lambda: times(flight, panels(flight, error)),
    }
    paths = []
    for name, make in made.items():
        figure = make()
        write(figure, folder / name)
        paths.append(folder / name)
    return paths


def write(figure: Figure, path: Path) -> None:
    """Write a figure as PNG without the empty bands around it."""
    figure.dpi = DPI
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    filled = ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox()
    trimmed = image.crop(filled)
    ImageOps.expand(trimmed, MARGIN, "white").save(path)


def sheet(width: float, height: float) -> Figure:
    """Return an empty figure (inches) that belongs to no window."""
    return Figure(figsize=(width, height), layout="constrained", facecolor="white")


def space(flight: Flight, drawn: Scene, error: Array) -> Figure:
    """Draw the view in space with equal axes: the path coloured by its cross-track error, faint behind obstacles."""
    figure = sheet(9, 6.5)
    axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
    box = extent([flight], drawn)
    moving = tracks([flight], box)
    corners, shades = faces(drawn, moving)
    if len(corners):
        axes.add_collection3d(lit(corners, shades), autolim=False)
    axes.plot(*unhidden(drawn.route, corners).T, "--", color=ROUTE, linewidth=1, label="route", zorder=2)
    if len(points := seen(flight, box, SEEN_IN_SPACE)):
        axes.plot(*unhidden(points, corners).T, **dots(SEEN, 0.8), zorder=2.5)
        axes.plot([], [], **dots(SEEN, 3), label=SIGHTED)
    for each in stepped_in(flight):
        axes.plot(
            *unhidden(each.band(flight.record.position), corners).T, **mark_of(each), zorder=3.5 if each.guards else 2.7
        )
    colors = LinearSegmentedColormap.from_list("error", SCALE)
    scale = ScalarMappable(Normalize(0, max(LEAST_TOP["error"], float(np.nanmax(error)))), colors)
    axes.add_collection(path(flight, scale.to_rgba(error[1:]), corners))
    axes.plot([], [], color=SCALE[0][1], linewidth=2.5, label="flown")
    for label, point, look in ends(flight, drawn):
        axes.plot(*point[:, None], **look, label=label, zorder=4)
    for track in moving:
        axes.plot(*unhidden(track.line, corners).T, ":", color=MOVING, linewidth=1.2, zorder=2)
    special = [(group.name, group.color) for group in groups(drawn) if group.name == ABSENT]
    for name, color in [*special, *([(MOVERS, MOVING)] if moving else [])]:
        axes.plot([], [], "s", color=color, markersize=9, label=name)
    frame(axes, box)
    figure.colorbar(scale, ax=axes, shrink=0.6, pad=0.1, label="cross-track error (m)")
    heading(axes, flight)
    axes.legend(loc="upper left", frameon=False)
    return figure


def dots(color: str, size: float) -> dict[str, Any]:
    """Return the look of points that are not joined, of a size in points."""
    return {"linestyle": "none", "marker": ".", "markeredgewidth": 0, "color": color, "markersize": 2 * size}


def stepped_in(flight: Flight) -> list[Intervention]:
    """Return the avoiders that stepped in anywhere."""
    return [each for each in interventions(flight) if each.rows.any()]


def mark_of(each: Intervention) -> dict[str, Any]:
    """Return the look of where an avoider stepped in: dots on the path for a guard, a band along it for any other."""
    look = dots(each.color, 2.5) if each.guards else {"color": each.color, "linewidth": 8, "alpha": 0.25}
    return look | {"label": f"{each.name} stepped in"}


def path(flight: Flight, colors: Array, corners: Array) -> Line3DCollection:
    """Return the path flown, a line for every step, faint where it is behind the faces (n, 3, 3) m of obstacles."""
    position = flight.record.position
    segments = np.stack([position[:-1], position[1:]], axis=1)
    far = behind(segments.mean(axis=1), corners)
    faint = np.where(far[:, None], colors * [1, 1, 1, HIDDEN], colors)
    return Line3DCollection(segments, colors=faint, linewidth=np.where(far, 1.5, 2.5), capstyle="butt", zorder=3)


def ends(flight: Flight, drawn: Scene) -> list[tuple[str, Array, dict[str, Any]]]:
    """Return name, point (3,) m and look of start, goal, and the end of a flight that did not arrive."""
    white = {"color": "white", "markeredgecolor": INK, "linestyle": "none"}
    found = [
        ("start", flight.record.position[0], white | {"marker": "o"}),
        ("goal", drawn.route[-1], white | {"marker": "s"}),
    ]
    if flight.outcome is not Outcome.ARRIVED:
        position = flight.record.position
        last = position[np.isfinite(position).all(axis=1)][-1]
        found.append(("ended here", last, {"color": ALARM, "marker": "X", "linestyle": "none"}))
    return found


def frame(axes: Any, box: Array) -> None:
    """Fit axes in space to a box (2, 3) m, a metre as long along each."""
    axes.set(xlim=box[:, 0], ylim=box[:, 1], zlim=box[:, 2])
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)", zlabel="z (m)")
    axes.xaxis.labelpad = axes.yaxis.labelpad = 12
    sides = box[1] - box[0]
    axes.set_box_aspect(sides)
    for axis, side in zip((axes.xaxis, axes.yaxis, axes.zaxis), sides, strict=True):
        axis.get_major_locator().set_params(nbins=max(2, round(6 * side / sides.max())))
    axes.zaxis.set_rotate_label(False)
    axes.zaxis.label.set_rotation(90)
    axes.set_proj_type("ortho")
    axes.view_init(elev=ELEVATION, azim=AZIMUTH)


def plan_view(flight: Flight, drawn: Scene) -> Figure:
    """Draw the view from above, with equal axes."""
    box = extent([flight], drawn)
    across, along = (box[1] - box[0])[:2]
    figure = sheet(8, 1.4 + 6.6 * min(1.2, max(0.3, along / across)))
    axes: Any = figure.add_subplot()
    position, record = flight.record.position, flight.record
    axes.plot(*drawn.route[:, :2].T, "--", color=ROUTE, linewidth=1.2, label="route")
    if flight.plan.course.trajectory is not None:
        axes.plot(*drawn.course[:, :2].T, color=PLANNED, linewidth=1.2, label="trajectory")
    if len(again := replanned(flight)):
        axes.plot(*again[:, :2].T, ":", color=PLANNED, linewidth=1.2, label="planned again")
    if len(points := seen(flight, box, SEEN_FROM_ABOVE)):
        axes.plot(*points[:, :2].T, **dots(SEEN, 0.8))
        axes.plot([], [], **dots(SEEN, 3), label=SIGHTED)
    axes.plot(*position[:, :2].T, color=PALETTE[0], linewidth=1.8, label="flown")
    every, chased = max(1, len(record.time) // 60), CHASED[flight.plan.course.trajectory is not None]
    axes.plot(*record.aim[::every, :2].T, ".", color=PALETTE[1], markersize=3, label=chased)
    for each in stepped_in(flight):
        axes.plot(*each.band(position)[:, :2].T, **mark_of(each), zorder=2.5 if each.guards else 1.5)
    for label, point, look in ends(flight, drawn):
        axes.plot(*point[:2, None], **look, label=label)
    for group in groups(drawn):
        image = footprint(group.scene, box, group.footprint).convert("RGBA")
        axes.imshow(image, extent=box[:, :2].T.ravel(), zorder=0.6)
        axes.plot([], [], "s", color=group.footprint, markersize=9, label=group.name)
    for track in tracks([flight], box):
        axes.plot(*track.line[:, :2].T, ":", color=MOVING, linewidth=1.2)
        outline = track.outline(track.met)
        axes.fill(*outline.T, color=MOVING, alpha=0.6, linewidth=0)
        axes.plot([], [], "s", color=MOVING, markersize=9, label=MOVERS if track.first else None)
    axes.set(xlabel="x, east (m)", ylabel="y, north (m)", xlim=box[:, 0], ylim=box[:, 1])
    axes.set_aspect("equal")
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    heading(axes, flight)
    entries = len(axes.get_legend_handles_labels()[1])
    figure.legend(loc="outside lower center", ncols=7 if entries <= 7 else 4, frameon=False)
    return figure


def times(flight: Flight, shown: list[Panel]) -> Figure:
    """Draw all panels under one another over a common time axis."""
    figure = sheet(9, 1 + 1.5 * len(shown))
    rows: Any = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(rows, shown, strict=True):
        for color, series in zip(panel.colors, panel.series, strict=True):
            style = STYLES[series.role]
            width = 5 if panel.names else 1.2
            axes.plot(flight.record.time, series.values, style, color=color, linewidth=width, label=series.label)
        axes.margins(x=0, y=HEADROOM)
        if panel.from_zero:
            axes.set_ylim(bottom=0)
        if (limits := panel.range()) is not None:
            axes.set_ylim(limits)
        if panel.names:
            axes.set_yticks(range(1, len(panel.names) + 1), panel.names)
        axes.set_title(panel.heading, loc="left", fontsize=10)
        axes.grid(color=GRID)
        axes.spines[["top", "right"]].set_visible(False)
        if len(panel.series) > 1 and not panel.names:
            place = {"loc": "lower right", "bbox_to_anchor": (1, 0.98), "borderaxespad": 0.2}
            axes.legend(ncols=len(panel.series), frameon=False, fontsize=9, **place)
    rows[-1].set_xlabel("time (s)")
    figure.suptitle(caption(flight), parse_math=False)
    return figure


def heading(axes: Any, flight: Flight) -> None:
    """Write what the flight is and how it ended above a picture."""
    axes.set_title(caption(flight), parse_math=False)


def caption(flight: Flight) -> str:
    """Return the name of a flight and how it ended."""
    return f"{flight.plan.name}: {flight.outcome.value}"
