"""What the environments reward: a sum of named terms, each with a weight.

progress    w (D - D'), D the way that remains (m): a difference of potentials (Ng, Harada and Russell 1999), so no
            detour pays
time        -w T, T the time of a decision (s)
clearance   -w T (1 - c/m)² where the gap c between vehicle and obstacles (m) is less than m
error       -w T e², e the distance from where it should be (m), at most the limit of the task
smoothness  -w |a - a'|², how much the action changes
arrival     w once, at the goal
failure     -w once: collided, out of bounds, or turned over
"""

from dataclasses import astuple, dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array, NonNegative, Positive

TERMS = ("progress", "time", "clearance", "error", "smoothness", "arrival", "failure")


@dataclass(frozen=True)
class Rewards:
    """Weights of the terms."""

    progress: NonNegative = 0.0
    """1/m"""
    time: NonNegative = 0.0
    """1/s"""
    clearance: NonNegative = 0.0
    """1/s"""
    error: NonNegative = 0.0
    """1/(m² s)"""
    smoothness: NonNegative = 0.0
    """1"""
    arrival: NonNegative = 0.0
    """1"""
    failure: NonNegative = 0.0
    """1"""
    margin: Positive = 0.6
    """m, of the gap under which clearance counts"""

    @property
    def weights(self) -> Array:
        """In the order of TERMS, then the margin."""
        return np.array(astuple(self))


@compiled
def score(
    terms: Array,
    weights: Array,
    closer: float,
    duration: float,
    gap: float,
    error: float,
    change: float,
    arrived: bool,
    failed: bool,
) -> float:
    """Add the rewards of one decision to an account (terms,); return their sum.

    Args:
        terms: changed in place
        weights: of `Rewards`
        closer: m, by which the way that remains became shorter
        duration: s
        gap: m, between vehicle and obstacles
        error: m
        change: of the action, squared
        arrived: whether it has
        failed: whether it has
    """
    near = max(0.0, 1.0 - gap / weights[7])
    parts = (
        weights[0] * closer,
        -weights[1] * duration,
        -weights[2] * duration * near * near,
        -weights[3] * duration * error * error,
        -weights[4] * change,
        weights[5] if arrived else 0.0,
        -weights[6] if failed else 0.0,
    )
    total = 0.0
    for k in range(7):
        terms[k] += parts[k]
        total += parts[k]
    return total
