"""AirSim's rigid body: rotors behind a lag, drag on six faces, velocity Verlet.

With the forces at the start of a step of h, and the acceleration a⁻ that the step before ended with,

    v̄ = v + a⁻ h / 2,  a = F(v̄) / m + g,  v' = v + (a⁻ + a) h / 2,  p' = p + v̄ h,

and likewise for the rotation, whose mean rate turns the attitude. Drag is taken at the mean velocity. Positions are of
single precision, as AirSim's: ten metres from the start a vehicle slower than 0.16 mm/s does not move at all, and
moves that wait for the last creeping to end come to an end by that.
"""

import math

import numpy as np

from crosstrack.airsim.firmware import airframe
from crosstrack.airsim.firmware.air import SEA_LEVEL_DENSITY, density
from crosstrack.airsim.firmware.rows import Rows
from crosstrack.compiled import compiled
from crosstrack.types import GRAVITY

Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

THRUST_MAX, TORQUE_MAX = airframe.THRUST_MAX, airframe.TORQUE_MAX
ROTOR_X, ROTOR_Y, SPIN = airframe.ROTOR_X, airframe.ROTOR_Y, airframe.SPIN
DRAG, BOX = airframe.DRAG, airframe.BOX
MASS, INERTIA = airframe.MASS, airframe.INERTIA
DRAG_SPEED_MIN = airframe.DRAG_SPEED_MIN


@compiled
def to_world(v: Triple, q: Quaternion) -> Triple:
    """Turn a vector by a unit quaternion xyzw."""
    x, y, z, w = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


@compiled
def to_body(v: Triple, q: Quaternion) -> Triple:
    """Turn a vector by the inverse of a unit quaternion xyzw."""
    return to_world(v, (-q[0], -q[1], -q[2], q[3]))


@compiled
def cross(a: Triple, b: Triple) -> Triple:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def rotor_wrench(p: Rows, ratio: float) -> tuple[float, float, float, float]:
    """Return thrust (N, against body z) and torques (N m, body) of the rotors in air of a density ratio."""
    thrust = roll = pitch = yaw = 0.0
    for k in range(4):
        force = THRUST_MAX * ratio * p.output[k]
        thrust += force
        roll -= ROTOR_Y[k] * force
        pitch += ROTOR_X[k] * force
        yaw -= SPIN[k] * TORQUE_MAX * ratio * p.output[k]
    return thrust, roll, pitch, yaw


@compiled
def spin(p: Rows, keep: float) -> None:
    """Advance the rotors by one step: what the lag held before gives thrust after the next force is taken."""
    for k in range(4):
        p.output[k] = p.filtered[k]
        p.filtered[k] = keep * p.filtered[k] + (1 - keep) * p.signal[k]


@compiled
def face(speed: float, area: float, air_density: float) -> float:
    """Return the drag (N) on the face that a speed across it drives into the air; the other one has none."""
    return -area * air_density * speed * abs(speed) if abs(speed) > DRAG_SPEED_MIN else 0.0


@compiled
def drag(u: Triple, air_density: float) -> Triple:
    """Return the force (N, body) of the air on the six faces at a velocity (body).

    A face is a point at the middle of its side: it moves along its normal as the centre does, whatever the rotation,
    and its force passes through the centre.
    """
    return face(u[0], DRAG[0], air_density), face(u[1], DRAG[1], air_density), face(u[2], DRAG[2], air_density)


@compiled
def turned(q: Quaternion, w: Triple, h: float) -> Quaternion:
    """Return the attitude after turning at a body rate (rad/s) for h (s)."""
    rate = math.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    if rate == 0:
        return q
    s, c = math.sin(0.5 * rate * h) / rate, math.cos(0.5 * rate * h)
    a, b, d = w[0] * s, w[1] * s, w[2] * s
    x, y, z, v = q
    nx, ny = v * a + x * c + y * d - z * b, v * b - x * d + y * c + z * a
    nz, nw = v * d + x * b - y * a + z * c, v * c - x * a - y * b - z * d
    n = 1 / math.sqrt(nx * nx + ny * ny + nz * nz + nw * nw)
    return nx * n, ny * n, nz * n, nw * n


@compiled
def accelerations(p: Rows, v: Triple, w: Triple, wind: Triple, push: Triple) -> tuple[Triple, Triple]:
    """Return the accelerations (m/s², world; rad/s², body) in free flight at a velocity and a rate."""
    q = (p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3])
    air_density = density(p.altitude - p.position[2])
    thrust, roll, pitch, yaw = rotor_wrench(p, air_density / SEA_LEVEL_DENSITY)
    fx, fy, fz = drag(to_body((v[0] - wind[0], v[1] - wind[1], v[2] - wind[2]), q), air_density)
    force = to_world((fx, fy, fz - thrust), q)
    momentum = (INERTIA[0] * w[0], INERTIA[1] * w[1], INERTIA[2] * w[2])
    gyro = cross(w, momentum)
    linear = (
        (force[0] + push[0]) / MASS,
        (force[1] + push[1]) / MASS,
        (force[2] + push[2]) / MASS + GRAVITY,
    )
    return linear, (
        (roll - gyro[0]) / INERTIA[0],
        (pitch - gyro[1]) / INERTIA[1],
        (yaw - gyro[2]) / INERTIA[2],
    )


@compiled
def fall(p: Rows, h: float, wind: Triple, push: Triple) -> None:
    """Advance position, attitude and their rates by one step of h (s) of free flight, pushed by a force (N, world)."""
    v, w, a, b = p.velocity, p.rate, p.acceleration, p.spin_up
    mean_v = (v[0] + 0.5 * h * a[0], v[1] + 0.5 * h * a[1], v[2] + 0.5 * h * a[2])
    mean_w = (w[0] + 0.5 * h * b[0], w[1] + 0.5 * h * b[1], w[2] + 0.5 * h * b[2])
    linear, angular = accelerations(p, mean_v, mean_w, wind, push)
    q = turned((p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3]), mean_w, h)
    for k in range(3):
        p.position[k] = np.float32(p.position[k] + mean_v[k] * h)
        v[k] += 0.5 * h * (a[k] + linear[k])
        w[k] += 0.5 * h * (b[k] + angular[k])
        a[k], b[k] = linear[k], angular[k]
    for k in range(4):
        p.attitude[k] = q[k]


@compiled
def lift(p: Rows) -> None:
    """Keep a vehicle where it stands, and let it go once its rotors carry its weight."""
    ratio = density(p.altitude - p.position[2]) / SEA_LEVEL_DENSITY
    p.grounded = rotor_wrench(p, ratio)[0] < MASS * GRAVITY
    for k in range(3):
        p.velocity[k] = p.rate[k] = p.acceleration[k] = p.spin_up[k] = 0.0
