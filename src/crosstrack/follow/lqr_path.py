"""Optimal path following of Ratnoo, Sujit and Kothari: a linear regulator of the cross-track error that stiffens."""

import math
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Lt

from crosstrack.follow.guidance import locate
from crosstrack.follow.lateral import LateralMemory, begin, bend, command, response, turning
from crosstrack.protocols import Course
from crosstrack.types import NonNegative, Positive, Setpoint, State
from crosstrack.vectors import across, direction

STEEPEST = math.sqrt(0.5)
"""of the speed, the most that is flown towards the path: 45°"""


@dataclass(frozen=True)
class LqrPath:
    """Regulate the cross-track error and its rate to zero, the more stiffly the nearer the error is to its bound.

    The error across the path is a double integrator, d̈ = u. The regulator that minimises ∫ q1 d² + q2 ḋ² + u² dt is

        u = -(k1 d + k2 ḋ),      k1 = √q1,      k2 = √(2 k1 + q2),

    and q1 grows with the error as q1 = ω⁴ d_b / (d_b - d), so that the vehicle keeps within the bound d_b. With the
    time scaled by ω, q2 = `rate_weight` ω². In space d is the vector from the closest point, ḋ the velocity across the
    tangent, and V² κ along the curvature of the path is added to u.

    Two limits make it a law for any error: q1 grows by `stiffening` at most, and k1 d is at most k2 times the speed
    towards the path that can be braked from at the error, √(a d), and that is flown at 45°. ω is at most `reaction`
    over the response time of the vehicle.

    Source: Ratnoo, Sujit, Kothari 2011 (IFAC World Congress, Adaptive Optimal Path Following for High Wind Flights),
    there with ω = 1/s and q2 = 1; the limits and the scale are ours.
    """

    needs = ()

    bandwidth: Positive = 8.0
    """1/s, most ω"""
    reaction: Positive = 0.4
    """1, most ω times the vehicle's response time"""
    rate_weight: NonNegative = 1.0
    """1, weight of the rate of the error over ω²"""
    error_bound: Positive = 1.0
    """m, d_b"""
    stiffening: Annotated[float, Ge(1), Lt(math.inf)] = 4.0
    """1, the most that q1 grows by"""

    def start(self, course: Course, state: State) -> LateralMemory:
        """Begin at the entry of the course."""
        return begin(course, state)

    def step(
        self, memory: LateralMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, LateralMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        frequency = min(self.bandwidth, self.reaction / response(course, duration))
        offset = across(foot.offset, foot.tangent)
        error = math.sqrt(offset @ offset)
        stiffness, damping = self.gains(error, frequency)
        flown = math.sqrt(state.velocity @ state.velocity)
        speed = max(foot.speed, flown)
        brakable = math.sqrt(course.envelope.acceleration * error) if error > 0 else 0.0
        closing = min(stiffness / damping * error, STEEPEST * speed, brakable)
        along = math.sqrt(max(0.0, speed**2 - closing**2))
        wanted = closing * direction(offset) + along * foot.tangent
        push = damping * flown * turning(state.velocity, direction(wanted))
        push = push + bend(course, foot, state.velocity, duration)
        aim = state.position + damping / stiffness * wanted
        return command(memory, course, foot, state, duration, aim, push)

    def gains(self, error: float, frequency: float) -> tuple[float, float]:
        """Return k1 (1/s²) and k2 (1/s) at an error (m) with the frequency ω (1/s)."""
        room = max(self.error_bound - error, self.error_bound / self.stiffening)
        stiffness = frequency**2 * math.sqrt(self.error_bound / room)
        return stiffness, math.sqrt(2 * stiffness + self.rate_weight * frequency**2)
