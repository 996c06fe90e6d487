"""Calls that draw into the scene."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.scene.markers import FOREVER, LASTING, Marker, Trace
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array

Color = tuple[float, float, float, float]
Singles = NDArray[np.float32]
AXES: Color = (1.0, 1.0, 1.0, 1.0)
"""stands for red, green and blue of the axes of transforms"""
ROOM = 100_000
"""points, or characters, of one call"""


def color(rgba: Singles) -> Color:
    """Return a colour.

    Raises:
        Refused: it is not four finite numbers.
    """
    if len(rgba) != 4 or not np.isfinite(rgba).all():
        raise Refused(f"a colour of {len(rgba)} numbers; four finite ones are needed: red, green, blue, opacity")
    red, green, blue, opacity = (float(part) for part in rgba)
    return red, green, blue, opacity


def until(now: int, duration: float, persistent: bool) -> int:
    """Return when (ns) a marker ends: never where it is persistent, after 1 s where it has no duration."""
    if persistent:
        return FOREVER
    seconds = duration if duration > 0.0 else LASTING
    return now + round(min(seconds, 1e9) * 1e9) if math.isfinite(seconds) else FOREVER


def draw(
    simulator: Simulator,
    kind: str,
    points: Array,
    rgba: Color,
    size: float,
    ends: int,
    texts: tuple[str, ...] = (),
    orientations: Array | None = None,
) -> None:
    """Keep a marker.

    Raises:
        Refused: it has too many points or letters, or points that are not finite.
    """
    if len(points) == 0:
        return
    if len(points) > ROOM or sum(map(len, texts)) > ROOM:
        raise Refused(
            f"{len(points)} points with {sum(map(len, texts))} letters; at most {ROOM} each are drawn at once"
        )
    if not np.isfinite(points).all() or not math.isfinite(size):
        raise Refused("a marker has points, or a size, that are not finite")
    simulator.scene.markers.add(Marker(kind, points, rgba, size, simulator.now, ends, texts, orientations))


def points(simulator: Simulator, at: Array, rgba: Singles, size: float, duration: float, persistent: bool) -> None:
    """Draw points."""
    draw(simulator, "points", at, color(rgba), size, until(simulator.now, duration, persistent))


def line_strip(
    simulator: Simulator, along: Array, rgba: Singles, thickness: float, duration: float, persistent: bool
) -> None:
    """Draw a line from each point to the next."""
    ends = until(simulator.now, duration, persistent)
    draw(simulator, "lines", np.repeat(along, 2, axis=0)[1:-1], color(rgba), thickness, ends)


def line_list(
    simulator: Simulator, pairs: Array, rgba: Singles, thickness: float, duration: float, persistent: bool
) -> None:
    """Draw a line between each two points; an odd last one is left out, as in AirSim."""
    ends = until(simulator.now, duration, persistent)
    draw(simulator, "lines", pairs[: len(pairs) // 2 * 2], color(rgba), thickness, ends)


def arrows(
    simulator: Simulator,
    starts: Array,
    tips: Array,
    rgba: Singles,
    thickness: float,
    head: float,
    duration: float,
    persistent: bool,
) -> None:
    """Draw arrows."""
    if len(starts) != len(tips):
        raise Refused(f"{len(starts)} starts and {len(tips)} ends of arrows; there must be as many of each")
    both = np.stack([starts, tips], axis=1).reshape(-1, 3)
    draw(simulator, "arrows", both, color(rgba), thickness, until(simulator.now, duration, persistent))


def strings(simulator: Simulator, texts: list[str], at: Array, scale: float, rgba: Singles, duration: float) -> None:
    """Write texts."""
    if len(texts) != len(at):
        raise Refused(f"{len(texts)} texts and {len(at)} positions; there must be as many of each")
    draw(simulator, "strings", at, color(rgba), scale, until(simulator.now, duration, False), tuple(texts))


def transforms(
    simulator: Simulator, poses: list[Pose], scale: float, thickness: float, duration: float, persistent: bool
) -> None:
    """Draw the axes of poses."""
    ends = until(simulator.now, duration, persistent)
    draw(simulator, "transforms", *placed(poses, scale), ends, (), turned(poses))


def named_transforms(
    simulator: Simulator,
    poses: list[Pose],
    names: list[str],
    scale: float,
    thickness: float,
    letters: float,
    rgba: Singles,
    duration: float,
) -> None:
    """Draw the axes of poses, and write their names beside them."""
    if len(poses) != len(names):
        raise Refused(f"{len(poses)} poses and {len(names)} names; there must be as many of each")
    at = np.array([pose.position for pose in poses]).reshape(-1, 3)
    ends = until(simulator.now, duration, False)
    draw(simulator, "transforms", at, color(rgba), scale, ends, tuple(names), turned(poses))


def placed(poses: list[Pose], scale: float) -> tuple[Array, Color, float]:
    """Return points, colour and size of the axes of poses."""
    return np.array([pose.position for pose in poses]).reshape(-1, 3), AXES, scale


def turned(poses: list[Pose]) -> Array:
    """Return the quaternions (n, 4) xyzw of poses."""
    return np.array([pose.orientation for pose in poses]).reshape(-1, 4)


def flush(simulator: Simulator) -> None:
    """End all that is drawn, texts excepted."""
    simulator.scene.markers.flush(simulator.now)


def trace_line(simulator: Simulator, rgba: Singles, thickness: float, vehicle_name: str) -> None:
    """Draw the way of a vehicle in a colour."""
    vehicle = simulator.pawn(vehicle_name)
    simulator.scene.markers.traces[vehicle.name] = Trace(color(rgba), thickness)


HANDLERS = {
    "simPlotPoints": points,
    "simPlotLineStrip": line_strip,
    "simPlotLineList": line_list,
    "simPlotArrows": arrows,
    "simPlotStrings": strings,
    "simPlotTransforms": transforms,
    "simPlotTransformsWithNames": named_transforms,
    "simFlushPersistentMarkers": flush,
    "simSetTraceLine": trace_line,
}
