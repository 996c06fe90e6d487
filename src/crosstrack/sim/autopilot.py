"""The cascaded autopilot: position, velocity, attitude, rate, mixer; each loop asks the next one in.

velocity       v* = v_ff + k_p (p* - p)
acceleration   a* = a_ff + k_v (v* - v)
disturbance    d = k_d (v - v̂), dv̂/dt = thrust - g e_z + D + d: what thrust and drag D in still air leave unexplained
thrust vector  f* = a* + g e_z - D_xy - d, height before sideways motion, tilt limited; thrust f*·b_z - D_z
(Faessler, Franchi and Scaramuzza 2018: drag along body z needs no tilt)
rate           ω* = 2 k_a sin(θ/2) along the tilt error θ, 2 k_ψ sin(ψ/2) along the yaw error ψ
(Brescianini and D'Andrea 2018, reduced and full attitude control)
torque         τ* = J k_r (ω* - ω) + ω x J ω
rotor thrusts  roll and pitch first, then collective thrust, then yaw
"""

import math

from crosstrack.compiled import compiled
from crosstrack.sim.dynamics import Body, Rotors, Triple, drag_force, rotation, rotor_wrench
from crosstrack.sim.fleet import ATTITUDE, MOTION, RATE, Fleet
from crosstrack.types import GRAVITY

LEAST_LIFT = 0.3
"""of gravity: the least vertical thrust asked for, so that attitude control keeps its authority"""
MOST_THRUST = 0.92
"""of the greatest thrust: the rest is left to roll and pitch"""
DISTURBANCE_MAX = 5.0
"""m/s², the steady disturbance that is held off on each axis"""


Axis = tuple[float, float, float, float]
"""Velocity asked for is base - slope * position; then whether velocity is controlled at all, and acceleration."""
Quadruple = tuple[float, float, float, float]
Demand = tuple[Axis, Axis, Axis, Triple, int, Quadruple, float, float, float, float]
"""Axes, velocity error of the estimate, level, attitude or rate, thrust or yaw rate, half-yaw sine and cosine, yaw."""


@compiled
def axis(target: float, feed: float, acceleration: float, error: float, p: Fleet) -> Axis:
    """Return what is asked of one axis; one that is given an acceleration alone is flown open loop."""
    forward = 0.0 if math.isnan(feed) else feed
    push = 0.0 if math.isnan(acceleration) else acceleration
    if not math.isnan(target):
        return forward + p.gain_position * (target - error), p.gain_position, 1.0, push
    closed = 0.0 if math.isnan(feed) and not math.isnan(acceleration) else 1.0
    return forward, 0.0, closed, push


@compiled
def demand(p: Fleet) -> Demand:
    """Return what a command asks for, in the form that the loops use at every step."""
    c, e = p.command, p.error
    yaw = p.yaw if math.isnan(c[9]) or p.level != MOTION else c[9]
    spin = 0.0 if math.isnan(c[10]) else c[10]
    velocity_error = (e[3], e[4], e[5])
    if p.level == MOTION:
        x, y, z = (
            axis(c[0], c[3], c[6], e[0], p),
            axis(c[1], c[4], c[7], e[1], p),
            axis(c[2], c[5], c[8], e[2], p),
        )
        asked = (0.0, 0.0, 0.0, 0.0)
    else:
        x = y = z = (0.0, 0.0, 0.0, 0.0)
        asked = (c[0], c[1], c[2], c[3])
        spin = c[4]
    return x, y, z, velocity_error, p.level, asked, spin, math.sin(0.5 * yaw), math.cos(0.5 * yaw), yaw


@compiled
def disturbance(body: Body, error: Triple, expected: Triple, p: Fleet) -> Triple:
    """Return the acceleration (m/s²) that thrust and known drag do not explain: wind, body drag, wrong mass."""
    gain = p.gain_disturbance
    x = gain * (body[3] + error[0] - expected[0])
    y = gain * (body[4] + error[1] - expected[1])
    z = gain * (body[5] + error[2] - expected[2])
    most = DISTURBANCE_MAX
    return min(most, max(-most, x)), min(most, max(-most, y)), min(most, max(-most, z))


