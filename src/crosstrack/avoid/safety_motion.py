"""How the motion of a vehicle answers the acceleration asked for: three lags, of attitude, rate and rotors.

On each axis, with the acceleration u asked for,

    dp/dt = v,   dv/dt = a,   da/dt = j,   dj/dt = s,   τ₃ ds/dt = ((u - a)/τ₁ - j)/τ₂ - s

while the thrust up, a_z + g, is steady. It changes faster than the tilt, and with it the acceleration sideways, which
is the tangent of the tilt times it; the tilt changes at the rate Ω at most.

The place q = p + τ₁(v + τ₂(a + τ₃ j)) and the velocity w = v + τ₁(a + τ₂(j + τ₃ s)) are what the vehicle is bound for:
whatever was asked for before is in them, and they are a double integrator, dq/dt = w and dw/dt = u. At rest q = p.
"""

import math
from typing import NamedTuple

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import GRAVITY, Array, Envelope

STEP = 0.01
"""s, of the integration"""
SHORT = 1e-4
"""s, stands for no lag"""
GREATEST = 1e3
"""m/s², stands for a vehicle that turns at once"""
AGILITY = 0.7
"""k times the response time: with more, what the two lags leave out makes the vehicle overshoot"""

LEAST_LIFT = 0.2
"""of gravity, less than autopilots ask for: where the tangent of the tilt is still a number"""

Motion = Array
"""(5, 3) position (m), velocity (m/s), acceleration (m/s²), jerk (m/s³) and snap (m/s⁴)"""


class Ability(NamedTuple):
    """What a vehicle brakes with, and how late."""

    sideways: float
    """m/s², deceleration sideways"""
    vertical: float
    """m/s², deceleration up or down"""
    tilt_time: float
    """s, τ₁ sideways"""
    turn_time: float
    """s, τ₂ sideways"""
    spin_time: float
    """s, τ₃ sideways"""
    lift_time: float
    """s, τ₁ up and down"""
    turn_rate: float
    """rad/s, Ω, at which the thrust can be turned"""
    thrust_min: float
    """m/s², least vertical thrust over mass"""
    thrust_max: float
    """m/s², greatest thrust over mass"""
    tilt_tangent: float
    """of the largest tilt"""
    late: float
    """s, age of the state when it is known"""
    response: float
    """s, all lags together"""
    speed: float
    """m/s, the fastest that an autopilot flies towards a place"""
    gain: float
    """1/s, k, the most by which a velocity is brought to rest: the end of braking is in proportion"""


def ability(envelope: Envelope, share: float) -> Ability:
    """Return what is left for braking when only a share of the acceleration is counted on."""
    sideways, vertical = (
        share * min(envelope.acceleration, GREATEST),
        share * min(envelope.acceleration_vertical, GREATEST),
    )
    model, response = envelope.model, max(envelope.response_time, 2 * STEP)
    gain = AGILITY / response
    if model is None:
        lift = 2 * envelope.acceleration_vertical
        most = math.hypot(GRAVITY + lift, 2 * envelope.acceleration)
        thrusts = GRAVITY - lift, most, math.inf
        return Ability(
            sideways,
            vertical,
            response,
            SHORT,
            SHORT,
            response,
            math.inf,
            *thrusts,
            0.0,
            response,
            envelope.speed,
            gain,
        )
    tilt, turn = max(model.attitude_time, 2 * STEP), max(model.rate_time - model.thrust_time, SHORT)
    spin, lift = max(model.thrust_time, SHORT), max(model.thrust_time, 2 * STEP)
    late = max(0.0, envelope.response_time - model.attitude_time - model.rate_time)
    thrusts = model.thrust_min, model.thrust_max, math.tan(model.tilt_max)
    return Ability(
        sideways, vertical, tilt, turn, spin, lift, model.rate_max, *thrusts, late, response, envelope.speed, gain
    )


@compiled
def strength(x: float, y: float, z: float, able: Ability) -> float:
    """Return the acceleration (m/s²) that there is along a unit vector: the radius of an ellipsoid."""
    flat, steep = math.sqrt(x * x + y * y) / able.sideways, z / able.vertical
    return 1.0 / math.sqrt(flat * flat + steep * steep)


@compiled
def moderate(asked: Array, able: Ability) -> Array:
    """Return an acceleration (3,) m/s² asked for, no longer than what there is along it.

    Beyond, the thrust that goes where the pilot wants to would be missing where an obstacle demands it.
    """
    size = math.sqrt(asked[0] * asked[0] + asked[1] * asked[1] + asked[2] * asked[2])
    if size < 1e-9:
        return asked.copy()
    most = strength(asked[0] / size, asked[1] / size, asked[2] / size, able)
    return asked * min(1.0, most / size)


@compiled
def lags(k: int, able: Ability) -> tuple[float, float, float]:
    """Return τ₁, τ₂ and τ₃ (s) of an axis."""
    if k == 2:
        return able.lift_time, SHORT, SHORT
    return able.tilt_time, able.turn_time, able.spin_time


@compiled
def support(normal: Array, able: Ability) -> float:
    """Return the most that an acceleration (m/s²) of the ellipsoid has along a unit vector (3,)."""
    flat = able.sideways * able.sideways * (normal[0] * normal[0] + normal[1] * normal[1])
    return math.sqrt(flat + able.vertical * able.vertical * normal[2] * normal[2])


