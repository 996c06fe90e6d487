"""The outer loops of the autopilot alone, for a vehicle that has its own rate loop."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.sim.autopilot import demand, pursue
from crosstrack.sim.fleet import MOTION, Fleet
from crosstrack.types import Array


@compiled
def asked(rows: Fleet, h: float) -> Array:
    """Return the body rate (rad/s) and the collective thrust (m/s²) to ask for, (4,), of the first vehicle.

    Args:
        rows: (n,) of `crosstrack.sim.fleet.ROW`, with the state and the command of the moment
        h: s, until it is asked again
    """
    p = rows[0]
    state = p.state
    body = (
        state[0], state[1], state[2], state[3], state[4], state[5], state[6],
        state[7], state[8], state[9], state[10], state[11], state[12],
    )  # fmt: skip
    rotors = (state[13], state[14], state[15], state[16])
    wanted = demand(p)
    rate, expected = pursue(body, rotors, wanted, (p.expected[0], p.expected[1], p.expected[2]), h, p)
    p.expected[0], p.expected[1], p.expected[2] = expected
    p.yaw = wanted[-1] + wanted[6] * h if p.level == MOTION else 2 * math.atan2(state[8], state[9])
    return np.array(rate)
