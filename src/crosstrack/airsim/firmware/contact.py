"""What AirSim's rigid body does when it touches something: an impulse, or a hold on level ground.

With the mean velocity v̄ at the point of contact, its normal n, and r from the centre to it,

    j = -(1 + e) v̄·n / (1/m + (I⁻¹(r × n) × r)·n)

(Hecker, Physics, Part 3: Collision Response, 1997, eq. 4a), and friction likewise against the tangent. As in AirSim, r
is taken in world axes, and the change of the rates leaves out the inertia.
"""

import math

from crosstrack.airsim.firmware import airframe
from crosstrack.airsim.firmware.body import Quaternion, Triple, cross, to_body, to_world
from crosstrack.airsim.firmware.rows import Rows
from crosstrack.compiled import compiled

MASS, INERTIA = airframe.MASS, airframe.INERTIA
RESTITUTION, FRICTION = airframe.RESTITUTION, airframe.FRICTION
LEVEL = 0.25
"""how far the normal's part along body z may be from 1 for a touch to be a landing"""
LEFT_OF_RATE = 0.9
"""of the rate after a touch: rolling friction"""


@compiled
def dot(a: Triple, b: Triple) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def resistance(r: Triple, n: Triple) -> float:
    """Return the velocity (m/s) along n that an impulse of 1 N s along n changes at r, 1/kg."""
    arm = cross(r, n)
    turn = (arm[0] / INERTIA[0], arm[1] / INERTIA[1], arm[2] / INERTIA[2])
    return 1 / MASS + dot(cross(turn, r), n)


@compiled
def heading_only(q: Quaternion) -> Quaternion:
    """Return the level attitude of the same heading."""
    yaw = math.atan2(2 * (q[3] * q[2] + q[0] * q[1]), 1 - 2 * (q[1] * q[1] + q[2] * q[2]))
    return 0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw)


@compiled
def land(p: Rows, velocity: Triple) -> None:
    """Hold the vehicle level where it touched the ground."""
    q = heading_only((p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3]))
    p.grounded = True
    for k in range(3):
        p.position[k] = p.contact_position[k]
        p.velocity[k] = p.rate[k] = p.spin_up[k] = 0.0
        p.acceleration[k] = -0.5 * MASS * velocity[k]
    for k in range(4):
        p.attitude[k] = q[k]


@compiled
def bounce(p: Rows, v: Triple, w: Triple, h: float) -> None:
    """Push the vehicle off what it touched, given its velocity (world) and its rate (body) at the end of the step."""
    q = (p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3])
    normal = (p.contact_normal[0], p.contact_normal[1], p.contact_normal[2])
    at, centre = p.contact_point, p.contact_position
    r = (at[0] - centre[0], at[1] - centre[1], at[2] - centre[2])
    n = to_body(normal, q)
    u, turn = to_body(v, q), cross(w, r)
    slip = (u[0] + turn[0], u[1] + turn[1], u[2] + turn[2])
    into = dot(slip, n)
    push = -into * (1 + RESTITUTION) / resistance(r, n)
    tangent = (slip[0] - n[0] * into, slip[1] - n[1] * into, slip[2] - n[2] * into)
    speed = math.sqrt(dot(tangent, tangent))
    if speed > 0:
        tangent = (tangent[0] / speed, tangent[1] / speed, tangent[2] / speed)
    grip = -speed * FRICTION / resistance(r, tangent)
    along, lever, drag_lever = to_world(tangent, q), cross(r, n), cross(r, tangent)
    for k in range(3):
        p.velocity[k] = v[k] + (normal[k] * push + along[k] * grip) / MASS
        p.rate[k] = LEFT_OF_RATE * (w[k] + lever[k] * push + drag_lever[k] * grip / MASS)
        p.acceleration[k] = p.spin_up[k] = 0.0
        p.position[k] = centre[k] + normal[k] * p.contact_depth + p.velocity[k] * h


@compiled
def respond(p: Rows, v: Triple, w: Triple, before: Quaternion, h: float) -> None:
    """Respond to the contact of a row unless the vehicle moves away from it already.

    Args:
        p: the row, moved on as if there were no contact
        v: m/s, world, what the velocity would be by the acceleration before
        w: rad/s, body, likewise the rate
        before: the attitude at the start of the step
        h: s, the step
    """
    normal = (p.contact_normal[0], p.contact_normal[1], p.contact_normal[2])
    if dot(normal, (p.velocity[0], p.velocity[1], p.velocity[2])) >= 0:
        return
    for k in range(4):
        p.attitude[k] = before[k]
    level = abs(abs(to_body(normal, before)[2]) - 1) <= LEVEL
    if level and v[2] > abs(v[0]) and v[2] > abs(v[1]):
        land(p, v)
    else:
        bounce(p, v, w, h)
