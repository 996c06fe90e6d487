"""Carrot chasing as a tutorial publishes it for AirSim, with its limits: the baseline that flies off at speed."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.follow.guidance import locate
from crosstrack.follow.legs import LegsMemory, apart, held, legs_from, top_speed
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State

PUSH_MAX = 1.0
"""m/s², limit of the turn that it asks for"""
HEIGHT_GAIN = 1.5
"""1/s, of the height loop: that of simple_flight, which the tutorial flies with"""


@dataclass(frozen=True)
class PublishedCarrotMemory(LegsMemory):
    """What the published law remembers."""

    leg: int
    """of the leg flown"""
    heading: float
    """rad, course asked for in the last step"""


@dataclass(frozen=True)
class PublishedCarrot:
    """Chase a carrot in the plane, at one speed, with proportional heading control: a baseline.

    On a leg from W_i in the direction θ, at the distance R along it, the carrot is S = W_i + (R + δ) (cos θ, sin θ),
    and ψ_d is the direction from the vehicle to it. The command is the velocity

        v = V (cos ψ_d, sin ψ_d) + u dt across it,      u = K V (ψ_d - ψ), at most 1 m/s²,

    at the height of the first waypoint, where ψ is the course asked for before. The next leg begins when the carrot
    passes the end of the leg; the last one ends when the vehicle passes its end, and then the end is held.

    There is no speed profile, no rounding, no wind, no dynamics and no third dimension, as its author says: at 10 m/s
    it is metres beside the path. The slips of the program as printed (quadrants, one-sided limits, ends of legs axis by
    axis) are not repeated.

    Source: Bhadani 2020 (arXiv 2012.13227), after Sujit, Saripalli, Sousa 2014 (IEEE Control Systems 34(1)).
    """

    needs = ()

    speed: Positive | None = None
    """m/s; none for the top of the speed profile, which legs too short for it keep under the cruise speed"""
    lookahead: Positive = 0.8
    """m, δ"""
    heading_gain: NonNegative = 0.8
    """1/s, K"""

    def start(self, course: Course, state: State) -> PublishedCarrotMemory:
        """Begin where the vehicle is, at the height of the first waypoint."""
        legs = legs_from(course, state.position)
        legs[:, 2] = course.path(course.entry)[2]
        legs = apart(legs)
        x, y = state.velocity[:2]
        error = float(np.linalg.norm(course.path(course.entry) - state.position))
        speed = self.speed or top_speed(course)
        return PublishedCarrotMemory(
            course.entry, legs[0], error, legs, speed, len(legs) < 2, leg=0, heading=math.atan2(y, x)
        )

    def step(
        self, memory: PublishedCarrotMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, PublishedCarrotMemory]:
        """Return the velocity to fly for the next `duration` (s), and the new memory."""
        if memory.done:
            return held(memory, course, state)
        foot = locate(memory, course, state, duration)
        leg, carrot = self.carrot(memory.legs, memory.leg, state.position)
        memory = replace(memory, progress=foot.s, error=foot.error, leg=leg)
        if leg == len(memory.legs) - 1:
            return held(memory, course, state)
        way = carrot - state.position
        wanted = math.atan2(way[1], way[0])
        error = math.remainder(wanted - memory.heading, 2 * math.pi)
        push = min(PUSH_MAX, max(-PUSH_MAX, self.heading_gain * memory.speed * error))
        flown = wanted + math.atan2(push * duration, memory.speed)
        climb = min(memory.speed, max(-memory.speed, HEIGHT_GAIN * way[2]))
        velocity = np.array([memory.speed * math.cos(flown), memory.speed * math.sin(flown), climb])
        return Setpoint(velocity=velocity), replace(memory, aim=carrot, heading=wanted)

    def carrot(self, legs: Array, leg: int, position: Array) -> tuple[int, Array]:
        """Return the leg to fly, that beyond the last one at the end, and the carrot (3,) m on it."""
        for k in range(leg, len(legs) - 1):
            way = legs[k + 1] - legs[k]
            length = math.sqrt(way @ way)
            along = float((position - legs[k]) @ way) / length
            last = k == len(legs) - 2
            if along + (0.0 if last else self.lookahead) <= length:
                return k, legs[k] + (along + self.lookahead) / length * way
        return len(legs) - 1, legs[-1]
