"""What the tasks have in common: how episodes end."""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.learn.agents import (
    ARRIVED,
    COLLIDED,
    FLYING,
    LEFT_BOUNDS,
    LOST_CONTROL,
    TIMED_OUT,
    Agents,
    uniform,
)
from crosstrack.learn.rewards import score
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


@compiled
def drawn(agent: Agents, index: int, count: int, in_turn: bool) -> int:
    """Return which of so many worlds the next episode is in: one by chance, or that of the index of the vehicle."""
    chosen = min(int(count * uniform(agent)), count - 1)
    return index % count if in_turn else chosen


@compiled
def leashed(p: Fleet, error: float, leash: float, there: bool, left: float) -> int:
    """Return how an episode stands in which a vehicle must stay near something; the worst comes first.

    Args:
        p: row
        error: m, from where it should be
        leash: m, the most of that
        there: whether it has done what it should
        left: s, until it runs out of time
    """
    if lost(p):
        return LOST_CONTROL
    if p.impact > HARD:
        return COLLIDED
    if error > leash:
        return LEFT_BOUNDS
    if there:
        return ARRIVED
    return TIMED_OUT if left < 1e-9 else FLYING


@compiled
def rewarded(agent: Agents, weights: Array, remains: float, period: float, gap: float, error: float) -> float:
    """Return the reward of a decision whose outcome is known, and take note of the way that remains.

    Args:
        agent: changed
        weights: of `Rewards`
        remains: m
        period: s, of the decision
        gap: m, between vehicle and obstacles
        error: m
    """
    failed = COLLIDED <= agent.outcome <= LOST_CONTROL
    closer, there = agent.potential - remains, agent.outcome == ARRIVED
    agent.potential = remains
    return score(agent.rewards, weights, closer, period, gap, error, agent.change, there, failed)
