"""Pursuit with line of sight guidance (PLOS): turn towards a point ahead, and towards the path beside it."""

import math
from dataclasses import dataclass

from crosstrack.follow.bearing import reach_at
from crosstrack.follow.guidance import Foot, locate
from crosstrack.follow.lateral import LateralMemory, begin, command, response, turning
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import across, direction


@dataclass(frozen=True)
class ProportionalLos:
    """Turn in proportion to the angle to a point ahead and to the cross-track error.

    With the closest point C, the tangent t, the aim A = C + L t, the angle η from the velocity V to it and the
    cross-track error e = |C - P|, the rate of turn is

        u = k1 η + k2 e,      k1 = c1 V / L,      k2 = c2 V / L²,

    and the acceleration V u, across the velocity. On a straight path, e'' + c1 V/L e' + (c1 + c2) V²/L² e = 0: the
    damping is c1 / (2 √(c1 + c2)). For η stands its sine, and k2 e turns no farther than square to the path, so that
    the law does not circle far off. The feed-forward V² over the radius of the path holds curves.

    Source: Sujit, Saripalli, Sousa 2014 (IEEE Control Systems 34(1), PLOS); gains by L, and curves, are ours.
    """

    needs = ()

    lookahead: Positive = 0.5
    """m, least L"""
    reaction: NonNegative = 2.5
    """1, least time to the aim over the vehicle's response time"""
    pursuit_gain: Positive = 3.0
    """1, c1, rate of turn over angle to the aim and V / L"""
    line_gain: NonNegative = 1.0
    """1, c2, rate of turn over cross-track error and V / L²"""

    def start(self, course: Course, state: State) -> LateralMemory:
        """Begin at the entry of the course."""
        return begin(course, state)

    def step(
        self, memory: LateralMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, LateralMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        square = float(state.velocity @ state.velocity)
        least = reach_at(self.lookahead, self.reaction, foot, state.velocity, course.envelope)
        distance = max(least, math.sqrt(2) * foot.error)
        aim = course.path(course.path.length) if foot.last else foot.point + distance * foot.tangent
        asked = direction(aim - state.position)
        if not foot.last:
            asked = leaning(asked, foot, self.line_gain / self.pursuit_gain / distance)
        push = self.pursuit_gain * square / distance * turning(state.velocity, asked)
        push = push + square * course.path(foot.s + math.sqrt(square) * response(course, duration), 2)
        return command(memory, course, foot, state, duration, aim, push)


def leaning(asked: Array, foot: Foot, gain: float) -> Array:
    """Return the direction (3,) turned towards the path by a gain (rad/m) times the error, at most square to it."""
    normal = direction(across(foot.offset, foot.tangent))
    along, aside = float(asked @ foot.tangent), float(asked @ normal)
    angle = min(0.5 * math.pi, math.atan2(aside, along) + gain * foot.error)
    return math.cos(angle) * foot.tangent + math.sin(angle) * normal
