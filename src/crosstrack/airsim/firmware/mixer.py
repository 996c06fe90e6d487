"""From torque commands and throttle to the signals of four motors in an X."""

import numpy as np

from crosstrack.airsim.firmware.rows import DIRECT, Rows
from crosstrack.compiled import compiled

MIX = ((-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, -1.0), (-1.0, -1.0, -1.0))
"""signs of roll, pitch and yaw: front right, rear left, front left, rear right"""
THROTTLE_MIN = 0.05
"""below which the motors all follow the throttle"""


@compiled
def mix(p: Rows) -> None:
    """Set the signals of the motors.

    What falls below zero lifts all four; what exceeds one scales all four down: attitude comes before thrust.
    Goals that are outputs themselves on every axis are the signals. Signals are of single precision, as AirSim's: what
    is less than that of a torque is lost. High above the start, where its loops shake (see `cascade`), that keeps a
    flight straight ahead from breaking out sideways.
    """
    u, s = p.control, p.signal
    if p.active[0] == DIRECT and p.active[1] == DIRECT and p.active[2] == DIRECT and p.active[3] == DIRECT:
        for k in range(4):
            s[k] = u[k]
        return
    if u[3] < THROTTLE_MIN:
        for k in range(4):
            s[k] = u[3]
        return
    for k in range(4):
        s[k] = np.float32(u[3] + MIX[k][0] * u[0] + MIX[k][1] * u[1] + MIX[k][2] * u[2])
    lift = max(-min(s[0], s[1], s[2], s[3]), 0.0)
    scale = 1 / max(max(s[0], s[1], s[2], s[3]) + lift, 1.0)
    for k in range(4):
        s[k] = (s[k] + lift) * scale
