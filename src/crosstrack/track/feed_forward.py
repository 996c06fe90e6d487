"""Fly a trajectory by the clock: position, velocity and acceleration, sent ahead of the vehicle's response."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.protocols import Course
from crosstrack.track.clock import Clock, begin, tick
from crosstrack.track.reference import motion
from crosstrack.types import NonNegative, Setpoint, State


@dataclass(frozen=True)
class FeedForward:
    """Follow a trajectory by the clock.

    A command is held for the period T and so is on average T/2 old, and the vehicle flies an acceleration its response
    time τ after it is asked for. With the time t since the start, t' = t + T/2, the trajectory p and the lead λ,

        position = p(t'),      velocity = p'(t'),      acceleration = p''(t' + λτ),

    and yaw and yaw rate at t' where the trajectory has them. After its end the last point is held.

    Source: Faessler, Franchi, Scaramuzza 2018 (RA-L 3(2), section IV): reference and feed-forward terms of a
    trajectory; the times ahead are ours.
    """

    needs = ("trajectory",)

    lead: NonNegative = 1.0
    """1, λ, how far ahead the acceleration is sent over the vehicle's response time"""

    def start(self, course: Course, state: State) -> Clock:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory.
        """
        return begin(course, state, heading=math.nan)

    def step(self, memory: Clock, course: Course, state: State, duration: float) -> tuple[Setpoint, Clock]:
        """Return the motion to fly for the next `duration` (s), and the new memory."""
        clock = tick(memory, course, state)
        rows, then = clock.reference.rows, clock.since(state) + 0.5 * duration
        asked = motion(rows, then)
        ahead = motion(rows, then + self.lead * course.envelope.response_time)
        return Setpoint(
            position=np.array(asked[0:3]),
            velocity=np.array(asked[3:6]),
            acceleration=np.array(ahead[6:9]),
            yaw=asked[15],
            yaw_rate=asked[16],
        ), clock
