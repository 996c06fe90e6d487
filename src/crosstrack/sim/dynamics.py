"""The rigid body of a quadrotor and its rotors, stepped by the classical fourth-order Runge-Kutta method.

A body is a tuple of 13 floats: position (m, world), velocity (m/s, world), attitude (xyzw, body to world),
rate (rad/s, body). The four rotor speeds relax to their targets with a first-order lag, which has a closed form,
so thrusts and torques are exact at the stages of the step:

    m dv/dt = R (T e_z + D) - m g e_z + contact        D_i = -(k_i |u_i| + c_i ΣΩ) u_i,  u = Rᵀ (v - wind)
    J dω/dt = τ - ω x J ω                              T = Σ kΩ²,  τ = Σ (y_i T_i, -x_i T_i, spin_i κ T_i)

Rotor drag: Faessler, Franchi, Scaramuzza 2018, eq. 1-3. The gyroscopic torque of the rotors is neglected.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.sim.contact import Rotation, contact
from crosstrack.sim.fleet import Fleet
from crosstrack.types import GRAVITY, Array

Body = tuple[float, float, float, float, float, float, float, float, float, float, float, float, float]
Rotors = tuple[float, float, float, float]
Triple = tuple[float, float, float]
Wrench = tuple[float, float, float, float, float]
"""thrust (N), torques (N m), sum of the rotor speeds (rad/s)"""


@compiled
def rotor_wrench(speeds: Rotors, p: Fleet) -> Wrench:
    """Return what the rotors do to the body at these speeds (rad/s)."""
    a = p.thrust * speeds[0] * speeds[0]
    b = p.thrust * speeds[1] * speeds[1]
    c = p.thrust * speeds[2] * speeds[2]
    d = p.thrust * speeds[3] * speeds[3]
    x, y, spin = p.rotor_x, p.rotor_y, p.spin
    return (
        a + b + c + d,
        y[0] * a + y[1] * b + y[2] * c + y[3] * d,
        -(x[0] * a + x[1] * b + x[2] * c + x[3] * d),
        p.torque_ratio * (spin[0] * a + spin[1] * b + spin[2] * c + spin[3] * d),
        speeds[0] + speeds[1] + speeds[2] + speeds[3],
    )


@compiled
def lagged(speeds: Rotors, targets: Rotors, remaining: float) -> Rotors:
    """Return the rotor speeds once the fraction `remaining` of their distance to the targets is left."""
    return (
        targets[0] + (speeds[0] - targets[0]) * remaining,
        targets[1] + (speeds[1] - targets[1]) * remaining,
        targets[2] + (speeds[2] - targets[2]) * remaining,
        targets[3] + (speeds[3] - targets[3]) * remaining,
    )


@compiled
def rotation(qx: float, qy: float, qz: float, qw: float) -> Rotation:
    """Return the rotation matrix of a unit quaternion, row by row."""
    return (
        1 - 2 * (qy * qy + qz * qz),
        2 * (qx * qy - qz * qw),
        2 * (qx * qz + qy * qw),
        2 * (qx * qy + qz * qw),
        1 - 2 * (qx * qx + qz * qz),
        2 * (qy * qz - qx * qw),
        2 * (qx * qz - qy * qw),
        2 * (qy * qz + qx * qw),
        1 - 2 * (qx * qx + qy * qy),
    )


@compiled
def drag_force(turn: Rotation, ax: float, ay: float, az: float, speed_sum: float, k: Array, c: Array) -> Triple:
    """Return the drag (N, body) at an airspeed (m/s, world) and a sum of the rotor speeds (rad/s).

    Args:
        turn: body to world
        ax: m/s, east
        ay: m/s, north
        az: m/s, up
        speed_sum: rad/s
        k: (3,) N/(m/s)², body drag
        c: (3,) N/((rad/s) (m/s)), rotor drag
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turn
    ux = r00 * ax + r10 * ay + r20 * az
    uy = r01 * ax + r11 * ay + r21 * az
    uz = r02 * ax + r12 * ay + r22 * az
    return (
        -(k[0] * abs(ux) + c[0] * speed_sum) * ux,
        -(k[1] * abs(uy) + c[1] * speed_sum) * uy,
        -(k[2] * abs(uz) + c[2] * speed_sum) * uz,
    )


