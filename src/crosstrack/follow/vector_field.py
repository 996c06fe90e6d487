"""Vector field: at every point around the path a direction is given, steeper the farther the path is."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Gt, Le

from crosstrack.follow.bearing import BearingMemory, begin, command, reach_at
from crosstrack.follow.guidance import locate, turn
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import across, direction


@dataclass(frozen=True)
class VectorField:
    """Fly along a field of directions that leads onto the path.

    With the closest point C, the tangent t, the error e = |C - P| across it and the unit vector n from the vehicle P
    to the path, the course asked for is at the angle χ to the tangent,

        χ = χ∞ 2/π atan(k e),      d = cos χ t + sin χ n,

    from χ∞ far off to e' = -k χ∞ 2/π V e close by. The command is

        v = V(s) d + drift,      a = V dd/dt + κ V d_⊥ + feed-forward of the path,

    where dd/dt is how the field turns along the way flown, χ' = -χ∞ 2/π k / (1 + k² e²) v·n for the angle, d_⊥ the part
    of d across the course flown, and drift integrates what the velocity flown across the path misses of V d. The
    feed-forward holds curved paths: V² over the radius, as in the field of an orbit.

    Source: Nelson, Barber, McLain, Beard 2007 (IEEE Transactions on Robotics 23(3), equations 4 and 9); the field in
    space, the sine in place of the saturated sliding term and the rule for k are ours.
    """

    needs = ()

    entry_angle: Annotated[float, Gt(0), Le(math.pi / 2)] = math.pi / 2
    """rad, χ∞, between course and path far off the path"""
    boundary: Positive = 0.5
    """m, least distance over which the error falls by the factor e close to the path, π / (2 k χ∞)"""
    reaction: NonNegative = 3.5
    """1, least time of that over the vehicle's response time"""
    heading_gain: NonNegative = 0.5
    """1/s, κ, acceleration over speed and sine of the course error"""
    drift_gain: NonNegative = 1.0
    """1/s, how fast a crosswind is corrected; 0 turns it off"""

    def start(self, course: Course, state: State) -> BearingMemory:
        """Begin at the entry of the course."""
        return begin(course, state)

    def step(
        self, memory: BearingMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, BearingMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        distance = reach_at(self.boundary, self.reaction, foot, state.velocity, course.envelope)
        if foot.last:
            aim = course.path(course.path.length)
            asked, swing = direction(aim - state.position), np.zeros(3)
        else:
            asked, swing = field(foot.offset, foot.tangent, state.velocity, self.entry_angle, distance)
            aim = state.position + (distance + foot.error) * asked
        push = foot.speed * (swing + self.heading_gain * turn(state.velocity, asked))
        return command(
            memory,
            course,
            foot,
            state,
            duration,
            aim=aim,
            asked=asked,
            push=push,
            drift_gain=self.drift_gain,
            distance=distance,
        )


def field(offset: Array, tangent: Array, velocity: Array, entry_angle: float, distance: float) -> tuple[Array, Array]:
    """Return the direction of the field, (3,) unit, and how it turns along the way flown, (3,) 1/s.

    Args:
        offset: (3,) m, from the vehicle to the closest point of the path
        tangent: (3,) unit, of the path there, taken as straight
        velocity: (3,) m/s, flown
        entry_angle: rad, χ∞
        distance: m, over which the error falls by the factor e close to the path
    """
    normal, sideways = across(offset, tangent), across(velocity, tangent)
    error = math.sqrt(normal @ normal)
    share = entry_angle * 2 / math.pi
    slope = 1 / (share * distance)
    if error < 1e-9:
        return tangent, -sideways / distance
    normal = normal / error
    angle = share * math.atan(slope * error)
    sine, cosine = math.sin(angle), math.cos(angle)
    closing = float(sideways @ normal)
    rate = -share * slope / (1 + (slope * error) ** 2) * closing
    swing = rate * (cosine * normal - sine * tangent) - sine / error * (sideways - closing * normal)
    return cosine * tangent + sine * normal, swing
