"""What every law of guidance shares: where it is on its course, and how what it asks for becomes a command."""

from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course, Path
from crosstrack.types import Array, Envelope, State
from crosstrack.vectors import across, direction, dot, limited, norm

LAST_STRETCH = 0.3
"""m, from the end: there a vehicle that can stop is asked to hold the last point"""
LAST_SECONDS = 0.5
"""s, from the end, likewise: a vehicle that holds a position must not get there faster than it may fly"""
STRAIGHT = 0.98
"""least chord over arc length of a way that counts as straight"""
LATE = 0.5
"""of the speed asked for, flown along the course, under which there is no feed-forward against the course"""


@dataclass(frozen=True)
class GuidanceMemory:
    """What every law of guidance remembers."""

    progress: float
    """m, arc length of the closest point of the course"""
    aim: Array
    """(3,) m, the point flown to"""
    error: float
    """m, distance to the closest point"""


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


def locate(memory: GuidanceMemory, course: Course, state: State, duration: float) -> Foot:
    """Return the closest point of the course, at or after the one remembered `duration` (s) ago."""
    path = course.path
    moved = norm(state.velocity) * duration
    s = path.project(state.position, memory.progress, reach_of(memory.error, moved))
    point, tangent, speed = path(s), path(s, 1), float(course.speed(s))
    offset = point - state.position
    return Foot(s, point, tangent, speed, offset, norm(offset), on_last_stretch(path, s, point, speed))


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
    closing = dot(velocity, tangent)
    lead = s + (max(0.0, closing) + 0.5 * gain * response) * response
    return gained(float(course.speed(s)), tangent, float(course.speed(lead)), course.path(lead, 1), response, closing)


@compiled
def gained(speed: float, tangent: Array, later: float, along: Array, time: float, closing: float) -> Array:
    """Return the acceleration (3,) m/s² from a speed along a tangent to a later one, see `ahead`."""
    push = np.empty(3)
    for k in range(3):
        push[k] = (later * along[k] - speed * tangent[k]) / time
    return across(push, tangent) if closing < LATE * speed and dot(push, tangent) < 0 else push


def affordable(push: Array, envelope: Envelope) -> Array:
    """Return an acceleration (3,) m/s², its vertical part and then all of it shortened to what the vehicle has.

    More lift than there is would leave no thrust to brake or turn with.
    """
    return cut(push, envelope.acceleration_vertical, envelope.acceleration)


@compiled
def cut(push: Array, upwards: float, most: float) -> Array:
    """Return an acceleration (3,), its vertical part at most `upwards`, all of it at most `most`, see `affordable`."""
    level = push.copy()
    level[2] = min(upwards, max(-upwards, push[2]))
    return limited(level, most)


@compiled
def turn(velocity: Array, asked: Array) -> Array:
    """Return the part of the unit vector `asked` that lies across the course flown; zero for a vehicle at rest."""
    flown = direction(velocity)
    return across(asked, flown) if norm(flown) > 0 else flown
