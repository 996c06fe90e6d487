"""From the force that a motion needs to the body rates and the thrust that give it."""

import math

from crosstrack.compiled import compiled
from crosstrack.types import GRAVITY, Array

Triple = tuple[float, float, float]
Axes = tuple[float, float, float, float, float, float, float, float, float]
"""Body axes in the world, x then y then z."""


@compiled
def axes_of(attitude: Array) -> Axes:
    """Return the body axes of an attitude xyzw."""
    x, y, z, w = attitude[0], attitude[1], attitude[2], attitude[3]
    return (
        1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
        2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y),
    )  # fmt: skip


@compiled
def dot(a: Triple, b: Triple) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def seen(axes: Axes, vector: Triple) -> Triple:
    """Return a vector of the world in body axes."""
    return dot(axes[0:3], vector), dot(axes[3:6], vector), dot(axes[6:9], vector)


@compiled
def world(axes: Axes, vector: Triple) -> Triple:
    """Return a vector in body axes in the world."""
    x, y, z = vector
    return (
        axes[0] * x + axes[3] * y + axes[6] * z,
        axes[1] * x + axes[4] * y + axes[7] * z,
        axes[2] * x + axes[5] * y + axes[8] * z,
    )


@compiled
def drag_of(axes: Axes, air: Triple, effort: float, linear: Array, square: Array) -> Triple:
    """Return the acceleration (m/s², world) by drag of the nominal model, see `types.Model`.

    Args:
        axes: body axes
        air: m/s, world, airspeed
        effort: rotor speed over that at hover, √(c/g)
        linear: (3,) 1/s
        square: (3,) 1/m
    """
    x, y, z = seen(axes, air)
    along = (
        -(effort * linear[0] + square[0] * abs(x)) * x,
        -(effort * linear[1] + square[1] * abs(y)) * y,
        -(effort * linear[2] + square[2] * abs(z)) * z,
    )
    return world(axes, along)


@compiled
def drag_while(axes: Axes, air: Triple, need: Triple, linear: Array, square: Array) -> Triple:
    """Return the acceleration (m/s², world) by drag while the thrust meets it and `need` (m/s², gravity included).

    Drag and thrust depend on one another; the second round is within a percent.
    """
    drag = (0.0, 0.0, 0.0)
    for _ in range(2):
        left = (need[0] - drag[0], need[1] - drag[1], need[2] - drag[2])
        drag = drag_of(axes, air, math.sqrt(max(0.0, dot(left, axes[6:9])) / GRAVITY), linear, square)
    return drag


@compiled
def easing_of(axes: Axes, air: Triple, change: Triple, effort: float, linear: Array, square: Array) -> Triple:
    """Return how fast drag changes (m/s³, world) while the airspeed changes (m/s²): ∂D/∂u along the body axes."""
    x, y, z = seen(axes, air)
    changed = seen(axes, change)
    along = (
        -(effort * linear[0] + 2 * square[0] * abs(x)) * changed[0],
        -(effort * linear[1] + 2 * square[1] * abs(y)) * changed[1],
        -(effort * linear[2] + 2 * square[2] * abs(z)) * changed[2],
    )
    return world(axes, along)


@compiled
def axes_for(f: Triple, yaw: float) -> Axes:
    """Return the body axes whose z points along a force, with the horizontal part of x along a yaw (rad).

    y_C = (-sin ψ, cos ψ, 0), x_B = unit(y_C × z_B), y_B = z_B × x_B (Faessler, Franchi, Scaramuzza 2018, eq. 13-15).
    """
    inverse = 1.0 / math.sqrt(dot(f, f))
    z = (f[0] * inverse, f[1] * inverse, f[2] * inverse)
    c, s = math.cos(yaw), math.sin(yaw)
    xx, xy, xz = c * z[2], s * z[2], -s * z[1] - c * z[0]
    inverse = 1.0 / math.sqrt(max(1e-12, xx * xx + xy * xy + xz * xz))
    x = (xx * inverse, xy * inverse, xz * inverse)
    return (
        x[0], x[1], x[2],
        z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0],
        z[0], z[1], z[2],
    )  # fmt: skip


@compiled
def rate_along(axes: Axes, f: Triple, change: Triple, yaw: float, yaw_rate: float) -> Triple:
    """Return the body rates (rad/s) that keep z along a force (m/s²) that changes (m/s³), and x at a yaw (rad).

    ω_x = -y_B · f' / |f|,  ω_y = x_B · f' / |f|,  ω_z = (ω_y z_B · y_C + ψ' x_B · x_C) / (y_B · y_C), the last from
    x_B · y_C = 0 at all times.
    """
    x, y, z = axes[0:3], axes[3:6], axes[6:9]
    inverse = 1.0 / math.sqrt(dot(f, f))
    wx, wy = -dot(y, change) * inverse, dot(x, change) * inverse
    c, s = math.cos(yaw), math.sin(yaw)
    beside = y[1] * c - y[0] * s
    wz = (wy * (z[1] * c - z[0] * s) + yaw_rate * (x[0] * c + x[1] * s)) / beside if beside > 1e-3 else 0.0
    return wx, wy, wz


@compiled
def error_of(axes: Axes, wanted: Axes) -> Triple:
    """Return the attitude error e = ½ (R_dᵀ R - Rᵀ R_d)^∨ (Lee, Leok, McClamroch 2010, eq. 10), 1."""
    x, y, z = axes[0:3], axes[3:6], axes[6:9]
    u, v, w = wanted[0:3], wanted[3:6], wanted[6:9]
    return 0.5 * (dot(w, y) - dot(v, z)), 0.5 * (dot(u, z) - dot(w, x)), 0.5 * (dot(v, x) - dot(u, y))


@compiled
def capped(rate: Triple, most: float) -> Triple:
    """Return body rates whose roll and pitch are together, and whose yaw is, at most `most` (rad/s)."""
    tilt = math.sqrt(rate[0] * rate[0] + rate[1] * rate[1])
    scale = most / tilt if tilt > most else 1.0
    return rate[0] * scale, rate[1] * scale, min(most, max(-most, rate[2]))
