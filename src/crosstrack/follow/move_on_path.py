"""AirSim's moveOnPath: chase a point ahead on straight legs, at one speed."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.follow.guidance import locate
from crosstrack.follow.legs import LegsMemory, held, legs_from, top_speed
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import direction

ACCURACY = 0.5
"""m, distance accuracy of simple_flight: nearer than this is there"""
ADAPTIVE_TIME, FIXED_TIME = 0.6, 0.8
"""s, lookahead over speed: 30 command periods of 20 ms with an adaptive lookahead, 40 without"""
LEAST_SPEED = 0.5
"""m/s, of the shared speed profile, which begins at rest"""


@dataclass(frozen=True)
class MoveOnPathMemory(LegsMemory):
    """What moveOnPath remembers."""

    path: Polyline
    """the legs by arc length"""
    reached: float
    """m, arc length along the legs"""


@dataclass(frozen=True)
class MoveOnPath:
    """Fly as AirSim's moveOnPath does: a baseline, with its flaws.

    The path leads from where the vehicle is through the waypoints in straight legs, nothing is rounded, and there is
    one speed V for all of it, without braking. With the point Q reached so far and the point A ahead of it, a
    lookahead L + e farther along the path, the command is the velocity

        v = V unit(A - P),      none where |A - P| < 0.5 m, and no vertical part where |A - P|_z ≤ 0.5 m.

    Then Q advances by the part of P - Q along A - Q where that is ahead, and e is `adaptive_lookahead` times the part
    across it. It is over when A is the end of the path and P is no longer ahead of Q; then the end is held.

    Where the path turns back, A may come to lie at the vehicle: AirSim hovers there for good, here Q goes on at V.
    All else is AirSim's law. Its autopilot, simple_flight, answers with a velocity loop that is proportional only,
    and slower the higher it flies: steady errors of speed and height come from there, and are not seen here. AirSim
    holds the position where it notices the end, here it is the end itself. ForwardOnly yaw is left out.

    Source: Shah, Dey, Lovett, Kapoor 2017 (AirSim, FSR), the API of its multirotors.
    """

    needs = ()

    speed: Positive | None = None
    """m/s; none for the top of the speed profile, which legs too short for it keep under the cruise speed"""
    lookahead: Positive | None = None
    """m, L; none for 0.6 s (0.8 s without an adaptive lookahead) at the speed, at least 0.75 m"""
    adaptive_lookahead: NonNegative = 1.0
    """1, by which the cross-track error lengthens the lookahead; 0 for none"""
    shared_speed: bool = False
    """whether to fly the speed profile of the course, slow at corners and at the end, in place of one speed"""

    def start(self, course: Course, state: State) -> MoveOnPathMemory:
        """Begin where the vehicle is."""
        legs = legs_from(course, state.position)
        speed = self.speed or top_speed(course)
        path = Polyline(legs if len(legs) > 1 else course.corners)
        aim = path(self.lookahead_at(speed))
        error = float(np.linalg.norm(course.path(course.entry) - state.position))
        return MoveOnPathMemory(course.entry, aim, error, legs, speed, len(legs) < 2, path, 0.0)

    def step(
        self, memory: MoveOnPathMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, MoveOnPathMemory]:
        """Return the velocity to fly for the next `duration` (s), and the new memory."""
        if memory.done:
            return held(memory, course, state)
        foot = locate(memory, course, state, duration)
        speed = min(memory.speed, max(foot.speed, LEAST_SPEED)) if self.shared_speed else memory.speed
        path, at = memory.path, memory.path(memory.reached)
        ahead, beside = split(state.position - at, direction(memory.aim - at))
        reached = min(memory.reached + max(0.0, ahead), path.length)
        chased = reached + self.lookahead_at(speed) + self.adaptive_lookahead * beside
        aim = path(chased)
        memory = replace(memory, progress=foot.s, aim=aim, error=foot.error, reached=reached)
        if chased >= path.length and ahead <= 0:
            return held(memory, course, state)
        velocity = chasing(aim - state.position, speed, duration)
        if chased < path.length and not velocity.any():
            memory = replace(memory, reached=reached + speed * duration)
        return Setpoint(velocity=velocity), memory

    def lookahead_at(self, speed: float) -> float:
        """Return the lookahead (m) at a speed (m/s)."""
        if self.lookahead is not None:
            return self.lookahead
        return max(speed * (ADAPTIVE_TIME if self.adaptive_lookahead > 0 else FIXED_TIME), 1.5 * ACCURACY)


def split(vector: Array, along: Array) -> tuple[float, float]:
    """Return the part of a vector along a unit vector, and the length of the part across it; all of it for zero."""
    part = float(vector @ along)
    return part, math.sqrt(max(0.0, float(vector @ vector) - part**2))


def chasing(way: Array, speed: float, duration: float) -> Array:
    """Return the velocity (3,) m/s along a way (3,) m as AirSim does: none near its end, level near its height."""
    distance = math.sqrt(way @ way)
    if distance < ACCURACY:
        return np.zeros(3)
    velocity = min(speed, distance / duration) / distance * way
    return np.array([velocity[0], velocity[1], 0.0 if abs(way[2]) <= ACCURACY else velocity[2]])
