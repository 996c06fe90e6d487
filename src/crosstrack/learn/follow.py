"""Follow: fly along a path in wind, by velocities."""

import math
from dataclasses import dataclass, field
from typing import Annotated, Literal, NamedTuple

import numpy as np
from annotated_types import Ge, Le, Lt
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.learn.agents import Agents
from crosstrack.learn.arenas import seeds
from crosstrack.learn.episodes import drawn, estimated, leashed, moved, rewarded
from crosstrack.learn.randomise import Randomise, draw, put
from crosstrack.learn.rewards import Rewards
from crosstrack.path.rounded import rounded
from crosstrack.policy import motion, path
from crosstrack.policy.motion import write
from crosstrack.policy.path import AHEAD, write_points
from crosstrack.sim.fleet import Fleet
from crosstrack.types import Array, Positive
from crosstrack.world.world import World

SPACING = 0.25
"""m, between points of a route"""
WINDOW = 8
"""points ahead among which the closest is looked for"""
LEGS = 6
"""of a route"""
END = 0.5
"""m, from the end of a route, that counts as there"""
REACH = np.array(AHEAD)
Floats = NDArray[np.float32]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Follow:
    """Fly along a path in three dimensions, in wind."""

    speed: Positive = 5.0
    """m/s, the fastest that is asked for"""
    action: Literal["velocity", "stick", "attitude"] = "velocity"
    """see `crosstrack.policy.action`"""
    period: Annotated[float, Ge(0.02), Lt(1)] = 0.05
    """s, from one decision to the next"""
    timeout: Positive = 60.0
    """s"""
    leash: Positive = 4.0
    """m, from the path where episodes end"""
    maps: Annotated[int, Ge(1), Le(10_000)] = 256
    """routes to draw episodes from"""
    airframe: Literal["generic", "crazyflie", "racer"] = "generic"
    """which airframe"""
    rewards: Rewards = field(
        default_factory=lambda: Rewards(progress=0.5, time=0.2, error=1.0, smoothness=0.02, arrival=5.0, failure=20.0)
    )
    """weights of the reward"""
    randomise: Randomise = field(default_factory=lambda: Randomise(wind=5.0, gusts=0.5))
    """what differs from episode to episode"""

    name = "follow"
    picture = None

    @property
    def seen(self) -> tuple[tuple[str, int], ...]:
        """Name and size of each part of an observation."""
        return (*path.LAYOUT, *motion.LAYOUT)

    def field(self, seed: int, held_out: bool) -> "FollowField":
        """Return the routes, of a seed, with all that is compiled."""
        return FollowField(self, routes(seeds(seed, self.maps, held_out)))


class Routes(NamedTuple):
    """Routes as points SPACING apart."""

    points: Array
    """(m, 3) m, of all, one after another"""
    first: NDArray[np.int64]
    """(routes + 1,) first point of each, and how many there are in all"""


def route(seed: int) -> Array:
    """Return the corners (LEGS + 1, 3) m of a route: legs of 5 to 15 m, turns of up to 100°, slopes of up to 20°."""
    draw_from = np.random.default_rng(seed)
    turns = np.cumsum(draw_from.uniform(-100, 100, LEGS) * (np.arange(LEGS) > 0))
    slopes = draw_from.uniform(-20, 20, LEGS)
    lengths = draw_from.uniform(5, 15, LEGS)
    turns, slopes = np.radians(turns), np.radians(slopes)
    level = np.cos(slopes)
    legs = lengths[:, None] * np.stack([level * np.cos(turns), level * np.sin(turns), np.sin(slopes)], axis=1)
    return np.concatenate([np.zeros((1, 3)), np.cumsum(legs, axis=0)]) + [0.0, 0.0, 40.0]


def routes(seeds: range) -> Routes:
    """Return routes of seeds, their corners rounded within 1 m."""
    made = []
    for seed in seeds:
        smooth = rounded(route(seed), 1.0, 4.0)
        made.append(smooth(np.linspace(0.0, smooth.length, math.ceil(smooth.length / SPACING) + 1)))
    return Routes(np.concatenate(made), np.cumsum([0, *(len(points) for points in made)]))


