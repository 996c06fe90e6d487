"""Hover: get to a point from nearby, and stay, by attitude and thrust."""

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Lt
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.learn.agents import Agents, between
from crosstrack.learn.episodes import away, estimated, leashed, moved, rewarded
from crosstrack.learn.randomise import Randomise, draw, put
from crosstrack.learn.rewards import Rewards
from crosstrack.policy import motion
from crosstrack.policy.motion import write
from crosstrack.policy.path import write_points
from crosstrack.sim.fleet import Fleet
from crosstrack.types import Array, NonNegative, Positive
from crosstrack.world.world import World

HEIGHT = 10.0
"""m, of the point"""
Floats = NDArray[np.float32]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Hover:
    """Get to a point from nearby, and stay there."""

    speed: Positive = 4.0
    """m/s, the unit of velocities, and the fastest that an action of velocity asks for"""
    action: Literal["velocity", "stick", "attitude"] = "attitude"
    """see `crosstrack.policy.action`"""
    period: Annotated[float, Ge(0.02), Lt(1)] = 0.05
    """s, from one decision to the next"""
    timeout: Positive = 15.0
    """s"""
    away: NonNegative = 2.0
    """m, from the point on each axis where episodes begin, at most"""
    leash: Positive = 6.0
    """m, from the point where they end"""
    near: Positive = 0.3
    """m, from the point, that counts as there"""
    hold: Positive = 2.0
    """s, to be there without a break to succeed"""
    airframe: Literal["generic", "crazyflie", "racer"] = "generic"
    """which airframe"""
    rewards: Rewards = field(default_factory=lambda: Rewards(progress=1.0, error=0.5, smoothness=0.05, failure=10.0))
    """weights of the reward"""
    randomise: Randomise = field(default_factory=Randomise)
    """what differs from episode to episode"""

    name = "hover"
    picture = None

    @property
    def seen(self) -> tuple[tuple[str, int], ...]:
        """Name and size of each part of an observation."""
        return (("error", 3), *motion.LAYOUT)

    def field(self, seed: int, held_out: bool) -> "HoverField":
        """Return what is compiled; every seed has the same world."""
        return HoverField(self)


class HoverField:
    """The task, for many vehicles at once."""

    def __init__(self, task: Hover) -> None:
        self.task, self.worlds = task, [World()]
        self.weights, self.spread = task.rewards.weights, task.randomise.numbers
        self.start = np.array([task.away, task.speed])
        self.limits = np.array([task.period, task.timeout, task.leash, task.near, task.hold])

    def begin(self, rows: Fleet, nominal: Fleet, agents: Agents, which: Indices, outer: float, in_turn: bool) -> None:
        """Begin episodes."""
        begin(rows, nominal, agents, which, self.spread, self.start, outer)

    def observe(self, rows: Fleet, agents: Agents, which: Indices, out: Floats) -> None:
        """Write observations."""
        observe(rows, agents, which, out)

    def judge(self, rows: Fleet, agents: Agents, reward: Array) -> None:
        """Write rewards, and outcomes where there are any."""
        judge(rows, agents, self.weights, self.limits, reward)


@compiled
def begin(
    rows: Fleet, nominal: Fleet, agents: Agents, which: Indices, spread: Array, start: Array, outer: float
) -> None:
    """Begin episodes: near the point, at rest, with any heading.

    Args:
        rows: changed
        nominal: (1,) row of the airframe
        agents: changed
        which: vehicles that begin
        spread: of `Randomise`
        start: away (m), speed (m/s)
        outer: s, of which delays are multiples
    """
    position = np.empty(3)
    for i in which:
        p, agent = rows[i], agents[i]
        draw(p, nominal[0], agent, spread, outer)
        for k in range(3):
            agent.goal[k] = HEIGHT if k == 2 else 0.0
            position[k] = agent.goal[k] + between(agent, -start[0], start[0])
        put(p, agent, position, between(agent, -math.pi, math.pi))
        agent.speed, agent.progress, agent.potential = start[1], 0.0, away(p, agent.goal)


@compiled
def observe(rows: Fleet, agents: Agents, which: Indices, out: Floats) -> None:
    """Write observations: where the point is, then the motion as estimated."""
    body, point = np.empty(13), np.empty((1, 3))
    for i in which:
        p, agent = rows[i], agents[i]
        estimated(p, body)
        for k in range(3):
            point[0, k] = agent.goal[k]
        write_points(out[i], 0, body, point)
        write(out[i], 3, body, agent.goal, agent.asked, agent.speed)


@compiled
def judge(rows: Fleet, agents: Agents, weights: Array, limits: Array, reward: Array) -> None:
    """Write the rewards (n,) of the decision flown, and how episodes ended.

    Args:
        rows: of vehicles
        agents: changed; `progress` is how long (s) a vehicle has been there
        weights: of `Rewards`
        limits: period (s), timeout (s), leash (m), near (m), hold (s)
        reward: (n,) changed
    """
    period, timeout, leash, near, hold = limits[0], limits[1], limits[2], limits[3], limits[4]
    for i in range(rows.shape[0]):
        p, agent = rows[i], agents[i]
        moved(p, agent)
        error = away(p, agent.goal)
        agent.progress = agent.progress + period if error < near else 0.0
        agent.outcome = leashed(p, error, leash, agent.progress > hold - 1e-9, timeout - agent.steps * period)
        reward[i] = rewarded(agent, weights, error, period, math.inf, min(error, leash))
