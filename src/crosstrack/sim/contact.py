"""Contact of the four feet with level ground: a stiff spring and damper, and Coulomb friction."""

import math

from crosstrack.compiled import compiled
from crosstrack.sim.fleet import Fleet
from crosstrack.types import GRAVITY

SAG = 0.001
"""m, how far the feet sink under the vehicle's weight"""
DAMPING_RATIO = 0.7
FRICTION = 0.6
"""Coulomb coefficient"""
CREEP = 0.02
"""m/s, slip below which friction falls off, so that rest is a smooth state"""

Rotation = tuple[float, float, float, float, float, float, float, float, float]
"""body to world, row by row"""


@compiled
def contact(
    height: float,
    vx: float,
    vy: float,
    vz: float,
    wx: float,
    wy: float,
    wz: float,
    rotation: Rotation,
    p: Fleet,
) -> tuple[float, float, float, float, float, float]:
    """Return the force (N, world) and torque (N m, body) of the ground on the feet.

    A foot at depth d > 0 feels k d + c ḋ, never a pull; the feet stand below the rotors.
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = rotation
    stiffness = p.mass * GRAVITY / (4 * SAG)
    damping = 2 * DAMPING_RATIO * math.sqrt(stiffness * p.mass / 4)
    fx = fy = fz = mx = my = mz = 0.0
    z = -p.gear
    for foot in range(4):
        x, y = p.rotor_x[foot], p.rotor_y[foot]
        depth = p.ground - (height + r20 * x + r21 * y + r22 * z)
        if depth <= 0:
            continue
        ux, uy, uz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
        slip_x = vx + r00 * ux + r01 * uy + r02 * uz
        slip_y = vy + r10 * ux + r11 * uy + r12 * uz
        normal = max(0.0, stiffness * depth - damping * (vz + r20 * ux + r21 * uy + r22 * uz))
        grip = -FRICTION * normal / math.sqrt(slip_x * slip_x + slip_y * slip_y + CREEP * CREEP)
        gx, gy = grip * slip_x, grip * slip_y
        fx += gx
        fy += gy
        fz += normal
        bx = r00 * gx + r10 * gy + r20 * normal
        by = r01 * gx + r11 * gy + r21 * normal
        bz = r02 * gx + r12 * gy + r22 * normal
        mx += y * bz - z * by
        my += z * bx - x * bz
        mz += x * by - y * bx
    return fx, fy, fz, mx, my, mz