@compiled
def lift_of(vertical: float, able: Ability) -> float:
    """Return the vertical thrust (m/s²) that an acceleration sideways goes with; 1 where the two are apart."""
    if math.isinf(able.turn_rate):
        return 1.0
    return max(vertical + GRAVITY, LEAST_LIFT * GRAVITY)


@compiled
def move(motion: Motion, asked: Array, h: float, able: Ability) -> None:
    """Advance a motion by a step (s) with an acceleration asked for (3,) m/s², in place.

    What lags is the tilt, so sideways the numbers below are over the vertical thrust: with the thrust the acceleration
    sideways grows at once. The innermost lag that is longer than the step is integrated, those within are done.
    """
    vertical, before = motion[2, 2], lift_of(motion[2, 2], able)
    upwards = asked[2]
    if not math.isinf(able.turn_rate):
        # The thrust is the part along the body's axis of the one asked for.
        x, y = motion[2, 0] / before, motion[2, 1] / before
        upwards = (asked[0] * x + asked[1] * y + asked[2] + GRAVITY) / (1.0 + x * x + y * y) - GRAVITY
    slope = (upwards - vertical) / able.lift_time
    motion[3, 2], motion[4, 2] = slope, 0.0
    after, wanted = lift_of(vertical + slope * h, able), lift_of(asked[2], able)
    most = able.turn_rate * math.sqrt(1.0 + (motion[2, 0] ** 2 + motion[2, 1] ** 2) / (before * before))
    rates = 0.0
    for k in range(2):
        rate, jolt = motion[3, k] / before, motion[4, k] / before
        slope = (asked[k] / wanted - motion[2, k] / before) / able.tilt_time
        if able.turn_time < h:
            rate, jolt = slope, 0.0
        else:
            jolt += ((slope - rate) / able.turn_time - jolt) * (1.0 - math.exp(-h / able.spin_time))
            rate += jolt * h
        motion[3, k], motion[4, k] = rate, jolt
        rates += rate * rate
    scale = most / math.sqrt(rates) if rates > most * most else 1.0
    for k in range(3):
        a, v = motion[2, k], motion[1, k]
        if k < 2:
            motion[2, k] = (a / before + scale * motion[3, k] * h) * after
            motion[3, k] *= scale * after
            motion[4, k] *= after if scale == 1.0 else 0.0
        else:
            motion[2, k] = a + motion[3, k] * h
        motion[1, k] = v + 0.5 * (a + motion[2, k]) * h
        motion[0, k] += 0.5 * (v + motion[1, k]) * h


@compiled
def bound_for(motion: Motion, able: Ability, place: Array, velocity: Array) -> None:
    """Put where (3,) m, q, and how fast (3,) m/s, w, a vehicle is bound into arrays."""
    for k in range(3):
        first, second, third = lags(k, able)
        place[k] = motion[0, k] + first * (motion[1, k] + second * (motion[2, k] + third * motion[3, k]))
        velocity[k] = motion[1, k] + first * (motion[2, k] + second * (motion[3, k] + third * motion[4, k]))


@compiled
def thrown(acceleration: Array, attitude: Array, rate: Array) -> Array:
    """Return the jerk (3,) m/s³ of a thrust that turns with the body, T R (ω x e_z), sideways.

    Args:
        acceleration: (3,) m/s²
        attitude: (4,) xyzw
        rate: (3,) rad/s, body
    """
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    thrust = math.sqrt(acceleration[0] ** 2 + acceleration[1] ** 2 + (acceleration[2] + GRAVITY) ** 2)
    forth, side = rate[1] * thrust, -rate[0] * thrust
    jerk = np.zeros(3)
    jerk[0] = (1 - 2 * (y * y + z * z)) * forth + 2 * (x * y - z * w) * side
    jerk[1] = 2 * (x * y + z * w) * forth + (1 - 2 * (x * x + z * z)) * side
    return jerk


@compiled
def started(
    position: Array, velocity: Array, acceleration: Array, jerk: Array, before: Array, asked: Array,
    period: float, able: Ability,
) -> Motion:  # fmt: skip
    """Return the motion now of a state that is `late` (s) and whose acceleration is the mean of the period before.

    Args:
        position: (3,) m
        velocity: (3,) m/s
        acceleration: (3,) m/s²
        jerk: (3,) m/s³
        before: (3,) m/s³, the jerk a period before; NaN where not known
        asked: (3,) m/s², asked for since the state was true
        period: s
        able: how late it is, and its lags
    """
    motion = np.empty((5, 3))
    for k in range(3):
        motion[0, k], motion[1, k], motion[3, k] = position[k], velocity[k], jerk[k]
        known = not math.isnan(before[k])
        motion[2, k] = acceleration[k] + 0.25 * period * (jerk[k] + (before[k] if known else jerk[k]))
        motion[4, k] = (jerk[k] - before[k]) / period if known else 0.0
    steps = math.ceil(able.late / STEP - 1e-9)
    for _ in range(steps):
        move(motion, asked, able.late / steps, able)
    return motion
