"""Served vehicles as rows of one structured array: where each is, what its firmware remembers, what it is told.

World NED relative to the place where the vehicle started, body FRD, quaternions xyzw. Axes of the firmware are in its
own order: roll (or y), pitch (or x), yaw, throttle (or z).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

UNSET, DIRECT, ANGLE, RATE, VELOCITY, POSITION = range(6)
"""What the goal of an axis is: nothing yet, the output itself, an angle, a rate, a velocity, a position."""

POSITION_LOOP, VELOCITY_LOOP, ANGLE_LOOP, RATE_LOOP = range(4)
"""The loops of an axis, from the outermost: rows of the gains."""

INACTIVE, ARMING, ARMED, DISARMING, DISARMED = range(5)
"""Whether the sticks may fly it."""

ROW = np.dtype(
    [
        # Where it is: what AirSim calls ground truth.
        ("position", float, 3),  # m
        ("velocity", float, 3),  # m/s, world
        ("attitude", float, 4),  # xyzw, body to world
        ("rate", float, 3),  # rad/s, body
        ("acceleration", float, 3),  # m/s², world
        ("spin_up", float, 3),  # rad/s², body
        ("altitude", float),  # m, of the place where it started
        ("grounded", np.bool_),  # stuck to the ground until the rotors lift its weight
        # Its rotors: front right, rear left, front left, rear right.
        ("signal", float, 4),  # 0 to 1, asked for by the firmware
        ("filtered", float, 4),  # 0 to 1, behind the lag
        ("output", float, 4),  # 0 to 1, what gives thrust in the next step
        # A contact to respond to, found since the last call of the kernel.
        ("touched", np.bool_),
        ("contact_normal", float, 3),  # unit vector, world, away from what was hit
        ("contact_point", float, 3),  # m
        ("contact_position", float, 3),  # m, of the vehicle when it touched
        ("contact_depth", float),  # m
        # What its firmware is told.
        ("goal", float, 4),
        ("mode", np.int64, 4),
        ("goal_time", np.int64),  # ms, when it was last told
        ("controlled", np.bool_),  # by the API rather than by the sticks
        ("channels", float, 6),  # sticks: roll, pitch, yaw, throttle; switches 0 and 1
        ("connected", np.bool_),  # whether there are sticks
        ("gains", float, (3, 4, 4)),  # proportional, integral, derivative; loop; axis
        ("ideal", np.bool_),  # without the known mistakes
        # What its firmware remembers.
        ("time", np.int64),  # ms, of its last update
        ("active", np.int64, 4),  # the mode of each axis at its last update
        ("integral", float, (4, 4)),  # loop, axis
        ("error", float, (4, 4)),  # at the last update; loop, axis
        ("own", float, 4),  # m/s, what the position loop of an axis asks for
        ("since", float, 4),  # s, since the loops of an axis were last updated
        ("control", float, 4),  # torque commands and throttle
        ("timed_out", np.bool_),  # holding its position for want of commands
        ("flying", np.bool_),  # by its own judgement
        ("armed", np.int64),
        ("stick_goal", float, 4),
        ("stick_mode", np.int64, 4),
        ("stick_time", np.int64),  # ms, when the sticks were last read
        ("stick_switch", float),  # between angles and rates, when last read; NaN before
        ("request_time", np.int64),  # ms, for how long the sticks have asked for arming or disarming
    ]
)

Rows = Any
"""An array of ROW, or one row: compiled code reads the fields of a row as attributes."""


def gains() -> NDArray[np.float64]:
    """Return the gains that the firmware begins with, (3, 4, 4): proportional, integral, derivative; loop; axis."""
    out = np.zeros((3, 4, 4))
    out[0, POSITION_LOOP] = 0.25, 0.25, 0.0, 0.25
    out[0, VELOCITY_LOOP] = 0.2, 0.2, 0.0, 2.0
    out[1, VELOCITY_LOOP] = 0.0, 0.0, 0.0, 2.0
    out[0, ANGLE_LOOP] = 2.5, 2.5, 2.5, 1.0
    out[0, RATE_LOOP] = 0.25, 0.25, 0.25, 1.0
    return out


STANDARD_MODE = (ANGLE, ANGLE, RATE, DIRECT)
"""of the sticks, unless a switch says rates"""
RATE_MODE = (RATE, RATE, RATE, DIRECT)
HOLD_MODE = (POSITION, POSITION, RATE, POSITION)


def reset(rows: Rows, index: int, time: int, armed: int = ARMED) -> None:
    """Put one vehicle back to where it started, level and at rest, with its firmware as switched on.

    Its gains are kept. Its nose is north: set `attitude` where that is not so.

    Args:
        rows: (n,) of ROW
        index: which of them
        time: ms, on the firmware's clock
        armed: whether the sticks may fly it at once
    """
    fresh = np.zeros(1, ROW)
    for name in ("altitude", "gains", "ideal"):
        fresh[name] = rows[name][index]
    fresh["attitude"] = 0.0, 0.0, 0.0, 1.0
    fresh["time"] = fresh["goal_time"] = time
    fresh["armed"], fresh["stick_switch"] = armed, np.nan
    fresh["mode"] = fresh["stick_mode"] = STANDARD_MODE
    rows[index] = fresh[0]


def blank(count: int = 1) -> "np.ndarray[Any, np.dtype[np.void]]":
    """Return `count` vehicles at rest where they start, shape (count,)."""
    rows = np.zeros(count, ROW)
    rows["gains"] = gains()
    for index in range(count):
        reset(rows, index, 0)
    return rows
