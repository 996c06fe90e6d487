"""Avoid: get to a goal through what the vehicle must see."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from numpy.typing import NDArray

from crosstrack.campaign.avoidance.families import Arena
from crosstrack.campaign.avoidance.trial import built
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
from crosstrack.learn.arenas import Pool, arenas, pool, seeds
from crosstrack.learn.episodes import HARD, away, drawn, estimated, lost, moved, rewarded
from crosstrack.learn.looking import around, look, nearest
from crosstrack.learn.randomise import Randomise, draw, put
from crosstrack.learn.rewards import Rewards
from crosstrack.policy import motion
from crosstrack.policy.motion import write
from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.lidar import Lidar
from crosstrack.sim.fleet import Fleet
from crosstrack.types import Array, NonNegative, Positive

Floats = NDArray[np.float32]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Avoid:
    """Get to a goal through an unknown forest, by rays or depth."""

    family: Literal["forest", "discs-20", "discs-30", "maze", "trap", "gap"] = "forest"
    """of worlds"""
    density: NonNegative = 0.1
    """trees per m², of forests"""
    speed: Positive = 3.5
    """m/s, the fastest that is asked for"""
    observation: Literal["rays", "depth"] = "rays"
    """what is seen beside the motion: a fan of beams, or a picture"""
    rays: Annotated[int, Ge(4), Le(360)] = 32
    """beams of the fan"""
    fov_deg: Annotated[float, Gt(0), Le(360)] = 180.0
    """degrees, of the fan"""
    range: Positive = 8.0
    """m, farther than which nothing is seen"""
    noise: NonNegative = 0.01
    """m, standard deviation of a range; in a picture, of one of 2 m, and growing with its square"""
    picture: tuple[Annotated[int, Ge(4), Le(128)], Annotated[int, Ge(4), Le(128)]] = (12, 32)
    """pixels, height and width of the picture, 120° wide"""
    action: Literal["velocity", "stick", "attitude"] = "velocity"
    """see `crosstrack.policy.action`"""
    period: Annotated[float, Ge(0.02), Lt(1)] = 0.05
    """s, from one decision to the next"""
    timeout: Positive = 30.0
    """s"""
    arrival: Positive = 1.5
    """m, from the goal"""
    radius: Positive = 0.2
    """m, of the vehicle"""
    spread: NonNegative = 4.0
    """m, by which start and goal lie beside the middle of a forest"""
    maps: Annotated[int, Ge(1), Le(10_000)] = 512
    """worlds to draw episodes from"""
    airframe: Literal["generic", "crazyflie", "racer"] = "generic"
    """which airframe"""
    rewards: Rewards = field(
        default_factory=lambda: Rewards(
            progress=0.5, time=0.5, clearance=1.0, smoothness=0.02, arrival=5.0, failure=10.0
        )
    )
    """weights of the reward"""
    randomise: Randomise = field(default_factory=Randomise)
    """what differs from episode to episode"""

    name = "avoid"

    @cached_property
    def sensor(self) -> Lidar | DepthCamera:
        """What it sees with, as a mission would have it."""
        if self.observation == "rays":
            return Lidar(
                range=self.range,
                rate=1 / self.period,
                noise=self.noise,
                rings=1,
                columns=self.rays,
                lowest_deg=0.0,
                highest_deg=0.0,
                fov_deg=self.fov_deg,
            )
        height, width = self.picture
        return DepthCamera(
            range=self.range, rate=1 / self.period, noise=self.noise / 4, width=width, height=height, fov_deg=120.0
        )

    @property
    def seen(self) -> tuple[tuple[str, int], ...]:
        """Name and size of each part of an observation."""
        return (("ranges", len(self.sensor.directions)), *motion.LAYOUT)

    def field(self, seed: int, held_out: bool) -> "AvoidField":
        """Return the worlds, of a seed, with all that is compiled."""
        spread = 0.0 if held_out else self.spread
        return AvoidField(self, arenas(self.family, self.density, seeds(seed, self.maps, held_out), spread))

    def within(self, made: Sequence[Arena]) -> "AvoidField":
        """Return worlds that are given."""
        return AvoidField(self, made)


class AvoidField:
    """The task over arenas, for many vehicles at once."""

    def __init__(self, task: Avoid, made: Sequence[Arena]) -> None:
        self.task = task
        self.worlds = [built(arena.world) for arena in made]
        self.pool = pool(made, self.worlds)
        self.beams = task.sensor.directions
        self.weights = task.rewards.weights
        self.spread = task.randomise.numbers

    def begin(self, rows: Fleet, nominal: Fleet, agents: Agents, which: Indices, outer: float, in_turn: bool) -> None:
        """Begin episodes."""
        begin(rows, nominal, agents, which, self.pool, self.spread, self.task.speed, outer, in_turn)

    def observe(self, rows: Fleet, agents: Agents, which: Indices, out: Floats) -> None:
        """Write observations."""
        task = self.task
        depth = task.observation == "depth"
        observe(rows, agents, which, self.pool, self.beams, task.range, task.sensor.noise, depth, out)

    def judge(self, rows: Fleet, agents: Agents, reward: Array) -> None:
        """Write rewards, and outcomes where there are any."""
        task = self.task
        limits = np.array([task.period, task.timeout, task.arrival, task.radius])
        judge(rows, agents, self.pool, self.weights, limits, reward)


@compiled
def begin(
    rows: Fleet,
    nominal: Fleet,
    agents: Agents,
    which: Indices,
    made: Pool,
    spread: Array,
    speed: float,
    outer: float,
    in_turn: bool,
) -> None:
    """Begin episodes: another arena, another body, at rest at the start, facing the goal.

    Args:
        rows: changed
        nominal: (1,) row of the airframe
        agents: changed
        which: vehicles that begin
        made: arenas
        spread: of `Randomise`
        speed: m/s, allowed
        outer: s, of which delays are multiples
        in_turn: whether each vehicle takes its own arena, by its index, not one by chance
    """
    count = len(made.starts)
    for i in which:
        p, agent = rows[i], agents[i]
        agent.arena = drawn(agent, i, count, in_turn)
        draw(p, nominal[0], agent, spread, outer)
        start, goal = made.starts[agent.arena], made.goals[agent.arena]
        put(p, agent, start, np.arctan2(goal[1] - start[1], goal[0] - start[0]))
        for k in range(3):
            agent.goal[k] = goal[k]
        agent.potential, agent.speed = away(p, goal), speed


@compiled
def observe(
    rows: Fleet,
    agents: Agents,
    which: Indices,
    made: Pool,
    beams: Array,
    reach: float,
    noise: float,
    depth: bool,
    out: Floats,
) -> None:
    """Write observations: ranges over reach, then the motion as estimated."""
    many, inverse = beams.shape[0], 1.0 / reach
    found, body, rays = np.empty(made.most, np.int64), np.empty(13), np.empty((5, many))
    for i in which:
        p, agent = rows[i], agents[i]
        first, end = made.first[agent.arena], made.first[agent.arena + 1]
        state = p.state
        count = around(made.table, first, end, state[0], state[1], reach, found)
        look(made.table, found, count, state, beams, reach, p.ground, rays)
        if noise > 0.0:
            blur(rays[0], noise, depth, reach, agent)
        for k in range(many):
            out[i, k] = rays[0, k] * inverse
        estimated(p, body)
        write(out[i], many, body, agent.goal, agent.asked, agent.speed)


@compiled
def blur(ranges: Array, noise: float, depth: bool, reach: float, agent: Agents) -> None:
    """Add noise of a standard deviation (m) to the ranges of what was hit; times their square (m²) where of depth."""
    for k in range(0, len(ranges), 2):
        size = noise * math.sqrt(-2.0 * math.log(1.0 - uniform(agent)))
        side = 2 * math.pi * uniform(agent)
        for j in range(k, min(k + 2, len(ranges))):
            if ranges[j] < reach:
                part = (math.cos(side) if j == k else math.sin(side)) * (ranges[j] * ranges[j] if depth else 1.0)
                ranges[j] = min(reach, max(0.0, ranges[j] + size * part))


@compiled
def judge(rows: Fleet, agents: Agents, made: Pool, weights: Array, limits: Array, reward: Array) -> None:
    """Write the rewards (n,) of the decision flown, and how episodes ended.

    Args:
        rows: of vehicles
        agents: changed
        made: arenas
        weights: of `Rewards`
        limits: period (s), timeout (s), distance of arrival (m), radius (m)
        reward: (n,) changed
    """
    found = np.empty(made.most, np.int64)
    period, timeout, arrival, radius = limits[0], limits[1], limits[2], limits[3]
    wide = radius + weights[7]
    for i in range(rows.shape[0]):
        p, agent = rows[i], agents[i]
        x, y, z = p.state[0], p.state[1], p.state[2]
        step = away(p, agent.position)
        first, end = made.first[agent.arena], made.first[agent.arena + 1]
        count = around(made.table, first, end, x, y, wide + step, found)
        agent.clearance = nearest(made.table, found, count, agent.position, x, y, z, wide)
        agent.least = min(agent.least, agent.clearance)
        moved(p, agent)
        remains = away(p, agent.goal)
        left = timeout - agent.steps * period
        agent.outcome = verdict(p, agent, made.bounds[agent.arena], remains, arrival, radius, left)
        reward[i] = rewarded(agent, weights, remains, period, agent.clearance - radius, 0.0)


@compiled
def verdict(p: Fleet, agent: Agents, bounds: Array, remains: float, arrival: float, radius: float, left: float) -> int:
    """Return how an episode stands; the worst comes first."""
    if lost(p):
        return LOST_CONTROL
    if agent.clearance < radius or p.impact > HARD:
        return COLLIDED
    if remains < arrival:
        return ARRIVED
    for k in range(3):
        if not bounds[k] <= p.state[k] <= bounds[3 + k]:
            return LEFT_BOUNDS
    return TIMED_OUT if left < 1e-9 else FLYING
