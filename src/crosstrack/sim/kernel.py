"""The one function that flies quadrotors, one or thousands: autopilot and rigid body, row by row."""

import math

from crosstrack.compiled import compiled
from crosstrack.sim.autopilot import demand, pursue, spin_rotors
from crosstrack.sim.dynamics import step
from crosstrack.sim.fleet import MOTION, Fleet

STEP = 0.0025
"""s, the longest step flown: a step of 400 Hz, as the rate loops of real autopilots"""
OUTER = 2
"""steps of the rate loop to one of the loops around it"""


@compiled
def fly(rows: Fleet, h: float, steps: int) -> None:
    """Advance every vehicle by `steps` steps of `h` (s), in place; command, wind and error are held.

    Args:
        rows: (n,) of `crosstrack.sim.fleet.ROW`
        h: s
        steps: number of steps
    """
    for i in range(rows.shape[0]):
        p = rows[i]
        state = p.state
        wind = (p.wind[0], p.wind[1], p.wind[2])
        half_lag = math.exp(-0.5 * h / p.motor_time)
        body = (
            state[0], state[1], state[2], state[3], state[4], state[5], state[6],
            state[7], state[8], state[9], state[10], state[11], state[12],
        )  # fmt: skip
        rotors = (state[13], state[14], state[15], state[16])
        expected = (p.expected[0], p.expected[1], p.expected[2])
        asked = demand(p)
        touch = p.ground + p.gear
        rate = (0.0, 0.0, 0.0, 0.0)
        for k in range(steps):
            if k % OUTER == 0:
                rate, expected = pursue(body, rotors, asked, expected, min(OUTER, steps - k) * h, p)
            above, sinking = body[2] > touch, -body[5]
            body, rotors = step(body, rotors, spin_rotors(body, rate, p), wind, p, h, half_lag)
            if above and body[2] <= touch:
                p.impact = max(p.impact, sinking)
        for k in range(13):
            state[k] = body[k]
        state[13], state[14], state[15], state[16] = rotors
        p.expected[0], p.expected[1], p.expected[2] = expected
        p.yaw = asked[-1] + asked[6] * h * steps if p.level == MOTION else 2 * math.atan2(state[8], state[9])
