"""Nonlinear guidance of Park, Deyst and How: turn towards the point where the path leaves a circle."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.follow.guidance import Foot, locate
from crosstrack.follow.lateral import FOLD, LateralMemory, begin, command, lookahead_at, turning
from crosstrack.protocols import Course, Path
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import direction

WAYS = np.linspace(0.0, 2.0, 33)
"""of the radius of the circle: arc lengths ahead at which the path is looked at"""
INDICES = np.arange(len(WAYS))


@dataclass(frozen=True)
class Nlgl:
    """Fly the arc of a circle that meets the path a distance L1 ahead.

    With the point A where the path leaves the sphere of radius L1 about the vehicle, and the angle η from the velocity
    to it, the acceleration is

        a = 2 V² / L1 sin η,

    across the velocity V, in the plane of velocity and A: the circle that is tangent to the velocity and leads through
    A. On a straight path it is linear in the cross-track error, with ω = √2 V / L1 and a damping of 1/√2; on a circular
    path it asks for V² / r, whatever L1.

    L1 is the way that the speed profile makes in `reaction` times the response time τ of the vehicle, so that it is
    short before slow corners. A vehicle that answers as a lag of first order is stable above 1; at 4, vehicle and law
    are a Butterworth filter of third order, and cut corners. Where the path turns back or ends within L1, the aim is on
    its tangent.

    Source: Park, Deyst, How 2004 (AIAA 2004-4900, equation 1), 2007 (JGCD 30(6)); the rule for L1 is ours.
    """

    needs = ()

    lookahead: Positive = 0.15
    """m, least L1"""
    reaction: NonNegative = 2.0
    """1, time to the aim over the vehicle's response time"""

    def start(self, course: Course, state: State) -> LateralMemory:
        """Begin at the entry of the course."""
        return begin(course, state)

    def step(
        self, memory: LateralMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, LateralMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        radius = lookahead_at(self.lookahead, self.reaction, course, foot, state.velocity, duration)
        aim = exit_of(course.path, foot, state.position, radius)
        chord = aim - state.position
        square = float(state.velocity @ state.velocity)
        distance = max(math.sqrt(chord @ chord), self.lookahead)
        push = 2 * square / distance * turning(state.velocity, direction(chord))
        return command(memory, course, foot, state, duration, aim, push)


def exit_of(path: Path, foot: Foot, position: Array, radius: float) -> Array:
    """Return the point (3,) m where a path leaves a sphere about a position.

    Where the path ends or turns back before, the point is on its tangent there. A path that curls up within the sphere
    is met at its farthest point.
    """
    if foot.last:
        return path(path.length)
    s = foot.s + radius * WAYS
    points, tangents = path(s), path(s, 1)
    place, inside = leaving(points, tangents, position, radius)
    if not inside:
        return path(float(np.interp(place, INDICES, s)))
    k = int(place)
    if k < len(s) - 1 and s[k + 1] <= path.length and not folds(tangents, k):
        return np.asarray(points[k])
    return beyond(points[k], tangents[k], position, radius)


@compiled
def folds(tangents: Array, k: int) -> bool:
    """Return whether a path turns back between the samples k and k + 1."""
    a, b = tangents[k], tangents[k + 1]
    return bool(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < FOLD)


@compiled
def leaving(points: Array, tangents: Array, position: Array, radius: float) -> tuple[float, bool]:
    """Return at which of the samples (n, 3) of a path, between two by a fraction, it leaves a sphere.

    Returns:
        the place, and whether the path stays inside until it turns back or the samples end: then it is the farthest
    """
    before, farthest, most = 0.0, 0, -1.0
    for k in range(points.shape[0]):
        if k > 0 and folds(tangents, k - 1):
            break
        x, y, z = points[k, 0] - position[0], points[k, 1] - position[1], points[k, 2] - position[2]
        distance = math.sqrt(x * x + y * y + z * z)
        if distance >= radius:
            return (k - 1 + (radius - before) / (distance - before), False) if k > 0 else (0.0, False)
        if distance >= most:
            farthest, most = k, distance
        before = distance
    return float(farthest), True


def beyond(point: Array, tangent: Array, position: Array, radius: float) -> Array:
    """Return where the ray from a point along a unit tangent leaves the sphere about a position."""
    offset = point - position
    along = float(offset @ tangent)
    return point + (math.sqrt(max(0.0, along**2 + radius**2 - float(offset @ offset))) - along) * tangent
