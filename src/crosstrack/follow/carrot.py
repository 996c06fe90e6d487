"""Carrot chasing: fly towards a point of the path a lookahead ahead of the vehicle."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course, Path
from crosstrack.types import Array, Envelope, NonNegative, Positive, Setpoint, State

DRIFT_MAX = 5.0
"""of the speed, the most drift that is corrected: a point in a wind of 98 % of its speed needs as much"""
DRIFT_PACE = 0.3
"""of the time to the carrot, the fastest that drift is integrated, so that a slow turn does not count as drift"""
LAST_STRETCH = 0.3
"""m, from the end: there the last point is the carrot, and a vehicle that can stop holds it"""
LAST_SECONDS = 0.5
"""s, from the end, likewise: a vehicle that holds a position must not get there faster than it may fly"""
STRAIGHT = 0.98
"""least chord over arc length of a way that counts as straight"""


@dataclass(frozen=True)
class CarrotMemory:
    """What carrot chasing remembers."""

    progress: float
    """m, arc length of the closest point"""
    aim: Array
    """(3,) m, the carrot"""
    drift: Array
    """(3,) m/s, velocity added across the path against the wind"""
    error: float
    """m, cross-track error"""
    course: Array
    """(3,) m/s, velocity asked for in the last step, without drift"""


@dataclass(frozen=True)
class Carrot:
    """Chase a carrot on the path in 2-D and 3-D.

    With the closest point C, its unit tangent t and the carrot S = C + δ t, the course asked for is d = unit(S - P).
    On the tangent the carrot does not cut curves, and a path that turns back does not pull it past the vehicle. The
    command is

        v = V(s) d + drift,      a = K V d_⊥ + K2 (C - P) + feed-forward of the path,

    where d_⊥ is the part of d across the course flown, as long as the sine of the angle between them, and drift
    integrates what the velocity flown across the path misses of V d, so that a crosswind leaves no offset:

        d(drift)/dt = g (V d - velocity) across t.

    The acceleration is at most what the vehicle has, in whatever direction. Over the last 0.3 m, or half a second,
    where straight, the last point is the carrot, and a vehicle that can stop is asked for that position.

    Sources: Sujit, Saripalli, Sousa 2014 (IEEE Control Systems 34(1), algorithm 1); Bhadani 2020 (arXiv 2012.13227).
    """

    lookahead: Positive = 1.0
    """m, δ; longer for a vehicle that is slow to respond or, unable to slow down, wide to turn"""
    heading_gain: NonNegative = 0.5
    """1/s, K, acceleration over speed and sine of the course error"""
    cross_track_gain: NonNegative = 0.0
    """1/s², K2, acceleration over cross-track error"""
    drift_gain: NonNegative = 1.0
    """1/s, g, how fast a crosswind is corrected; 0 turns it off"""
    reaction: NonNegative = 4.0
    """1, shortest time to the carrot over the vehicle's response time"""

    def start(self, course: Course, state: State) -> CarrotMemory:
        """Begin at the entry of the course."""
        foot = course.path(course.entry)
        error = float(np.linalg.norm(foot - state.position))
        return CarrotMemory(course.entry, foot, np.zeros(3), error, state.velocity)

    def step(
        self, memory: CarrotMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, CarrotMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        path, envelope = course.path, course.envelope
        moved = math.sqrt(state.velocity @ state.velocity) * duration
        s = path.project(state.position, memory.progress, reach_of(memory.error, moved))
        foot, tangent, speed = path(s), path(s, 1), float(course.speed(s))
        offset = foot - state.position
        lookahead = self.lookahead_at(speed, envelope)
        aim = foot + lookahead * tangent
        last = on_last_stretch(path, s, foot, speed)
        if last:
            aim = path(path.length)
        asked = direction(aim - state.position)
        pace = min(self.drift_gain, DRIFT_PACE * speed / lookahead)
        drift = drifted(memory, state.velocity, tangent, min(1.0, pace * duration), DRIFT_MAX * speed)
        memory = CarrotMemory(s, aim, drift, math.sqrt(offset @ offset), speed * asked)
        if last and envelope.stops:
            return Setpoint(position=aim), memory
        push = ahead(course, s, tangent, state.velocity) + self.cross_track_gain * offset
        push = push + self.heading_gain * speed * turn(state.velocity, asked)
        return Setpoint(
            velocity=speed * asked + across(drift, tangent), acceleration=limited(push, envelope.acceleration)
        ), memory

    def lookahead_at(self, speed: float, envelope: Envelope) -> float:
        """Return the lookahead (m) at a speed (m/s): a vehicle that cannot slow down looks a turning radius ahead."""
        radius = 0.0 if envelope.stops else speed**2 / envelope.acceleration
        return max(self.lookahead, self.reaction * envelope.response_time * speed, radius)


def drifted(memory: CarrotMemory, velocity: Array, tangent: Array, share: float, most: float) -> Array:
    """Return the drift (3,) m/s after adding a share of what the velocity flown misses of the one asked for.

    Nothing is added while the vehicle flies against its course, still turning; and it is `most` m/s at most.
    """
    if velocity @ memory.course <= 0:
        return memory.drift
    return limited(memory.drift + share * across(memory.course - velocity, tangent), most)


def across(vector: Array, along: Array) -> Array:
    """Return the part of a vector that is perpendicular to a unit vector."""
    return vector - (vector @ along) * along


def direction(vector: Array) -> Array:
    """Return the unit vector, zero for zero."""
    norm = math.sqrt(vector @ vector)
    return vector / norm if norm > 1e-9 else np.zeros(3)


def on_last_stretch(path: Path, s: float, foot: Array, speed: float) -> bool:
    """Return whether the way from a point of the path, the foot at arc length `s`, to its end is short and straight."""
    remaining = path.length - s
    if remaining > min(LAST_STRETCH, LAST_SECONDS * speed):
        return False
    return float(np.linalg.norm(path(path.length) - foot)) >= STRAIGHT * remaining


def ahead(course: Course, s: float, tangent: Array, velocity: Array) -> Array:
    """Return the mean acceleration (3,) m/s² along the course over the vehicle's response time.

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
    return (course.speed(lead) * course.path(lead, 1) - course.speed(s) * tangent) / response


def limited(vector: Array, most: float) -> Array:
    """Return the vector, shortened to the length `most` where it is longer."""
    norm = math.sqrt(vector @ vector)
    return vector * (most / norm) if norm > most else vector


def turn(velocity: Array, asked: Array) -> Array:
    """Return the part of the unit vector `asked` that lies across the course flown; zero for a vehicle at rest."""
    flown = direction(velocity)
    return across(asked, flown) if flown.any() else flown
