"""What a command of any level asks of a vehicle: an acceleration."""

import math

import numpy as np

from crosstrack.avoid.safety_motion import Ability
from crosstrack.compiled import compiled
from crosstrack.types import GRAVITY, Array, AttitudeSetpoint, Command, RateSetpoint, Setpoint, State
from crosstrack.vectors import limited

POSITION_GAIN = 1.6
"""1/s, of an autopilot, as is usual"""
VELOCITY_GAIN = 4.0
"""1/s, of an autopilot, as is usual"""
UPRIGHT = math.cos(math.radians(80.0))
"""least cosine of the tilt from which the thrust is sure to be turned against the motion in time"""
FALL = np.array([0.0, 0.0, GRAVITY])


def asked_by(command: Command, state: State, able: Ability, period: float) -> Array:
    """Return the acceleration (3,) m/s² that a command asks for, by the end of the period (s) at the latest."""
    if isinstance(command, Setpoint):
        return answered(state.position, state.velocity, command.position, command.velocity, command.acceleration, able)
    return limited(
        command.thrust * thrust_axis(command, state, period + able.turn_time + able.spin_time) - FALL, 3.0 * GRAVITY
    )


@compiled
def answered(position: Array, velocity: Array, place: Array, feed: Array, push: Array, able: Ability) -> Array:
    """Return the acceleration (3,) m/s² by which an autopilot answers a setpoint; NaN components are left to it.

    u = push + k_v (v* - velocity), v* = feed + k_p (place - position), at most what speed, tilt and thrust allow.
    What is given an acceleration alone is flown open loop, and what is given nothing is brought to rest.

    Args:
        position: (3,) m, of the vehicle
        velocity: (3,) m/s, of the vehicle
        place: (3,) m, asked for
        feed: (3,) m/s, asked for
        push: (3,) m/s², asked for
        able: what the vehicle is able to
    """
    out, goal, closed = np.empty(3), np.zeros(3), np.zeros(3)
    for k in range(3):
        pushed = not math.isnan(push[k])
        out[k] = push[k] if pushed else 0.0
        if not math.isnan(place[k]) or not math.isnan(feed[k]) or not pushed:
            closed[k] = VELOCITY_GAIN
            goal[k] = 0.0 if math.isnan(feed[k]) else feed[k]
            if not math.isnan(place[k]):
                goal[k] += POSITION_GAIN * (place[k] - position[k])
    goal = limited(goal, able.speed)
    for k in range(3):
        out[k] = min(1e6, max(-1e6, out[k] + closed[k] * (goal[k] - velocity[k])))
    clip(out, able)
    return out


@compiled
def clip(asked: Array, able: Ability) -> None:
    """Shorten an acceleration (3,) m/s² to what thrust and tilt give, height first, in place."""
    lift = min(able.thrust_max, max(able.thrust_min, asked[2] + GRAVITY))
    room = math.sqrt(max(0.0, able.thrust_max * able.thrust_max - lift * lift))
    if lift > 0.0:
        room = min(room, lift * able.tilt_tangent)
    side = math.sqrt(asked[0] * asked[0] + asked[1] * asked[1])
    if side > room:
        asked[0] *= room / side
        asked[1] *= room / side
    asked[2] = lift - GRAVITY


def thrust_axis(command: AttitudeSetpoint | RateSetpoint, state: State, ahead: float) -> Array:
    """Return the unit vector (3,) along which a command turns the thrust within a time (s)."""
    if isinstance(command, AttitudeSetpoint):
        return up(command.attitude)
    fastest = command.rate if command.rate @ command.rate > state.rate @ state.rate else state.rate
    angle = fastest * ahead
    size = float(np.linalg.norm(angle))
    turn = np.array([*(angle / max(size, 1e-12) * math.sin(0.5 * size)), math.cos(0.5 * size)])
    return up(product(state.attitude, turn))


def up(attitude: Array) -> Array:
    """Return the body z axis in the world of a unit quaternion."""
    x, y, z, w = attitude.tolist()
    return np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])


def product(a: Array, b: Array) -> Array:
    """Return the quaternion product a b."""
    (ax, ay, az, aw), (bx, by, bz, bw) = a.tolist(), b.tolist()
    return np.array(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def keeps_upright(command: Command, state: State, ahead: float) -> bool:
    """Return whether a command leaves the thrust where it can be turned against the motion, a time (s) from now."""
    if isinstance(command, Setpoint):
        return True
    return bool(thrust_axis(command, state, ahead)[2] >= UPRIGHT)
