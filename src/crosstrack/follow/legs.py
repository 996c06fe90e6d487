"""What laws that fly from waypoint to waypoint share: the legs, one speed for all of them, and holding the end."""

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from crosstrack.follow.guidance import GuidanceMemory
from crosstrack.path.polyline import SHORTEST, Polyline
from crosstrack.protocols import Course
from crosstrack.types import Array, Setpoint, State
from crosstrack.vectors import direction

SPACING, MOST = 0.05, 20_000
"""m, at which the speed profile is searched for its top, at so many places at most"""


@dataclass(frozen=True)
class LegsMemory(GuidanceMemory):
    """What flying from waypoint to waypoint remembers."""

    legs: Array
    """(n, 3) m, where the vehicle began, and the waypoints from there on"""
    speed: float
    """m/s, the one speed"""
    done: bool
    """whether the end is held"""


M = TypeVar("M", bound=LegsMemory)


def legs_from(course: Course, position: Array) -> Array:
    """Return where the vehicle is and the waypoints after the entry of the course, (n, 3) m, none twice in a row."""
    corners = course.corners
    if len(corners) < 2:
        corners = np.stack([course.path(0.0), course.path(course.path.length)])
    route = Polyline(corners)
    entry = route.project(course.path(course.entry), 0.0, route.length) if course.entry > 0 else 0.0
    ahead = route.points[1:][route.knots[1:] > entry + SHORTEST]
    first = route.points[:1] if entry == 0 else ahead[:0]
    points = np.vstack([position, first, ahead])
    return apart(points)


def apart(points: Array) -> Array:
    """Return points (n, 3) m without those that repeat the one before."""
    keep = np.append(True, np.linalg.norm(np.diff(points, axis=0), axis=1) > SHORTEST)
    return np.asarray(points[keep])


def top_speed(course: Course) -> float:
    """Return the greatest speed (m/s) of the profile of a course."""
    count = min(MOST, 2 + math.ceil(course.path.length / SPACING))
    return float(course.speed(np.linspace(0.0, course.path.length, count)).max())


def held(memory: M, course: Course, state: State) -> tuple[Setpoint, M]:
    """Return the setpoint that holds the end of the course, which one that cannot stop flies to, and the new memory."""
    end = course.path(course.path.length)
    memory = replace(memory, progress=course.path.length, aim=end, done=True)
    if course.envelope.stops:
        return Setpoint(position=end), memory
    return Setpoint(velocity=memory.speed * direction(end - state.position)), memory
