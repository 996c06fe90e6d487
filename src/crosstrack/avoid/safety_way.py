"""Whether a way to rest is free: swept against what stands, what moves, the ground, the bounds, and what is seen."""

import math
from typing import NamedTuple

import numpy as np

from crosstrack.avoid.safety_stopping import Stop
from crosstrack.compiled import compiled
from crosstrack.protocols import Map, Surroundings
from crosstrack.types import Array, Others
from crosstrack.vectors import dot

STEEPEST = 2.0
"""m of distance per m, more than any map's distance changes"""
CREEP = 0.01
"""m, the least step towards the place where a way comes too close"""
MOST_STEPS = 400
ROUNDING = 1e-4
"""m, by which a way may come closer than it began, where it began too close"""


class Block(NamedTuple):
    """What is in the way, as a half-space that the vehicle is to stay in."""

    normal: Array
    """(3,) unit vector, away from what is in the way"""
    room: float
    """m, how far the vehicle may move against the normal"""
    approach: float
    """m/s, how fast what is in the way moves along the normal"""


class Room(NamedTuple):
    """What a way must keep within."""

    here: Array
    """(3,) m, where the vehicle is"""
    distance: float
    """m, from there to what stands"""
    needed: float
    """m, the least distance from obstacles to keep, or to regain"""
    seen: float
    """m, the longest way that is known to be free or not; inf without sensors"""
    planes: Array
    """(n, 4) of ground and bounds: unit normal n inwards and c of n·x >= c"""


def planes_of(obstacles: Map, margin: float) -> Array:
    """Return ground and bounds as planes (n, 4): normal inwards and offset; walls and ceiling a margin (m) within."""
    rows = [(0.0, 0.0, 1.0, obstacles.ground)]
    if obstacles.bounds is not None:
        for k in range(3):
            unit = np.eye(3)[k]
            rows.append((*unit, obstacles.bounds[0, k] + (margin if k < 2 else 0.0)))
            rows.append((*-unit, margin - obstacles.bounds[1, k]))
    return np.array([row for row in rows if math.isfinite(row[3])]).reshape(-1, 4)


def first_block(way: Stop, around: Surroundings, room: Room) -> Block | None:
    """Return what a way to rest runs into; None where it is free."""
    if not way.rests or way.length > room.seen:
        ahead = heading(way)
        return Block(-ahead, room.seen, 0.0)
    row = outside(way.points, room.planes, ROUNDING)
    if row >= 0:
        plane = room.planes[row]
        return Block(plane[:3], dot(plane[:3], room.here) - plane[3], 0.0)
    if around.others.radius.size:
        which = met(way.points, way.times, *balls(around.others), room.needed)
        if which >= 0:
            return beside(around.others, which, room)
    if room.distance - way.length > room.needed:
        return None
    return standing(way, around.obstacles, room)


def balls(others: Others) -> tuple[Array, Array, Array]:
    """Return place, velocity and size of what moves."""
    return others.position, others.velocity, others.radius


def heading(way: Stop) -> Array:
    """Return the unit vector from the beginning of a way to its end."""
    along = way.points[-1] - way.points[0]
    return np.asarray(along / max(1e-9, float(np.linalg.norm(along))))


def beside(others: Others, which: int, room: Room) -> Block:
    """Return the half-space between the vehicle and something that moves."""
    apart = room.here - others.position[which]
    distance = max(1e-9, float(np.linalg.norm(apart)))
    normal = apart / distance
    return Block(normal, distance - float(others.radius[which]) - room.needed, dot(normal, others.velocity[which]))


def standing(way: Stop, obstacles: Map, room: Room) -> Block | None:
    """Return the obstacle that a way comes too close to: its tangent plane where the way gets there."""
    needed = min(room.needed, room.distance - ROUNDING)
    points = way.points
    lengths = np.sqrt(((points[1:] - points[:-1]) ** 2).sum(axis=1))
    distances = obstacles.distance(points)
    doubtful = distances[1:] + distances[:-1] < 2.0 * needed + STEEPEST * lengths
    for k in np.flatnonzero(doubtful):
        if obstacles.swept(points[k], points[k + 1]) < needed:
            place, distance = reached(obstacles, points[k], points[k + 1], needed)
            normal = obstacles.gradient(place)
            if not normal.any():
                normal = -heading(way)
            normal = normal / float(np.linalg.norm(normal))
            return Block(normal, dot(normal, room.here - place) + distance - room.needed, 0.0)
    return None


