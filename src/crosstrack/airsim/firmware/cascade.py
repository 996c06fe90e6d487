"""The firmware's loops: position asks for a velocity, velocity for an angle, angle for a rate, rate for a torque.

Every axis is its own chain of loops, from the one that its goal names down to the rate. A loop's output is within
[-1, 1] and asks the next loop for that share of its limit. Velocities are compared in the body frame, tilt and all.

**Mistakes of the original, kept** unless `ideal`:

- The goal of a velocity loop is made of the goals of all the axes, whatever they mean. With a velocity sideways and a
  height (moveByVelocityZ), the height counts as a velocity (m/s) down, and a tilt turns some of it forward: above the
  start the vehicle speeds up the more slowly the higher it is, below it ever faster.
- The position loop of an axis turns its own velocity alone into the body frame, and only the part along the same body
  axis counts: with the nose to the east or west, nothing brings a vehicle back to where it should hold.
"""

import math

from crosstrack.airsim.firmware.body import Triple, to_body
from crosstrack.airsim.firmware.rows import (
    ANGLE,
    ANGLE_LOOP,
    DIRECT,
    POSITION,
    POSITION_LOOP,
    RATE_LOOP,
    UNSET,
    VELOCITY,
    VELOCITY_LOOP,
    Rows,
)
from crosstrack.compiled import compiled

SPEED_LIMIT = 6.0
"""m/s, the most that a position loop asks for"""
TILT_LIMIT = math.pi / 5.5
"""rad, the most that a velocity loop asks for"""
RATE_LIMIT = 2.5
"""rad/s, the most that an angle loop asks for"""
FORGETTING = 0.9999
"""what is left, update by update, of the integral of the vertical velocity"""
THROTTLE_MIN = 0.3
"""of the throttle: the least that the vertical velocity loop asks for"""
SHORTEST = 1e-6
"""s, between two updates that integrate"""
XYZ = (1, 0, 2, 2)
"""the component of a vector that an axis is about"""


@compiled
def clip(value: float) -> float:
    """Return the value within [-1, 1]."""
    return min(max(value, -1.0), 1.0)


@compiled
def loop(p: Rows, level: int, axis: int, error: float, dt: float) -> float:
    """Return the output of a PID loop for an error, `dt` (s) after its last one; the first one has dt = 0."""
    integral, slope = p.integral[level, axis], 0.0
    if dt > SHORTEST:
        keep = FORGETTING if level == VELOCITY_LOOP and axis == 3 else 1.0
        integral = clip(integral * keep + dt * error * p.gains[1, level, axis])
        slope = (error - p.error[level, axis]) / dt
        p.integral[level, axis], p.error[level, axis] = integral, error
    return clip(p.gains[0, level, axis] * error + integral + p.gains[2, level, axis] * slope)


@compiled
def nearest(goal: float, angle: float) -> float:
    """Return the difference of two angles (rad) the short way round."""
    error = goal - angle
    return error - 2 * math.pi * math.floor(error / (2 * math.pi) + 0.5)


@compiled
def euler(p: Rows) -> Triple:
    """Return roll, pitch and yaw (rad) of the attitude: about z, then y, then x."""
    x, y, z, w = p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3]
    return (
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(min(max(2 * (w * y - z * x), -1.0), 1.0)),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    )


@compiled
def wanted(p: Rows, axis: int, asked: Triple) -> Triple:
    """Return the velocity (m/s, world) that the velocity loop of an axis is given.

    Args:
        p: the row
        axis: of the firmware
        asked: m/s, along x, y and z, what all the axes mean together
    """
    if p.ideal:
        return asked
    if p.mode[axis] == POSITION:
        k, own = XYZ[axis], p.own[axis]
        return own if k == 0 else 0.0, own if k == 1 else 0.0, own if k == 2 else 0.0
    return p.goal[1], p.goal[0], p.goal[3]


@compiled
def inner(p: Rows, axis: int, mode: int, goal: float, angle: float, dt: float) -> float:
    """Return the torque command of an axis from a goal for its angle or its rate."""
    if mode == ANGLE:
        goal = RATE_LIMIT * loop(p, ANGLE_LOOP, axis, nearest(goal, angle), dt)
    return loop(p, RATE_LOOP, axis, goal - p.rate[axis], dt)


@compiled
def chain(p: Rows, axis: int, angles: Triple, speed: Triple, asked: Triple, dt: float) -> float:
    """Return the output of an axis: the torque command, or the throttle."""
    mode = p.mode[axis]
    if mode in (UNSET, DIRECT):
        return float(p.goal[axis])
    if mode in (VELOCITY, POSITION):
        q = (p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3])
        k = XYZ[axis]
        out = loop(p, VELOCITY_LOOP, axis, to_body(wanted(p, axis, asked), q)[k] - speed[k], dt)
        if axis == 3:
            return max(0.5 * (1 - out), THROTTLE_MIN)
        return inner(p, axis, ANGLE, TILT_LIMIT * (out if axis == 0 else -out), angles[axis], dt)
    return inner(p, axis, mode, p.goal[axis], angles[axis % 3], dt)


@compiled
def restart(p: Rows, axis: int) -> None:
    """Forget what the loops of an axis remember."""
    p.active[axis] = p.mode[axis]
    for level in range(4):
        p.integral[level, axis] = p.error[level, axis] = 0.0


@compiled
def asked_velocity(p: Rows, axis: int) -> float:
    """Return what an axis means as a velocity (m/s, world); zero where it means none."""
    if p.mode[axis] == POSITION:
        return float(p.own[axis])
    return float(p.goal[axis]) if p.mode[axis] == VELOCITY else 0.0


@compiled
def control(p: Rows, now: int) -> None:
    """Set the output of every axis at a time (ms): torque commands of roll, pitch and yaw, and the throttle."""
    dt = 1e-3 * (now - p.time)
    angles = euler(p)
    q = (p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3])
    speed = to_body((p.velocity[0], p.velocity[1], p.velocity[2]), q)
    for axis in range(4):
        p.since[axis] = dt if p.mode[axis] == p.active[axis] else 0.0
        if p.mode[axis] != p.active[axis]:
            restart(p, axis)
        if p.mode[axis] == POSITION:
            error = p.goal[axis] - p.position[XYZ[axis]]
            p.own[axis] = SPEED_LIMIT * loop(p, POSITION_LOOP, axis, error, p.since[axis])
    asked = (asked_velocity(p, 1), asked_velocity(p, 0), asked_velocity(p, 3))
    for axis in range(4):
        p.control[axis] = chain(p, axis, angles, speed, asked, p.since[axis])
    p.time = now
