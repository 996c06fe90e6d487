"""A learned policy: from what is seen to an action."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import InputError
from crosstrack.policy.card import Card, Discrete
from crosstrack.policy.fit import faults
from crosstrack.policy.network import Arrays, Floats, Memory, outputs, start
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Policy:
    """A network, and the card that says what it sees, does and was trained for.

    Raises:
        InputError: the arrays are not what the card's architecture says, or not finite.
    """

    card: Card
    arrays: Arrays
    """float32, by name; see `card.Layer`"""

    def __post_init__(self) -> None:
        if found := faults(self.card, self.arrays):
            raise InputError("policy", found[:20])

    def start(self, count: int = 1) -> Memory:
        """Return the memory of so many vehicles at the start of an episode; empty for a network without any."""
        return start(self.card.architecture, self.arrays, count)

    def decide(self, observation: Floats, memory: Memory) -> tuple[int | Array, Memory]:
        """Return the best action, and the memory after it.

        Args:
            observation: (size,) float32
            memory: of one vehicle, from `start` or the decision before

        Returns:
            the number of the action, or (size,) in [-1, 1]; and the memory
        """
        actions, later = self.decide_many(observation[np.newaxis], memory)
        return (int(actions[0]) if isinstance(self.card.action, Discrete) else actions[0]), later

    def decide_many(self, observations: Floats, memory: Memory) -> tuple[NDArray[np.int64] | Array, Memory]:
        """Return the best actions of many vehicles, and their memory after them.

        Args:
            observations: (vehicles, size) float32
            memory: of as many vehicles; rows are set to zero where an episode begins

        Returns:
            numbers of actions (vehicles,), or (vehicles, size) in [-1, 1]; and the memory
        """
        values, later = self.values(observations, memory)
        if isinstance(self.card.action, Discrete):
            return values.argmax(axis=1), later
        return np.clip(values.astype(np.float64), -1, 1), later

    def values(self, observations: Floats, memory: Memory) -> tuple[Floats, Memory]:
        """Return what the network gives, (vehicles, outputs): preferences for actions, or an action not yet bounded."""
        return outputs(self.card.architecture, self.arrays, self.card.observation.picture, observations, memory)