@compiled
def acceleration_wanted(body: Body, x: Axis, y: Axis, z: Axis, error: Triple, p: Fleet) -> Triple:
    """Return the acceleration asked for (m/s², gravity excluded), as if in empty space."""
    vx, vy, vz = x[0] - x[1] * body[0], y[0] - y[1] * body[1], z[0] - z[1] * body[2]
    square = vx * vx + vy * vy + vz * vz
    if square > p.speed_max * p.speed_max:
        scale = p.speed_max / math.sqrt(square)
        vx, vy, vz = vx * scale, vy * scale, vz * scale
    ex = x[2] * (vx - body[3] - error[0])
    ey = y[2] * (vy - body[4] - error[1])
    ez = z[2] * (vz - body[5] - error[2])
    k = p.gain_velocity
    return x[3] + k * ex, y[3] + k * ey, z[3] + k * ez


@compiled
def thrust_vector(ax: float, ay: float, az: float, p: Fleet) -> Triple:
    """Return the specific force (m/s², world) nearest to an acceleration that tilt and thrust allow, height first."""
    most = MOST_THRUST * 4 * p.thrust_max / p.known_mass
    lift = min(most, max(LEAST_LIFT * GRAVITY, az + GRAVITY))
    sideways = math.sqrt(ax * ax + ay * ay)
    room = min(lift * p.tilt_tangent, math.sqrt(max(0.0, most * most - lift * lift)))
    scale = room / sideways if sideways > room else 1.0
    return ax * scale, ay * scale, lift


@compiled
def attitude_wanted(fx: float, fy: float, fz: float, sine: float, cosine: float) -> Quadruple:
    """Return the attitude (xyzw) whose z axis points along a force: a yaw (half-angle given), then the least tilt."""
    inverse = 1.0 / math.sqrt(fx * fx + fy * fy + fz * fz)
    w = math.sqrt(0.5 + 0.5 * fz * inverse)
    half = 0.5 * inverse / w
    x, y = -fy * half, fx * half
    return x * cosine + y * sine, y * cosine - x * sine, w * sine, w * cosine


@compiled
def rate_wanted(body: Body, qx: float, qy: float, qz: float, qw: float, p: Fleet) -> Triple:
    """Return the body rate (rad/s) that turns the body to an attitude: tilt by the shortest way, yaw apart."""
    bx, by, bz, bw = -body[6], -body[7], -body[8], body[9]
    ex = bw * qx + bx * qw + by * qz - bz * qy
    ey = bw * qy + by * qw + bz * qx - bx * qz
    ez = bw * qz + bz * qw + bx * qy - by * qx
    ew = bw * qw - bx * qx - by * qy - bz * qz
    # The error is a yaw, then a tilt; the wanted z axis, seen from the body, shows the tilt alone.
    zx, zy = 2 * (ex * ez + ey * ew), 2 * (ey * ez - ex * ew)
    half = math.sqrt(max(1e-12, ew * ew + ez * ez))
    scale = p.gain_attitude / half
    tilt = scale * math.sqrt(zx * zx + zy * zy)
    if tilt > p.max_rate:
        scale *= p.max_rate / tilt
    turn = 2 * p.gain_yaw * (ez if ew >= 0 else -ez) / half
    return -zy * scale, zx * scale, min(p.max_rate_yaw, max(-p.max_rate_yaw, turn))


