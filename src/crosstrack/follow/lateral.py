"""From a lateral acceleration, which the guidance of fixed wings gives, to a command for any vehicle."""

import math
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.follow.guidance import Foot, GuidanceMemory, affordable, ahead
from crosstrack.protocols import Course, Speed
from crosstrack.types import Array, Setpoint, State
from crosstrack.vectors import across, direction, limited

STEPS = np.linspace(0.0, 1.0, 17)
"""of a stretch of the course: where its speed is read"""
CREEP = 0.3
"""m/s, speed under which a vehicle that can stop counts as slow"""
SLOW, BRISK = 0.25, 0.5
"""of the speed asked for, flown towards the aim: under the first the law is not asked, above the second it alone is"""
FOLD = -0.9
"""cosine of the turn between two samples of a path from which it turns back on itself"""
LEAD = 0.7
"""of the response time, how far ahead to look at the curve; the longer, the more corners are cut"""
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class LateralMemory(GuidanceMemory):
    """What a law of lateral acceleration remembers."""

    heading: Array
    """(3,) unit, the course through the air asked for; of use where the vehicle cannot stop"""


M = TypeVar("M", bound=LateralMemory)


def begin(course: Course, state: State) -> LateralMemory:
    """Return the memory to begin with: at the entry of the course."""
    foot = course.path(course.entry)
    error = float(np.linalg.norm(foot - state.position))
    heading = direction(state.velocity)
    return LateralMemory(course.entry, foot, error, heading if heading.any() else course.path(course.entry, 1))


def response(course: Course, duration: float) -> float:
    """Return the time (s) from an acceleration asked for to that flown; a command is half a step old on average."""
    return course.envelope.response_time + 0.5 * duration


def lookahead_at(least: float, reaction: float, course: Course, foot: Foot, velocity: Array, duration: float) -> float:
    """Return how far ahead (m) to aim: as far as the speed profile leads while the vehicle reacts, see `stretched`.

    A vehicle that cannot slow down looks at least its turning radius ahead.

    Args:
        least: m
        reaction: 1, time to the aim over the vehicle's response time
        course: what is followed
        foot: the closest point
        velocity: (3,) m/s, flown
        duration: s, until the next step
    """
    envelope = course.envelope
    way = covered(course.speed, foot.s, reaction * response(course, duration))
    radius = 0.0 if envelope.stops else foot.speed**2 / envelope.acceleration
    return stretched(max(least, way, radius), foot.error, velocity, envelope.acceleration)


def covered(speed: Speed, s: float, duration: float) -> float:
    """Return the way (m) that a speed profile makes from an arc length `s` (m) in a time (s)."""
    start = float(speed(s))
    gain = max(0.0, float(speed(s, 1)))
    way = (start + gain * duration) * duration
    return float(travelled(way / (len(STEPS) - 1), speed(s + way * STEPS), duration))


@compiled
def travelled(step: float, speeds: Array, duration: float) -> float:
    """Return the way (m) made in a time (s) at speeds (n,) m/s a step (m) apart, to their end at most."""
    least = 1e-3 * (speeds[0] + speeds[-1]) + 1e-9
    time = 0.0
    for k in range(speeds.size - 1):
        spent = step / max(0.5 * (speeds[k] + speeds[k + 1]), least)
        if time + spent >= duration:
            return step * (k + (duration - time) / spent if spent > 0 else k)
        time += spent
    return step * (speeds.size - 1)


def turning(velocity: Array, wanted: Array) -> Array:
    """Return the sine of the angle from a velocity to a unit vector, as a vector across the velocity; held beyond 90°.

    From straight ahead to straight back it is to the left, in the horizontal plane. Zero for a vehicle at rest.
    """
    flown = direction(velocity)
    part = across(wanted, flown)
    if not flown.any() or wanted @ flown >= 0:
        return part if flown.any() else flown
    side = direction(part)
    if side.any():
        return side
    left = direction(np.cross(UP, flown))
    return left if left.any() else np.array([1.0, 0.0, 0.0])


def bend(course: Course, foot: Foot, velocity: Array, duration: float) -> Array:
    """Return the acceleration (3,) m/s² that keeps a vehicle on the curve ahead: the mean while it responds."""
    time = max(LEAD * course.envelope.response_time, duration)
    speed = max(0.0, float(velocity @ foot.tangent))
    way = max(0.0, speed + 0.5 * float(course.speed(foot.s, 1)) * time) * time
    return across(speed / time * (course.path(foot.s + way, 1) - foot.tangent), foot.tangent)


def command(
    memory: M, course: Course, foot: Foot, state: State, duration: float, aim: Array, push: Array
) -> tuple[Setpoint, M]:
    """Return the setpoint that flies a lateral acceleration, and the new memory.

    A vehicle that can stop is asked for the speed of the course along the course flown; while it flies slowly towards
    the aim, or away from it, straight towards the aim. On the last stretch it is asked for the last position. A vehicle
    of constant airspeed is asked for a heading, which is the integral of the acceleration, so that a steady wind
    needs no estimate.

    Args:
        memory: of the step before
        course: what is followed
        foot: the closest point
        state: of the vehicle
        duration: s, until the next step
        aim: (3,) m, the point steered for
        push: (3,) m/s², the acceleration that the law asks for, across the velocity or the path
    """
    envelope = course.envelope
    memory = replace(memory, progress=foot.s, aim=aim, error=foot.error)
    if not envelope.stops:
        return steered(memory, foot.speed, limited(push, envelope.acceleration), duration)
    if foot.last:
        end = course.path(course.path.length)
        return Setpoint(position=end), replace(memory, aim=end)
    flown, wanted = direction(state.velocity), direction(aim - state.position)
    share = trust(float(state.velocity @ wanted), foot.speed)
    forward = ahead(course, foot.s, foot.tangent, state.velocity)
    # More than the vehicle has is asked for at a lower speed, where the same turn needs less.
    needed = math.sqrt(push @ push)
    slower = math.sqrt(envelope.acceleration / max(needed, envelope.acceleration))
    push, along = affordable(push, envelope), affordable((forward @ flown) * flown, envelope)
    return Setpoint(
        velocity=foot.speed * (share * slower * flown + (1 - share) * wanted),
        acceleration=share * (push + along) + (1 - share) * affordable(forward, envelope),
    ), memory


def steered(memory: M, speed: float, push: Array, duration: float) -> tuple[Setpoint, M]:
    """Return the setpoint of constant airspeed (m/s) that turns by an acceleration (3,) m/s², and the new memory."""
    turned = direction(speed * memory.heading + push * duration)
    heading = turned if turned.any() else memory.heading
    return Setpoint(velocity=speed * heading), replace(memory, heading=heading)


def trust(closing: float, speed: float) -> float:
    """Return how far to rely on the law, from 0 to 1, by the speed towards the aim and that asked for, both m/s."""
    return min(1.0, max(0.0, (closing / max(speed, CREEP) - SLOW) / (BRISK - SLOW)))


def stretched(least: float, error: float, velocity: Array, acceleration: float) -> float:
    """Return how far ahead (m) to aim at an error (m), so that the turn onto the path is one that can be flown.

    At the distance L the course meets the path at the angle asin(e / L). A turn of radius r = V²/a that begins at the
    error e ends on the path if the angle is at most acos(1 - e / r), which for small angles is L = √(e r / 2); twice
    the radius is counted on. The angle is at most 45°.
    """
    return max(least, math.sqrt(2) * error, math.sqrt(error * float(velocity @ velocity) / acceleration))
