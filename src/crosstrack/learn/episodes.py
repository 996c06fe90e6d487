"""What the tasks have in common: how episodes end."""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.learn.agents import Agents
from crosstrack.sim.fleet import Fleet
from crosstrack.types import Array

HARD = 1.5
"""m/s, sinking speed from which the ground is hit"""


@compiled
def moved(p: Fleet, agent: Agents) -> float:
    """Take note of where a vehicle is, and return how far (m) it has come since the decision before."""
    square = 0.0
    for k in range(3):
        square += (p.state[k] - agent.position[k]) ** 2
        agent.position[k] = p.state[k]
    step = np.sqrt(square)
    agent.flown += step
    agent.steps += 1
    return float(step)


@compiled
def away(p: Fleet, point: Array) -> float:
    """Return the distance (m) from a vehicle to a point (3,)."""
    square = 0.0
    for k in range(3):
        square += (p.state[k] - point[k]) ** 2
    return float(np.sqrt(square))


@compiled
def lost(p: Fleet) -> bool:
    """Return whether a vehicle has turned over, or its state is no longer finite."""
    state = p.state
    upright = 1 - 2 * (state[6] * state[6] + state[7] * state[7]) > 0.0
    return not (upright and np.isfinite(state[0] + state[1] + state[2] + state[3] + state[4] + state[5]))


@compiled
def estimated(p: Fleet, body: Array) -> None:
    """Write the state of a vehicle as it is estimated: (13,)."""
    for k in range(13):
        body[k] = p.state[k]
    for k in range(6):
        body[k] += p.error[k]