@compiled
def mix(thrust: float, tx: float, ty: float, tz: float, p: Fleet) -> Quadruple:
    """Return the rotor thrusts (N) for a thrust (N) and torques (N m); what does not fit goes in order of need.

    Roll and pitch are scaled down together only if they alone exceed the range of the rotors; collective thrust is
    the nearest to the one asked for that leaves room for them; yaw takes what room is left. What fits is exact.
    Opposite rotors share collective and yaw: c ± a - u for the first two, c ± b + u for the others.
    """
    low, high, rows = p.thrust_min, p.thrust_max, p.allocation
    a = rows[0, 1] * tx + rows[0, 2] * ty
    b = rows[2, 1] * tx + rows[2, 2] * ty
    widest = max(abs(a), abs(b))
    if 2 * widest > high - low:
        scale = 0.5 * (high - low) / widest
        a, b = a * scale, b * scale
    wide_a, wide_b, u = abs(a), abs(b), rows[2, 3] * tz
    first, last = min(0.0, u), max(0.0, u)
    raised = min(last, max(first, 0.5 * (wide_b - wide_a)))
    lowered = min(last, max(first, 0.5 * (wide_a - wide_b)))
    least = low + max(wide_a + raised, wide_b - raised)
    most = high - max(wide_a - lowered, wide_b + lowered)
    c = min(most, max(least, 0.25 * thrust))
    u = min(min(c - low - wide_a, high - c - wide_b), max(max(low - c + wide_b, c - high + wide_a), u))
    return c + a - u, c - a - u, c + b + u, c - b + u


@compiled
def pursue(body: Body, rotors: Rotors, asked: Demand, expected: Triple, h: float, p: Fleet) -> tuple[Quadruple, Triple]:
    """Return body rate (rad/s) and collective thrust (m/s²) to ask for: the outer loops.

    Returns:
        rate and thrust; the velocity expected a time `h` later, by which the disturbance is known
    """
    x, y, z, error, level, given, extra, sine, cosine, _ = asked
    upset = disturbance(body, error, expected, p)
    vx, vy, vz = body[3] + error[0], body[4] + error[1], body[5] + error[2]
    turn = rotation(body[6], body[7], body[8], body[9])
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turn
    pull, _, _, _, speed_sum = rotor_wrench(rotors, p)
    dx, dy, dz = drag_force(turn, vx, vy, vz, speed_sum, p.known_body_drag, p.known_rotor_drag)
    sx, sy = dx * p.known_inverse_mass, dy * p.known_inverse_mass
    lift = (pull + dz) * p.known_inverse_mass
    slack = h - 1.0 / p.gain_disturbance
    expected = (
        vx + h * (r00 * sx + r01 * sy + r02 * lift) + slack * upset[0],
        vy + h * (r10 * sx + r11 * sy + r12 * lift) + slack * upset[1],
        vz + h * (r20 * sx + r21 * sy + r22 * lift - GRAVITY) + slack * upset[2],
    )
    if level == RATE:
        return given, expected
    if level == ATTITUDE:
        wx, wy, wz = rate_wanted(body, given[0], given[1], given[2], given[3], p)
        return (wx, wy, wz, extra), expected
    ax, ay, az = acceleration_wanted(body, x, y, z, error, p)
    fx, fy, fz = thrust_vector(
        ax - r00 * sx - r01 * sy - upset[0],
        ay - r10 * sx - r11 * sy - upset[1],
        az - r20 * sx - r21 * sy - upset[2],
        p,
    )
    qx, qy, qz, qw = attitude_wanted(fx, fy, fz, sine, cosine)
    wx, wy, wz = rate_wanted(body, qx, qy, qz, qw, p)
    # Drag along body z needs no tilt: the collective thrust meets it alone.
    return (wx, wy, wz + extra, fx * r02 + fy * r12 + fz * r22 - dz * p.known_inverse_mass), expected


@compiled
def spin_rotors(body: Body, rate: Quadruple, p: Fleet) -> Quadruple:
    """Return the rotor speeds (rad/s) that turn the body at a rate and push it with a thrust: rate loop and mixer."""
    wx, wy, wz, thrust = rate
    jx, jy, jz = p.inertia[0], p.inertia[1], p.inertia[2]
    bx, by, bz = body[10], body[11], body[12]
    tx = jx * p.gain_rate * (wx - bx) + (jz - jy) * by * bz
    ty = jy * p.gain_rate * (wy - by) + (jx - jz) * bz * bx
    tz = jz * p.gain_rate_yaw * (wz - bz) + (jy - jx) * bx * by
    a, b, c, d = mix(p.known_mass * thrust, tx, ty, tz, p)
    k = 1.0 / p.thrust
    return math.sqrt(a * k), math.sqrt(b * k), math.sqrt(c * k), math.sqrt(d * k)