def reached(obstacles: Map, start: Array, end: Array, needed: float) -> tuple[Array, float]:
    """Return the first point of a segment closer than `needed` (m) to an obstacle, all but exactly, and its distance.

    Steps are as long as the distance allows, so that the point is on the near side of the thinnest wall.
    """
    along = end - start
    length = float(np.linalg.norm(along))
    s, place, distance = 0.0, start, math.inf
    for _ in range(MOST_STEPS):
        distance = float(obstacles.distance(place))
        if distance <= needed + CREEP or s >= length:
            break
        s = min(length, s + max(CREEP, distance - needed))
        place = start + along * (s / length)
    return place, distance


def least_clearance(way: Stop, around: Surroundings, room: Room) -> float:
    """Return the least distance (m) along a way to what stands or moves, or beyond ground and bounds."""
    ends = zip(way.points[:-1], way.points[1:], strict=True)
    least = min(around.obstacles.swept(start, end) for start, end in ends)
    apart = [met_by(way.points, way.times, *ball) for ball in zip(*balls(around.others), strict=True)]
    # At a plane there is as much room left as at the least distance from an obstacle: none.
    within = [room.needed + least_height(way.points, plane) for plane in room.planes]
    return float(min([least, *apart, *within]))


@compiled
def outside(points: Array, planes: Array, rounding: float) -> int:
    """Return the first plane that a way crosses, -1 for none; one crossed already may not be left farther behind."""
    for i in range(planes.shape[0]):
        first = dot(points[0], planes[i]) - planes[i, 3]
        if least_height(points, planes[i]) < min(0.0, first) - rounding:
            return i
    return -1


@compiled
def least_height(points: Array, plane: Array) -> float:
    """Return the least height (m) of a way over a plane (4,)."""
    least = math.inf
    for k in range(points.shape[0]):
        least = min(least, dot(points[k], plane) - plane[3])
    return least


@compiled
def met(points: Array, times: Array, position: Array, velocity: Array, radius: Array, needed: float) -> int:
    """Return the ball that a way comes closest to, if closer than `needed` (m) and than now; -1 for none."""
    found, worst = -1, 0.0
    for i in range(radius.shape[0]):
        x, y, z = points[0, 0] - position[i, 0], points[0, 1] - position[i, 1], points[0, 2] - position[i, 2]
        now = math.sqrt(x * x + y * y + z * z) - radius[i]
        short = met_by(points, times, position[i], velocity[i], radius[i]) - min(needed, now - ROUNDING)
        if short < worst:
            found, worst = i, short
    return found


@compiled
def met_by(points: Array, times: Array, position: Array, velocity: Array, radius: float) -> float:
    """Return the least distance (m) along a way to a ball that keeps its velocity: straight between two points."""
    least = math.inf
    rx = ry = rz = 0.0
    for k in range(points.shape[0]):
        x = points[k, 0] - position[0] - velocity[0] * times[k]
        y = points[k, 1] - position[1] - velocity[1] * times[k]
        z = points[k, 2] - position[2] - velocity[2] * times[k]
        dx, dy, dz = (x - rx, y - ry, z - rz) if k > 0 else (0.0, 0.0, 0.0)
        square = dx * dx + dy * dy + dz * dz
        part = (x * dx + y * dy + z * dz) / square if square > 0.0 else 0.0
        part = min(1.0, max(0.0, part))
        x_near, y_near, z_near = x - part * dx, y - part * dy, z - part * dz
        least = min(least, math.sqrt(x_near * x_near + y_near * y_near + z_near * z_near))
        rx, ry, rz = x, y, z
    return least - radius
