"""From a direction to fly to a command for any vehicle: speed, crosswind, feed-forward."""

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.follow.guidance import Foot, GuidanceMemory, affordable, ahead
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope, Setpoint, State
from crosstrack.vectors import across, dot, limited

DRIFT_MAX = 5.0
"""of the speed, the most drift that is corrected: a point in a wind of 98 % of its speed needs as much"""
DRIFT_MAX_STOPPING = 0.1
"""likewise for a vehicle that can stop: it holds the velocity over ground itself, but for small errors"""
DRIFT_PACE = 0.3
"""of the time to the aim, the fastest that drift is integrated, so that a slow turn does not count as drift"""


@dataclass(frozen=True)
class BearingMemory(GuidanceMemory):
    """What a law that gives a direction remembers."""

    drift: Array
    """(3,) m/s, velocity added across the path against the wind"""
    course: Array
    """(3,) m/s, velocity asked for in the last step, without drift"""


M = TypeVar("M", bound=BearingMemory)


def begin(course: Course, state: State) -> BearingMemory:
    """Return the memory to begin with: at the entry of the course."""
    foot = course.path(course.entry)
    return BearingMemory(
        progress=course.entry,
        aim=foot,
        error=float(np.linalg.norm(foot - state.position)),
        drift=np.zeros(3),
        course=state.velocity,
    )


def command(
    memory: M,
    course: Course,
    foot: Foot,
    state: State,
    duration: float,
    *,
    aim: Array,
    asked: Array,
    push: Array,
    drift_gain: float,
    distance: float,
    **more: Array,
) -> tuple[Setpoint, M]:
    """Return the setpoint that flies a direction at the speed of the course, and the new memory.

    On the last stretch a vehicle that can stop is asked for the last position.

    Args:
        memory: of the step before
        course: what is followed
        foot: the closest point
        state: of the vehicle
        duration: s, until the next step
        aim: (3,) m, the point flown to
        asked: (3,) unit, the direction to fly
        push: (3,) m/s², the acceleration that the law asks for beside that of the course
        drift_gain: 1/s, how fast a crosswind is corrected
        distance: m, over which the law comes to the path
        **more: what the law remembers beside
    """
    speed, tangent = foot.speed, foot.tangent
    push = push + ahead(course, foot.s, tangent, state.velocity)
    share = min(1.0, min(drift_gain, DRIFT_PACE * speed / distance) * duration)
    most = (DRIFT_MAX_STOPPING if course.envelope.stops else DRIFT_MAX) * speed
    drift = drifted(memory, state.velocity, tangent, share, most)
    memory = replace(memory, progress=foot.s, aim=aim, drift=drift, error=foot.error, course=speed * asked, **more)
    if foot.last and course.envelope.stops:
        return Setpoint(position=aim), memory
    return Setpoint(
        velocity=memory.course + across(drift, tangent), acceleration=affordable(push, course.envelope)
    ), memory


def reach_at(least: float, reaction: float, foot: Foot, velocity: Array, envelope: Envelope) -> float:
    """Return over which distance (m) to come to the path.

    It is at least the way of `reaction` response times of the vehicle, and the turning radius of one that cannot slow
    down. At an error e and a speed v it is at least √(e v²/a), which leaves twice the radius v²/a for the turn onto the
    path.

    Args:
        least: m
        reaction: 1
        foot: the closest point
        velocity: (3,) m/s, flown
        envelope: what the vehicle can do, a among it
    """
    radius = 0.0 if envelope.stops else foot.speed**2 / envelope.acceleration
    capture = math.sqrt(foot.error * float(velocity @ velocity) / envelope.acceleration)
    return max(least, reaction * envelope.response_time * foot.speed, radius, capture)


def drifted(memory: BearingMemory, velocity: Array, tangent: Array, share: float, most: float) -> Array:
    """Return the drift (3,) m/s after adding a share of what the velocity flown misses of the one asked for.

    Nothing is added while the vehicle flies against its course, still turning; and it is `most` m/s at most.
    """
    return learnt(memory.drift, memory.course, velocity, tangent, share, most)


@compiled
def learnt(drift: Array, course: Array, velocity: Array, tangent: Array, share: float, most: float) -> Array:
    """Return the new drift (3,) m/s, see `drifted`."""
    if dot(velocity, course) <= 0:
        return drift
    return limited(drift + share * across(course - velocity, tangent), most)
