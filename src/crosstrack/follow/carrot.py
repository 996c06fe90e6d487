"""Carrot chasing: fly towards a point of the path a lookahead ahead of the vehicle."""

from dataclasses import dataclass

import numpy as np

from crosstrack.follow.guidance import across, ahead, direction, limited, locate, turn
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope, NonNegative, Positive, Setpoint, State

DRIFT_MAX = 5.0
"""of the speed, the most drift that is corrected: a point in a wind of 98 % of its speed needs as much"""
DRIFT_PACE = 0.3
"""of the time to the carrot, the fastest that drift is integrated, so that a slow turn does not count as drift"""


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

    needs = ()

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
        foot = locate(memory, course, state, duration)
        speed, tangent = foot.speed, foot.tangent
        lookahead = self.lookahead_at(speed, course.envelope)
        aim = course.path(course.path.length) if foot.last else foot.point + lookahead * tangent
        asked = direction(aim - state.position)
        pace = min(self.drift_gain, DRIFT_PACE * speed / lookahead)
        drift = drifted(memory, state.velocity, tangent, min(1.0, pace * duration), DRIFT_MAX * speed)
        memory = CarrotMemory(foot.s, aim, drift, foot.error, speed * asked)
        if foot.last and course.envelope.stops:
            return Setpoint(position=aim), memory
        push = ahead(course, foot.s, tangent, state.velocity) + self.cross_track_gain * foot.offset
        push = push + self.heading_gain * speed * turn(state.velocity, asked)
        return Setpoint(
            velocity=speed * asked + across(drift, tangent), acceleration=limited(push, course.envelope.acceleration)
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
