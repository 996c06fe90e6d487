"""A policy that decides at random: what a learned one is measured against."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from crosstrack.avoid import policy as avoid
from crosstrack.policy.card import Discrete
from crosstrack.policy.flying import Pilot
from crosstrack.policy.network import Floats, Memory
from crosstrack.policy.policy import Policy
from crosstrack.protocols import Avoider
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Aimless(Policy):
    """A policy that sees nothing: every action is as likely as any other, and follows from the seed alone."""

    seed: int = 0

    def start(self, count: int = 1) -> Memory:
        """Return how many decisions there were."""
        return (np.zeros((count, 1), np.float32),)

    def decide(self, observation: Floats, memory: Memory) -> tuple[int | Array, Memory]:
        """Return an action at random, and the memory after it."""
        draw, action = np.random.default_rng([self.seed, int(memory[0][0, 0])]), self.card.action
        after = (memory[0] + np.float32(1),)
        if isinstance(action, Discrete):
            return int(draw.integers(action.count)), after
        return draw.uniform(-1, 1, action.size), after


def at_random(avoider: Avoider[Any], seed: int) -> avoid.Policy:
    """Return an avoider by a policy that decides at random instead, with actions of the same kind."""
    assert isinstance(avoider, avoid.Policy)
    pilot, copy = avoider.pilot, replace(avoider)
    aimless = Aimless(pilot.policy.card, pilot.policy.arrays, seed)
    vars(copy)["pilot"] = Pilot(pilot.name, aimless, "avoid")
    return copy
