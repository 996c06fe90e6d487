"""What the environments remember of each vehicle beside its row in the simulator."""

import math
from typing import Any

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.learn.rewards import TERMS
from crosstrack.types import Outcome

FLYING, ARRIVED, COLLIDED, LEFT_BOUNDS, LOST_CONTROL, TIMED_OUT = range(6)
OUTCOMES = (
    None,
    Outcome.ARRIVED,
    Outcome.COLLIDED,
    Outcome.LEFT_BOUNDS,
    Outcome.LOST_CONTROL,
    Outcome.TIMED_OUT,
)
"""What the numbers mean."""

AGENT = np.dtype(
    [
        ("random", np.uint64),  # state of the random numbers of this vehicle
        # The episode.
        ("arena", np.int64),  # which of those there are
        ("speed", float),  # m/s, allowed
        ("delay", np.int64),  # outer steps from an action to its command
        ("drag", float),  # over the nominal one
        ("mean", float, 3),  # m/s, wind
        ("intensity", float),  # m/s, of gusts
        ("filters", float, 5),  # of gusts
        ("noise", float, 2),  # m and m/s, standard deviations of the estimate
        ("goal", float, 3),  # m
        # How it goes.
        ("steps", np.int64),  # decisions so far
        ("asked", float, 4),  # see crosstrack.policy.action
        ("level", np.int64),  # of the pending command
        ("pending", float, 11),  # command, until its delay is over
        ("action", float, 4),  # the last
        ("change", float),  # of the last action, squared
        ("position", float, 3),  # m, at the decision before
        ("clearance", float),  # m, of the centre, least since the decision before
        ("potential", float),  # m, way that remains
        ("progress", float),  # m, along a route
        # For the account at its end.
        ("outcome", np.int64),
        ("flown", float),  # m
        ("least", float),  # m, clearance of the centre
        ("rewards", float, len(TERMS)),  # each term so far
    ]
)

Agents = Any
"""An array of AGENT, or one of them: compiled code reads its fields as attributes."""


@compiled
def uniform(agent: Agents) -> float:
    """Return a number in [0, 1), evenly (Steele, Lea and Flood 2014: SplitMix)."""
    agent.random = agent.random + np.uint64(0x9E3779B97F4A7C15)
    z = agent.random
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * 2.0**-53


@compiled
def between(agent: Agents, low: float, high: float) -> float:
    """Return a number in [low, high), evenly."""
    return low + (high - low) * uniform(agent)


@compiled
def normal(agent: Agents) -> float:
    """Return a number of the standard normal distribution (Box and Muller 1958)."""
    size = math.sqrt(-2.0 * math.log(1.0 - uniform(agent)))
    return size * math.cos(2 * math.pi * uniform(agent))
