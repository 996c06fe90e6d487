"""Carrot chasing: fly towards a point of the path a lookahead ahead of the vehicle."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State

DRIFT_MAX = 5.0
"""of the speed, the most drift that is corrected: a point in a wind of 98 % of its speed needs as much"""
LAST_STRETCH = 0.3
"""m, from the end: there the last point is the carrot, and a vehicle that can stop holds it"""


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

    With the closest point C, the unit tangent t and the carrot S = path(s + δ), the course asked for is

        d = unit(t + unit(S - P) - unit(S - C)),

    which on a straight leg is the direction to the carrot, unit(S - P), and on a curve does not cut it. The command is

        v = V(s) d + drift,      a = K V ∠(v, d) + K2 (C - P) + feed-forward of the path,

    where ∠ turns from the course flown to the course asked for, (-π, π], across the course flown, and drift integrates
    what the velocity flown across the path misses of V d, so that a crosswind leaves no offset:

        d(drift)/dt = g (V d - velocity) across t.

    The acceleration is at most what the vehicle has, in whatever direction.

    Sources: Sujit, Saripalli, Sousa 2014 (IEEE Control Systems 34(1), algorithm 1); Bhadani 2020 (arXiv 2012.13227).
    """

    lookahead: Positive = 1.0
    """m, δ; stretched to `reaction` times the speed where that is more"""
    heading_gain: NonNegative = 0.5
    """1/s, K, acceleration over speed and course error"""
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
        moved = float(np.linalg.norm(state.velocity)) * duration
        s = path.project(state.position, memory.progress, reach_of(memory.error, moved))
        foot, tangent = path(s), path(s, 1)
        offset = foot - state.position
        error = float(np.linalg.norm(offset))
        speed = float(course.speed(s))
        lookahead = max(self.lookahead, self.reaction * envelope.response_time * speed)
        carrot = beyond(course, s + lookahead)
        asked = direction(tangent + direction(carrot - state.position) - direction(carrot - foot))
        last = on_last_stretch(course, s, foot)
        if last:
            carrot = path(path.length)
            asked = direction(carrot - state.position)
        drift = self.drifted(memory, state.velocity, tangent, speed, duration)
        memory = CarrotMemory(s, carrot, drift, error, speed * asked)
        if last and envelope.stops:
            return Setpoint(position=carrot), memory
        across = drift - (drift @ tangent) * tangent
        push = ahead(course, s, state.velocity) + self.heading_gain * speed * turn(state.velocity, asked)
        push = push + self.cross_track_gain * offset
        return Setpoint(velocity=speed * asked + across, acceleration=limited(push, envelope.acceleration)), memory

    def drifted(self, memory: CarrotMemory, velocity: Array, tangent: Array, speed: float, duration: float) -> Array:
        """Return the drift (3,) m/s after integrating how far the velocity flown misses the one asked for."""
        miss = memory.course - velocity
        miss = miss - (miss @ tangent) * tangent
        drift = memory.drift + min(1.0, self.drift_gain * duration) * miss
        return limited(drift, DRIFT_MAX * speed)


def direction(vector: Array) -> Array:
    """Return the unit vector, zero for zero."""
    norm = math.sqrt(vector @ vector)
    return vector / norm if norm > 1e-9 else np.zeros(3)


def on_last_stretch(course: Course, s: float, foot: Array) -> bool:
    """Return whether the way from a point of the path to its end is short and straight."""
    remaining = course.path.length - s
    straight = float(np.linalg.norm(course.path(course.path.length) - foot))
    return remaining < LAST_STRETCH and straight >= 0.9 * remaining


def ahead(course: Course, s: float, velocity: Array) -> Array:
    """Return the mean acceleration (3,) m/s² along the course over the vehicle's response time from arc length `s`."""
    response = course.envelope.response_time
    if response <= 0:
        return np.zeros(3)
    tangent, gain = course.path(s, 1), max(0.0, float(course.speed(s, 1)))
    lead = s + (max(0.0, float(velocity @ tangent)) + 0.5 * gain * response) * response
    return (course.speed(lead) * course.path(lead, 1) - course.speed(s) * tangent) / response


def limited(vector: Array, most: float) -> Array:
    """Return the vector, shortened to the length `most` where it is longer."""
    norm = math.sqrt(vector @ vector)
    return vector * (most / norm) if norm > most else vector


def beyond(course: Course, s: float) -> Array:
    """Return the point of the path at arc length `s`, on its last tangent past the end."""
    path = course.path
    return path(s) + max(0.0, s - path.length) * path(path.length, 1)


def turn(velocity: Array, asked: Array) -> Array:
    """Return the angle (rad) from the course flown to the course asked for, across the course flown.

    Opposite courses turn left in the horizontal plane; a vehicle at rest has no course and turns nowhere.
    """
    flown = direction(velocity)
    if not flown.any():
        return flown
    across = asked - (asked @ flown) * flown
    sine = math.sqrt(across @ across)
    if sine > 1e-9:
        return math.atan2(sine, float(asked @ flown)) / sine * across
    if asked @ flown < 0:
        return math.pi * direction(np.array([-flown[1], flown[0], 0.0]))
    return np.zeros(3)
