"""The one function that flies served vehicles: rigid body and firmware, step by step, row by row."""

import math

from crosstrack.airsim.firmware import airframe
from crosstrack.airsim.firmware.body import Triple, fall, lift, spin
from crosstrack.airsim.firmware.cascade import control
from crosstrack.airsim.firmware.contact import respond
from crosstrack.airsim.firmware.mixer import mix
from crosstrack.airsim.firmware.rows import Rows
from crosstrack.airsim.firmware.watch import watch
from crosstrack.compiled import compiled

ROTOR_LAG = airframe.ROTOR_LAG


@compiled
def move(p: Rows, h: float, keep: float, wind: Triple, push: Triple) -> None:
    """Advance the rigid body by one step of h (s), contact included."""
    q = (p.attitude[0], p.attitude[1], p.attitude[2], p.attitude[3])
    v, w, a, b = p.velocity, p.rate, p.acceleration, p.spin_up
    swift = (v[0] + h * a[0], v[1] + h * a[1], v[2] + h * a[2])
    swirl = (w[0] + h * b[0], w[1] + h * b[1], w[2] + h * b[2])
    if p.grounded:
        lift(p)
    else:
        fall(p, h, wind, push)
    if p.touched:
        p.touched = False
        respond(p, swift, swirl, q, h)
    spin(p, keep)


@compiled
def fly(rows: Rows, start: int, step: int, count: int, wind: Triple, push: Triple) -> None:
    """Advance every vehicle by steps in place; goals, wind and push are held.

    In every step first the body moves, by the signals of the step before, and then the firmware sees where it is.

    Args:
        rows: (n,) of `crosstrack.airsim.firmware.rows.ROW`
        start: ns, the time before the first step
        step: ns
        count: number of steps
        wind: m/s, NED, the velocity of the air
        push: N, NED, a force on every vehicle
    """
    h = 1e-9 * step
    keep = math.exp(-h / ROTOR_LAG)
    for i in range(rows.shape[0]):
        p = rows[i]
        for k in range(count):
            now = (start + (k + 1) * step) // 1_000_000
            move(p, h, keep, wind, push)
            watch(p, now)
            control(p, now)
            mix(p)
