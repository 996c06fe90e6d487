"""Nonlinear path following guidance of Stastny and Siegwart, as PX4 flies it: a bearing by the track error."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.follow.guidance import locate
from crosstrack.follow.lateral import LateralMemory, begin, bend, command, response, turning
from crosstrack.protocols import Course
from crosstrack.types import Array, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import across, direction, limited

LEAST_SPEED = 1.0
"""m/s, ground speed under which the track error bound shrinks no further than by half"""
WIND_TIME = 0.5
"""s, over which the wind is averaged"""


@dataclass(frozen=True)
class NpfgMemory(LateralMemory):
    """What path following guidance remembers."""

    wind: Array
    """(3,) m/s, as estimated where the vehicle flies at constant airspeed"""


@dataclass(frozen=True)
class Npfg:
    """Fly a bearing that turns from straight at the path to along it as the track error falls.

    With the period P and the damping ζ, the track error bound is e_b = V T of the ground speed V and the time constant
    T = P ζ, and the error over it at most ē = 1. The bearing b leaves the unit track error vector ê, towards the path,
    by the lookahead angle θ towards the tangent t,

        θ = π/2 (1 - ē)²,      b = cos θ ê + sin θ t,

    and with the curvature κ of the path the acceleration across the velocity v is

        a = 4π ζ / P (b x v direction, held beyond 90°) V + V² κ sin² θ.

    Near a straight path the error has the period P and the damping ζ. P is at least `reaction` times the least that is
    stable with the response time τ of the vehicle, π τ / ζ.

    A vehicle of constant airspeed steers its air velocity to the side of the wind triangle that makes the ground
    velocity point along b, forwards or backwards; where the wind allows none, against the wind across b. Its wind is
    the ground velocity less the air velocity asked for, averaged over half a second.

    Sources: Stastny, Siegwart 2019 (IROS, arXiv 1908.01381); Stastny 2020 (doctoral thesis, ETH
    Zürich, paper III); the guidance of PX4. There in the plane; here ê is the error vector in space.
    """

    needs = ()

    period: Positive = 0.5
    """s, least P"""
    damping: Positive = 0.7071
    """1, ζ"""
    reaction: NonNegative = 3.0
    """1, period over the least that is stable with the vehicle's response time"""

    def start(self, course: Course, state: State) -> NpfgMemory:
        """Begin at the entry of the course, in calm air."""
        memory = begin(course, state)
        return NpfgMemory(memory.progress, memory.aim, memory.error, memory.heading, np.zeros(3))

    def step(self, memory: NpfgMemory, course: Course, state: State, duration: float) -> tuple[Setpoint, NpfgMemory]:
        """Return velocity and acceleration to fly for the next `duration` (s), and the new memory."""
        foot = locate(memory, course, state, duration)
        period = max(self.period, self.reaction * math.pi * response(course, duration) / self.damping)
        bound = error_bound(math.sqrt(state.velocity @ state.velocity), period * self.damping)
        toward, proximity = bearing(across(foot.offset, foot.tangent), foot.tangent, bound)
        aim = state.position + bound * toward
        gain = 4 * math.pi * self.damping / period
        velocity = state.velocity
        if not course.envelope.stops:
            velocity = foot.speed * memory.heading
            miss = state.velocity - velocity - memory.wind
            memory = replace(memory, wind=memory.wind + min(1.0, duration / WIND_TIME) * miss)
            toward = air_course(toward, memory.wind, foot.speed)
        push = gain * math.sqrt(velocity @ velocity) * turning(velocity, toward)
        push = push + proximity * bend(course, foot, state.velocity, duration)
        return command(memory, course, foot, state, duration, aim, push)


def error_bound(speed: float, time: float) -> float:
    """Return the track error bound (m) from the ground speed (m/s) and the time constant (s)."""
    if speed > LEAST_SPEED:
        return speed * time
    return 0.5 * time * (speed**2 / LEAST_SPEED + LEAST_SPEED)


def bearing(offset: Array, tangent: Array, bound: float) -> tuple[Array, float]:
    """Return the unit bearing (3,), and how near the path is, from 0 at the track error bound to 1 on it.

    Args:
        offset: (3,) m, across the path, from the vehicle to it
        tangent: (3,) unit, of the path
        bound: m, track error bound
    """
    normalised = min(1.0, math.sqrt(offset @ offset) / bound)
    angle = 0.5 * math.pi * (1 - normalised) ** 2
    return math.cos(angle) * direction(offset) + math.sin(angle) * tangent, math.sin(angle) ** 2


def air_course(toward: Array, wind: Array, airspeed: float) -> Array:
    """Return the direction (3,) of the air velocity that makes the ground velocity point along a unit bearing.

    The side of the wind triangle, s b - w_⊥ with s = √(V² - w_⊥²); against the crosswind w_⊥ where it is above V.
    """
    crosswind = limited(across(wind, toward), airspeed)
    return direction(math.sqrt(max(0.0, airspeed**2 - float(crosswind @ crosswind))) * toward - crosswind)
