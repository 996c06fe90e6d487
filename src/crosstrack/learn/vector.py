"""Many vehicles of one task at once, as a vector environment of gymnasium."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from crosstrack.campaign.avoidance.families import Arena
from crosstrack.learn.agents import AGENT, ARRIVED, TIMED_OUT
from crosstrack.learn.rewards import TERMS
from crosstrack.learn.stepping import advance
from crosstrack.policy.action import CHOICES, KINDS, SIZES
from crosstrack.sim.airframe import AIRFRAMES
from crosstrack.sim.fleet import fleet
from crosstrack.sim.kernel import OUTER
from crosstrack.types import Air, Array, Limits

STEP = 0.005
"""s, of the simulation; twice that of single flights, see docs/learning.md"""
LIMITS = Limits(speed=20.0)
"""of the autopilot"""
LARGEST = 1000.0
"""what no number of an observation reaches while a vehicle is within its bounds"""
Floats = NDArray[np.float32]


class Vector(VectorEnv[Floats, Any, Any]):
    """Many vehicles in compiled code: rotors, autopilot, beams, rewards, and the next episode where one has ended.

    An episode that ends begins anew in the same step (`AutoresetMode.SAME_STEP`); what was seen last is in
    `infos["final_obs"]`, how it went in `infos["episode"]`: arrays (n,), with `infos["_episode"]` where they hold.
    """

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012  # as gymnasium has it

    def __init__(
        self,
        task: Any,
        count: int,
        seed: int = 0,
        *,
        held_out: bool = False,
        step: float = STEP,
        arenas: Sequence[Arena] | None = None,
    ) -> None:
        """Make `count` vehicles.

        Args:
            task: what to do, such as `crosstrack.learn.avoid.Avoid`
            count: of vehicles
            seed: of everything that chance decides
            held_out: whether to fly in the worlds that are kept for evaluation, each vehicle in its own
            step: s, of the simulation
            arenas: to fly in, instead of those that the task makes
        """
        self.task, self.num_envs, self.held_out = task, count, held_out
        size = sum(many for _, many in task.seen)
        self.single_observation_space = spaces.Box(-LARGEST, LARGEST, (size,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, count)
        self.kind = KINDS[task.action]
        self.single_action_space = (
            spaces.Discrete(CHOICES[task.action])
            if task.action in CHOICES
            else spaces.Box(-1.0, 1.0, (SIZES[task.action],), np.float32)
        )
        self.action_space = batch_space(self.single_action_space, count)
        outer = OUTER * step
        self.outer_steps = round(task.period / outer)
        self.step_time = task.period / (self.outer_steps * OUTER)
        self.nominal = fleet(AIRFRAMES[task.airframe], Air(), LIMITS, 0.0)
        self.rows = np.repeat(self.nominal, count)
        self.agents = np.zeros(count, AGENT)
        self.observations = np.zeros((count, size), np.float32)
        self.rewards = np.zeros(count)
        self.everyone = np.arange(count)
        self.seed = seed
        self.field = task.field(seed, held_out) if arenas is None else task.within(arenas)
        self.shuffle(seed)

    def shuffle(self, seed: int) -> None:
        """Begin the random numbers of every vehicle anew; the worlds stay."""
        self.agents["random"] = np.random.SeedSequence(seed).generate_state(self.num_envs, np.uint64)

    def level(self, **options: float) -> None:
        """Change options of the task, such as `density` or `speed`, for the episodes to come."""
        self.task = replace(self.task, **options)
        self.field = self.task.field(self.seed, self.held_out)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode of every vehicle: the same ones for the same seed."""
        if seed is not None:
            self.shuffle(seed)
        self.begin(self.everyone)
        self.look()
        return self.observations.copy(), {}

    def begin(self, which: NDArray[np.int64]) -> None:
        """Begin episodes of some vehicles."""
        self.field.begin(self.rows, self.nominal, self.agents, which, OUTER * self.step_time, self.held_out)

    def step(self, actions: Any) -> tuple[Floats, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Fly the actions (n, ...) for a decision; actions outside the space are taken at its edge."""
        numbers = np.asarray(actions, dtype=float).reshape(self.num_envs, -1)
        advance(self.kind, numbers, self.rows, self.agents, self.task.period, self.step_time, self.outer_steps)
        terminated, truncated = self.assess()
        infos: dict[str, Any] = {}
        over = np.flatnonzero(terminated | truncated)
        if len(over):
            infos = self.ended(over)
            self.begin(over)
            self.field.observe(self.rows, self.agents, over, self.observations)
        return self.observations.copy(), self.rewards.copy(), terminated, truncated, infos

    def assess(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Judge and observe after a decision; return which episodes are terminated, and which truncated."""
        self.field.judge(self.rows, self.agents, self.rewards)
        self.look()
        outcome = self.agents["outcome"]
        truncated = outcome == TIMED_OUT
        return (outcome > 0) & ~truncated, truncated

    def look(self) -> None:
        """Observe with every vehicle."""
        self.field.observe(self.rows, self.agents, self.everyone, self.observations)

    def ended(self, over: NDArray[np.int64]) -> dict[str, Any]:
        """Return the infos of episodes that ended."""
        agents, mask = self.agents[over], np.zeros(self.num_envs, bool)
        mask[over] = True
        time = agents["steps"] * self.task.period
        account = {
            "r": agents["rewards"].sum(axis=1),
            "l": agents["steps"],
            "t": time,
            "outcome": agents["outcome"],
            "success": agents["outcome"] == ARRIVED,
            "speed": agents["flown"] / time,
            "clearance": agents["least"],
            "arena": agents["arena"],
            **{f"reward_{name}": agents["rewards"][:, k] for k, name in enumerate(TERMS)},
        }
        spread = {}
        for name, values in account.items():
            spread[name] = np.zeros(self.num_envs, values.dtype)
            spread[name][over] = values
        final = np.zeros_like(self.observations)
        final[over] = self.observations[over]
        return {"final_obs": final, "_final_obs": mask, "episode": spread, "_episode": mask}

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return everything that it remembers, as plain arrays."""
        return {"rows": self.rows.copy(), "agents": self.agents.copy(), "observations": self.observations.copy()}

    def recall(self, memory: dict[str, NDArray[Any]]) -> None:
        """Go on from what `memory` returned."""
        self.rows[:], self.agents[:] = memory["rows"], memory["agents"]
        self.observations[:] = memory["observations"]
