"""How well a policy does in the worlds that are kept for it, many vehicles at once."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from crosstrack.learn.agents import ARRIVED, OUTCOMES
from crosstrack.learn.arenas import MANY, TESTED
from crosstrack.learn.vector import Vector
from crosstrack.policy.policy import Policy

TESTING, CHOOSING = TESTED // MANY, 0
"""Which of the worlds held out a policy is measured in at the end, and which its training chooses the best by."""


@dataclass(frozen=True)
class Measured:
    """What came of so many episodes."""

    episodes: int
    success: float
    """share that arrived"""
    collided: float
    """share"""
    left_bounds: float
    """share"""
    lost_control: float
    """share"""
    timed_out: float
    """share"""
    speed: float | None
    """m/s, mean of those that arrived; None where none did"""
    time: float | None
    """s, likewise"""
    clearance: float | None
    """m, least of the centre in those that arrived; None where nothing came near"""
    reward: float
    """mean of the sums"""

    def document(self) -> dict[str, Any]:
        """Return this as plain values."""
        return {one.name: getattr(self, one.name) for one in fields(self)}


class Range:
    """Worlds to measure policies in."""

    def __init__(self, task: Any, episodes: int, which: int = TESTING) -> None:
        task = replace(task, maps=episodes) if hasattr(task, "maps") else task
        self.task, self.episodes, self.which = task, episodes, which
        self.env = Vector(task, episodes, which, held_out=True)

    def measure(self, policy: Policy) -> Measured:
        """Return how a policy does in one episode of every world."""
        seen, _ = self.env.reset(seed=self.which)
        memory = policy.start(self.episodes)
        over = np.zeros(self.episodes, bool)
        account: dict[str, Any] = {}
        while not over.all():
            actions, memory = policy.decide_many(seen, memory)
            seen, _, _, _, infos = self.env.step(actions)
            if not infos:
                continue
            now = infos["_episode"] & ~over
            for name, values in infos["episode"].items():
                account.setdefault(name, np.zeros(self.episodes, values.dtype))[now] = values[now]
            for part in memory:
                part[infos["_episode"]] = 0.0
            over |= now
        return summary(account)


def summary(account: dict[str, Any]) -> Measured:
    """Return what came of the episodes of an account, arrays (n,)."""
    outcome = account["outcome"]
    arrived = outcome == ARRIVED
    shares = {
        word.name.lower(): float(np.mean(outcome == number)) for number, word in enumerate(OUTCOMES) if word is not None
    }
    near = account["clearance"][arrived]
    return Measured(
        episodes=len(outcome),
        success=shares.pop("arrived"),
        speed=float(account["speed"][arrived].mean()) if arrived.any() else None,
        time=float(account["t"][arrived].mean()) if arrived.any() else None,
        clearance=float(near.min()) if len(near) and np.isfinite(near.min()) else None,
        reward=float(account["r"].mean()),
        **shares,
    )
