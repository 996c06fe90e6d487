"""Pure pursuit: fly the arc of a circle to the point of the path a lookahead of arc length ahead."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.follow.guidance import Foot, locate
from crosstrack.follow.lateral import FOLD, LateralMemory, begin, command, lookahead_at, turning
from crosstrack.protocols import Course, Path
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import direction

SHARES = np.linspace(0.0, 1.0, 17)
"""of the lookahead: where it is seen whether the path turns back"""
SHORTEST = 0.5
"""of the least lookahead, the shortest chord that is counted on, where the path curls up"""


@dataclass(frozen=True)
class PurePursuit:
    """Fly the circle that is tangent to the velocity and leads through a point of the path ahead.

    With the point A of the path at the arc length δ ahead of the closest point, its distance L and the angle α from the
    velocity V to it, the curvature of the circle is

        κ = 2 sin α / L = 2 x / L²,

    with x the distance of A from the line of flight, and the acceleration V² κ, in the plane of velocity and A. Where
    the path turns back or ends within the lookahead, A is on its tangent.

    δ is the way that the speed profile makes in `reaction` times the response time of the vehicle, so that it is short
    before slow corners.

    Source: Coulter 1992 (CMU-RI-TR-92-01); in space, and the rule for δ, are ours.
    """

    needs = ()

    lookahead: Positive = 0.3
    """m, least δ"""
    reaction: NonNegative = 2.0
    """1, time to the aim over the vehicle's response time"""

    def start(self, course: Course, state: State) -> LateralMemory:
        """Begin at the entry of the course."""
        return begin(course, state)

    def step(
        self, memory: LateralMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, LateralMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        lookahead = lookahead_at(self.lookahead, self.reaction, course, foot, state.velocity, duration)
        aim = course.path(course.path.length) if foot.last else point_ahead(course.path, foot, lookahead)
        chord = aim - state.position
        distance = max(math.sqrt(chord @ chord), SHORTEST * self.lookahead)
        push = 2 * float(state.velocity @ state.velocity) / distance * turning(state.velocity, direction(chord))
        return command(memory, course, foot, state, duration, aim, push)


def point_ahead(path: Path, foot: Foot, lookahead: float) -> Array:
    """Return the point (3,) m of a path a lookahead (m) ahead; on its tangent where it ends or turns back."""
    s = foot.s + lookahead * SHARES
    tangents = path(s, 1)
    folds = np.flatnonzero(np.einsum("ij,ij->i", tangents[1:], tangents[:-1]) < FOLD)
    last = min(float(s[folds[0]] if folds.size else s[-1]), path.length)
    beyond = lookahead - (last - foot.s)
    return path(last) + beyond * path(last, 1)
