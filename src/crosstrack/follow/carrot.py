"""Carrot chasing: fly towards a point of the path a lookahead ahead of the vehicle."""

from dataclasses import dataclass, field

import numpy as np

from crosstrack.follow.bearing import BearingMemory, begin, command, reach_at
from crosstrack.follow.guidance import locate, turn
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import direction, limited


@dataclass(frozen=True)
class CarrotMemory(BearingMemory):
    """What carrot chasing remembers."""

    sine: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) the course error d_⊥ of the last step"""
    sum: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) s, its integral"""


@dataclass(frozen=True)
class Carrot:
    """Chase a carrot on the path in 2-D and 3-D.

    With the closest point C, its unit tangent t and the carrot S = C + δ t, the course asked for is d = unit(S - P).
    On the tangent the carrot does not cut curves, and a path that turns back does not pull it past the vehicle. The
    command is

        v = V(s) d + drift,
        a = V (K d_⊥ + K_I ∫d_⊥ dt + K_D d(d_⊥)/dt) + K2 (C - P) + feed-forward of the path,

    where d_⊥ is the part of d across the course flown, as long as the sine of the angle between them, and drift
    integrates what the velocity flown across the path misses of V d, so that a crosswind leaves no offset:

        d(drift)/dt = g (V d - velocity) across t.

    The acceleration is at most what the vehicle has in that direction, and that of the integral at most half of it.
    Over the last 0.3 m, or half a second, where straight, the last point is the carrot, and a vehicle that can stop is
    asked for that position.

    Sources: Sujit, Saripalli, Sousa 2014 (IEEE Control Systems 34(1), algorithm 1); Bhadani 2020 (arXiv 2012.13227).
    """

    needs = ()

    lookahead: Positive = 1.0
    """m, δ; longer for a vehicle that is slow to respond or, unable to slow down, wide to turn"""
    heading_gain: NonNegative = 0.5
    """1/s, K, acceleration over speed and sine of the course error"""
    heading_integral: NonNegative = 0.0
    """1/s², K_I, acceleration over speed and the integral of the sine of the course error"""
    heading_derivative: NonNegative = 0.0
    """1, K_D, acceleration over speed and the rate of the sine of the course error"""
    cross_track_gain: NonNegative = 0.0
    """1/s², K2, acceleration over cross-track error"""
    drift_gain: NonNegative = 1.0
    """1/s, g, how fast a crosswind is corrected; 0 turns it off"""
    reaction: NonNegative = 4.0
    """1, shortest time to the carrot over the vehicle's response time"""

    def start(self, course: Course, state: State) -> CarrotMemory:
        """Begin at the entry of the course."""
        return CarrotMemory(**vars(begin(course, state)))

    def step(
        self, memory: CarrotMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, CarrotMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        lookahead = reach_at(self.lookahead, self.reaction, foot, state.velocity, course.envelope)
        aim = course.path(course.path.length) if foot.last else foot.point + lookahead * foot.tangent
        asked = direction(aim - state.position)
        most = 0.5 * course.envelope.acceleration / max(foot.speed, 1e-9)
        sine = turn(state.velocity, asked)
        rate, total = self.heading_rate(memory, sine, duration, most)
        return command(
            memory,
            course,
            foot,
            state,
            duration,
            aim=aim,
            asked=asked,
            push=foot.speed * rate + self.cross_track_gain * foot.offset,
            drift_gain=self.drift_gain,
            distance=lookahead,
            sine=sine,
            sum=total,
        )

    def heading_rate(self, memory: CarrotMemory, sine: Array, duration: float, most: float) -> tuple[Array, Array]:
        """Return how fast to turn, (3,) rad/s, for a course error (3,), and the new integral of the error, (3,) s.

        The part of the integral is limited to `most` rad/s.
        """
        rate = self.heading_gain * sine
        total = memory.sum
        if self.heading_integral > 0:
            total = limited(total + duration * sine, most / self.heading_integral)
            rate = rate + self.heading_integral * total
        if self.heading_derivative > 0:
            rate = rate + self.heading_derivative / duration * (sine - memory.sine)
        return rate, total