class FollowField:
    """The task over routes, for many vehicles at once."""

    def __init__(self, task: Follow, made: Routes) -> None:
        self.task, self.routes = task, made
        self.worlds = [World()]
        self.weights, self.spread = task.rewards.weights, task.randomise.numbers
        self.limits = np.array([task.period, task.timeout, task.leash])

    def begin(self, rows: Fleet, nominal: Fleet, agents: Agents, which: Indices, outer: float, in_turn: bool) -> None:
        """Begin episodes."""
        begin(rows, nominal, agents, which, self.routes, self.spread, self.task.speed, outer, in_turn)

    def observe(self, rows: Fleet, agents: Agents, which: Indices, out: Floats) -> None:
        """Write observations."""
        observe(rows, agents, which, self.routes, out)

    def judge(self, rows: Fleet, agents: Agents, reward: Array) -> None:
        """Write rewards, and outcomes where there are any."""
        judge(rows, agents, self.routes, self.weights, self.limits, reward)


@compiled
def begin(
    rows: Fleet,
    nominal: Fleet,
    agents: Agents,
    which: Indices,
    made: Routes,
    spread: Array,
    speed: float,
    outer: float,
    in_turn: bool,
) -> None:
    """Begin episodes at rest where routes begin, see `crosstrack.learn.avoid.begin`."""
    count = len(made.first) - 1
    for i in which:
        p, agent = rows[i], agents[i]
        agent.arena = drawn(agent, i, count, in_turn)
        draw(p, nominal[0], agent, spread, outer)
        first, end = made.first[agent.arena], made.first[agent.arena + 1]
        start, after = made.points[first], made.points[first + 1]
        put(p, agent, start, math.atan2(after[1] - start[1], after[0] - start[0]))
        for k in range(3):
            agent.goal[k] = made.points[end - 1, k]
        agent.speed, agent.progress = speed, 0.0
        agent.potential = SPACING * (end - 1 - first)


@compiled
def at(made: Routes, arena: int, s: float, point: Array) -> None:
    """Write the point (3,) of a route at an arc length (m); beyond its end, its end."""
    first, end = made.first[arena], made.first[arena + 1]
    place = min(max(s / SPACING, 0.0), end - 1.0 - first)
    i = min(int(place), end - 2 - first)
    part, i = place - i, first + i
    for k in range(3):
        point[k] = made.points[i, k] + part * (made.points[i + 1, k] - made.points[i, k])


@compiled
def closest(made: Routes, arena: int, s: float, body: Array) -> tuple[float, float]:
    """Return the arc length (m) of the closest point of a route ahead of `s`, and the distance (m) to it."""
    first, end = made.first[arena], made.first[arena + 1]
    i0 = first + min(int(s / SPACING), end - 2 - first)
    best, where = math.inf, s
    for i in range(i0, min(i0 + WINDOW, end - 1)):
        square = along = size = 0.0
        for k in range(3):
            d = made.points[i + 1, k] - made.points[i, k]
            along += d * (body[k] - made.points[i, k])
            size += d * d
        part = min(1.0, max(0.0, along / size))
        for k in range(3):
            d = made.points[i + 1, k] - made.points[i, k]
            square += (body[k] - made.points[i, k] - part * d) ** 2
        if square < best:
            best, where = square, SPACING * (i - first + part)
    return max(s, where), math.sqrt(best)


@compiled
def observe(rows: Fleet, agents: Agents, which: Indices, made: Routes, out: Floats) -> None:
    """Write observations: the path, then the motion as estimated."""
    body, points = np.empty(13), np.empty((len(REACH), 3))
    size = 3 * len(REACH)
    for i in which:
        p, agent = rows[i], agents[i]
        estimated(p, body)
        s = closest(made, agent.arena, agent.progress, body)[0]
        for k in range(len(REACH)):
            at(made, agent.arena, s + REACH[k], points[k])
        write_points(out[i], 0, body, points)
        write(out[i], size, body, agent.goal, agent.asked, agent.speed)


@compiled
def judge(rows: Fleet, agents: Agents, made: Routes, weights: Array, limits: Array, reward: Array) -> None:
    """Write the rewards (n,) of the decision flown, and how episodes ended.

    Args:
        rows: of vehicles
        agents: changed
        made: routes
        weights: of `Rewards`
        limits: period (s), timeout (s), leash (m)
        reward: (n,) changed
    """
    period, timeout, leash = limits[0], limits[1], limits[2]
    for i in range(rows.shape[0]):
        p, agent = rows[i], agents[i]
        moved(p, agent)
        agent.progress, error = closest(made, agent.arena, agent.progress, p.state)
        remains = SPACING * (made.first[agent.arena + 1] - 1 - made.first[agent.arena]) - agent.progress
        agent.outcome = leashed(p, error, leash, remains < END, timeout - agent.steps * period)
        reward[i] = rewarded(agent, weights, remains, period, math.inf, min(error, leash))
