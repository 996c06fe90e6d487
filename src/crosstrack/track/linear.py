"""What a quadrotor under rate control does near a reference, in the body axes of the reference, linearised."""

import math

from crosstrack.compiled import compiled
from crosstrack.track.approach import affordable
from crosstrack.track.attitude import (
    Axes,
    Triple,
    axes_for,
    dot,
    drag_while,
    easing_of,
    rate_along,
    seen,
)
from crosstrack.track.reference import Motion, motion
from crosstrack.types import GRAVITY, Array

STATES, INPUTS = 15, 4
"""Errors of position (m), velocity (m/s), attitude (rad), rate (rad/s) and the integral of position (m s), three each;
rates (rad/s) and thrust (m/s²) beyond those of the reference."""

Flying = tuple[Axes, Triple, Triple]
"""Body axes, thrust vector (m/s², world) and body rates (rad/s) of a reference."""


@compiled
def flying(at: Motion, limits: Triple, linear: Array, square: Array) -> Flying:
    """Return what a motion needs in still air, as far as the limits allow.

    Args:
        at: the motion
        limits: see `approach.limits_of`
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
    """
    need, air = (at[6], at[7], at[8] + GRAVITY), (at[3], at[4], at[5])
    axes = axes_for(need, at[15])
    for _ in range(2):
        drag = drag_while(axes, air, need, linear, square)
        f = affordable((need[0] - drag[0], need[1] - drag[1], need[2] - drag[2]), limits)
        axes = axes_for(f, at[15])
    easing = easing_of(axes, air, (at[6], at[7], at[8]), math.sqrt(math.sqrt(dot(f, f)) / GRAVITY), linear, square)
    change = (at[9] - easing[0], at[10] - easing[1], at[11] - easing[2])
    return axes, f, rate_along(axes, f, change, at[15], at[16])


@compiled
def dynamics(
    thrust: float, rate: Triple, air: Triple, lag: float, linear: Array, square: Array, a: Array, b: Array
) -> None:
    """Fill A (15, 15) and B (15, 4) of x' = A x + B u about a reference, see STATES and INPUTS.

    With the thrust c and the drag F(u), J = dF/du, of the airspeed u, the rates ω and the lag τ of the rate loop,

        p' = v - ω × p,    v' = -ω × v + θ × (c e_z + F) - J (θ × u) + J v + u_c e_z,
        θ' = w,            w' = (u_w - w) / τ - ω × w,                          i' = p - ω × i.

    Args:
        thrust: m/s²
        rate: rad/s, body
        air: m/s, body
        lag: s
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
        a: (15, 15)
        b: (15, 4)
    """
    a[:], b[:] = 0.0, 0.0
    for block in (0, 3, 9, 12):
        add_cross(a, block, block, rate, -1.0)
    effort = math.sqrt(max(0.0, thrust) / GRAVITY)
    slope = (
        -(effort * linear[0] + 2 * square[0] * abs(air[0])),
        -(effort * linear[1] + 2 * square[1] * abs(air[1])),
        -(effort * linear[2] + 2 * square[2] * abs(air[2])),
    )
    force = (
        -(effort * linear[0] + square[0] * abs(air[0])) * air[0],
        -(effort * linear[1] + square[1] * abs(air[1])) * air[1],
        thrust - (effort * linear[2] + square[2] * abs(air[2])) * air[2],
    )
    add_cross(a, 3, 6, air, 1.0)
    for i in range(3):
        for j in range(6, 9):
            a[3 + i, j] *= slope[i]
        a[i, 3 + i] = a[6 + i, 9 + i] = a[12 + i, i] = 1.0
        a[3 + i, 3 + i] = slope[i]
        a[9 + i, 9 + i] = -1.0 / lag
        b[9 + i, i] = 1.0 / lag
    add_cross(a, 3, 6, force, -1.0)
    b[5, 3] = 1.0


@compiled
def add_cross(a: Array, row: int, column: int, vector: Triple, factor: float) -> None:
    """Add the factor times the matrix of x ↦ vector × x to a block of `a`."""
    x, y, z = vector
    a[row, column + 1] -= factor * z
    a[row, column + 2] += factor * y
    a[row + 1, column] += factor * z
    a[row + 1, column + 2] -= factor * x
    a[row + 2, column] -= factor * y
    a[row + 2, column + 1] += factor * x


@compiled
def dynamics_along(
    rows: Array,
    period: float,
    limits: Triple,
    lag: float,
    linear: Array,
    square: Array,
    thrusts: Array,
    a: Array,
    b: Array,
) -> None:
    """Fill thrusts (steps,), A (steps, 15, 15) and B (steps, 15, 4) in the middle of each step (s) of a stretch."""
    for k in range(a.shape[0]):
        at = motion(rows, (k + 0.5) * period)
        axes, f, rate = flying(at, limits, linear, square)
        thrusts[k] = math.sqrt(dot(f, f))
        dynamics(thrusts[k], rate, seen(axes, (at[3], at[4], at[5])), lag, linear, square, a[k], b[k])
