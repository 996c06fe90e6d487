"""What every law of guidance shares: where it is on its course, and how what it asks for becomes a command."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course, Memory, Path
from crosstrack.types import Array, Envelope, State

LAST_STRETCH = 0.3
"""m, from the end: there a vehicle that can stop is asked to hold the last point"""
LAST_SECONDS = 0.5
"""s, from the end, likewise: a vehicle that holds a position must not get there faster than it may fly"""
STRAIGHT = 0.98
"""least chord over arc length of a way that counts as straight"""

LATE = 0.5
"""of the speed asked for, flown along the course, under which there is no feed-forward against the course"""


class Locating(Memory, Protocol):
    """What is remembered to find the closest point again."""

    @property
    def error(self) -> float:
        """m, cross-track error"""


@dataclass(frozen=True)
class Foot:
    """The point of the course closest to the vehicle: all that a law of guidance sees."""

    s: float
    """m, arc length"""
    point: Array
    """(3,) m"""
    tangent: Array
    """(3,) unit"""
    speed: float
    """m/s, asked for there"""
    offset: Array
    """(3,) m, from the vehicle to the point"""
    error: float
    """m, cross-track error, the length of the offset"""
    last: bool
    """whether what remains of the course is short and straight"""


def locate(memory: Locating, course: Course, state: State, duration: float) -> Foot:
    """Return the closest point of the course, at or after the one remembered `duration` (s) ago."""
    path = course.path
    moved = math.sqrt(state.velocity @ state.velocity) * duration
    s = path.project(state.position, memory.progress, reach_of(memory.error, moved))
    point, tangent, speed = path(s), path(s, 1), float(course.speed(s))
    offset = point - state.position
    error = math.sqrt(offset @ offset)
    return Foot(s, point, tangent, speed, offset, error, on_last_stretch(path, s, point, speed))


def on_last_stretch(path: Path, s: float, foot: Array, speed: float) -> bool:
    """Return whether the way from a point of the path, the foot at arc length `s`, to its end is short and straight."""
    remaining = path.length - s
    if remaining > min(LAST_STRETCH, LAST_SECONDS * speed):
        return False
    return float(np.linalg.norm(path(path.length) - foot)) >= STRAIGHT * remaining


def ahead(course: Course, s: float, tangent: Array, velocity: Array) -> Array:
    """Return the mean acceleration (3,) m/s² along the course over the vehicle's response time.

    A vehicle that already flies slower than LATE of the speed of the course is not asked to brake: before a turn on the
    spot the braking would else hold off the velocity asked for, and the vehicle would hover there.

    Args:
        course: what is followed
        s: m, arc length of the closest point
        tangent: (3,) there
        velocity: (3,) m/s, flown
    """
    response = course.envelope.response_time
    if response <= 0:
        return np.zeros(3)
    gain = max(0.0, float(course.speed(s, 1)))
    lead = s + (max(0.0, float(velocity @ tangent)) + 0.5 * gain * response) * response
    push = (course.speed(lead) * course.path(lead, 1) - course.speed(s) * tangent) / response
    along = float(push @ tangent)
    slow = float(velocity @ tangent) < LATE * course.speed(s)
    return push - along * tangent if slow and along < 0 else push


def across(vector: Array, along: Array) -> Array:
    """Return the part of a vector that is perpendicular to a unit vector."""
    return vector - (vector @ along) * along


def direction(vector: Array) -> Array:
    """Return the unit vector, zero for zero."""
    norm = math.sqrt(vector @ vector)
    return vector / norm if norm > 1e-9 else np.zeros(3)


def limited(vector: Array, most: float) -> Array:
    """Return the vector, shortened to the length `most` where it is longer."""
    norm = math.sqrt(vector @ vector)
    return vector * (most / norm) if norm > most else vector


def affordable(push: Array, envelope: Envelope) -> Array:
    """Return an acceleration (3,) m/s², its vertical part and then all of it shortened to what the vehicle has.

    More lift than there is would leave no thrust to brake or turn with.
    """
    most = envelope.acceleration_vertical
    if abs(push[2]) > most:
        push = np.array([push[0], push[1], math.copysign(most, push[2])])
    return limited(push, envelope.acceleration)


def turn(velocity: Array, asked: Array) -> Array:
    """Return the part of the unit vector `asked` that lies across the course flown; zero for a vehicle at rest."""
    flown = direction(velocity)
    return across(asked, flown) if flown.any() else flown