@compiled
def derivative(body: Body, wrench: Wrench, wind: Triple, p: Fleet) -> Body:
    """Return the time derivative of a body."""
    _, _, pz, vx, vy, vz, qx, qy, qz, qw, wx, wy, wz = body
    thrust, torque_x, torque_y, torque_z, speed_sum = wrench
    turn = rotation(qx, qy, qz, qw)
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = turn
    fx, fy, fz = drag_force(turn, vx - wind[0], vy - wind[1], vz - wind[2], speed_sum, p.body_drag, p.rotor_drag)
    fz += thrust
    gx = gy = gz = 0.0
    if pz < p.ground + 4 * p.gear:
        gx, gy, gz, mx, my, mz = contact(pz, vx, vy, vz, wx, wy, wz, turn, p)
        torque_x += mx
        torque_y += my
        torque_z += mz
    inertia = p.inertia
    jx, jy, jz = inertia[0], inertia[1], inertia[2]
    inverse = p.inverse_inertia
    return (
        vx,
        vy,
        vz,
        (r00 * fx + r01 * fy + r02 * fz + gx) * p.inverse_mass,
        (r10 * fx + r11 * fy + r12 * fz + gy) * p.inverse_mass,
        (r20 * fx + r21 * fy + r22 * fz + gz) * p.inverse_mass - GRAVITY,
        0.5 * (qw * wx + qy * wz - qz * wy),
        0.5 * (qw * wy + qz * wx - qx * wz),
        0.5 * (qw * wz + qx * wy - qy * wx),
        -0.5 * (qx * wx + qy * wy + qz * wz),
        (torque_x + (jy - jz) * wy * wz) * inverse[0],
        (torque_y + (jz - jx) * wz * wx) * inverse[1],
        (torque_z + (jx - jy) * wx * wy) * inverse[2],
    )


@compiled
def moved(body: Body, h: float, rate: Body) -> Body:
    """Return body + h rate."""
    return (
        body[0] + h * rate[0],
        body[1] + h * rate[1],
        body[2] + h * rate[2],
        body[3] + h * rate[3],
        body[4] + h * rate[4],
        body[5] + h * rate[5],
        body[6] + h * rate[6],
        body[7] + h * rate[7],
        body[8] + h * rate[8],
        body[9] + h * rate[9],
        body[10] + h * rate[10],
        body[11] + h * rate[11],
        body[12] + h * rate[12],
    )


@compiled
def step(
    body: Body,
    rotors: Rotors,
    targets: Rotors,
    wind: Triple,
    p: Fleet,
    h: float,
    half_lag: float,
) -> tuple[Body, Rotors]:
    """Return body and rotor speeds a step `h` (s) later; `half_lag` is exp(-h / (2 motor_time))."""
    middle = lagged(rotors, targets, half_lag)
    end = lagged(middle, targets, half_lag)
    wrench = rotor_wrench(middle, p)
    k1 = derivative(body, rotor_wrench(rotors, p), wind, p)
    k2 = derivative(moved(body, 0.5 * h, k1), wrench, wind, p)
    k3 = derivative(moved(body, 0.5 * h, k2), wrench, wind, p)
    k4 = derivative(moved(body, h, k3), rotor_wrench(end, p), wind, p)
    body = moved(moved(moved(moved(body, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4)
    scale = 1.0 / math.sqrt(body[6] ** 2 + body[7] ** 2 + body[8] ** 2 + body[9] ** 2)
    normalised = body[:6] + (body[6] * scale, body[7] * scale, body[8] * scale, body[9] * scale) + body[10:]
    return normalised, end
