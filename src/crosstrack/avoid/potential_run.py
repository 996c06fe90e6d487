"""The potential field alone, flown by a point in the plane or in space: what its terms do, without a vehicle."""

import math
from dataclasses import dataclass, field
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.avoid.potential_braking import held_back
from crosstrack.avoid.potential_escape import Escape, Escaping, Situation, decided
from crosstrack.avoid.potential_field import Terms, attraction, repulsions
from crosstrack.avoid.potential_sources import Near, near_map
from crosstrack.avoid.potential_turning import along, turned_all
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Map
from crosstrack.types import Array, NonNegative, Outcome, Positive
from crosstrack.vectors import direction, limited, norm

WALK = 20
"""steps of a random walk on the grid"""
NEARER = 0.01
"""of the tolerance, by which a point must come nearer to the goal than ever to have made progress"""

MARGIN = 0.05
"""m, kept free by braking"""
ROUNDING = 1e-5
"""m, out of bounds that counts as on them"""


@dataclass(frozen=True)
class Law:
    """A field and how a point flies it; the defaults are those of the article, in cells of its map."""

    terms: Terms = field(default_factory=Terms)
    escape: Escape = field(default_factory=Escape)
    method: Literal["force", "descent"] = "force"
    """`force` takes the force as an acceleration; `descent` goes to the neighbour of least potential"""
    damping: NonNegative = 0.0
    """1/s, force against the velocity; without any, as in the article, a point can circle the goal for ever"""
    braking: bool = False
    """whether the approach to obstacles is held to what can be stopped"""
    speed: Positive = 2.0
    """m/s, the fastest"""
    acceleration: Positive = 2.0
    """m/s², the most"""
    step: Positive = 0.2
    """s, between two decisions; a step of the grid is as long as the way flown in it"""
    radius: NonNegative = 0.0
    """m, of the vehicle"""
    tolerance: Positive = 2.0
    """m, from the goal, that counts as arrived"""
    patience: Positive = 100.0
    """s without coming nearer to the goal than ever, after which the point counts as stuck"""
    seed: int = 0
    """of random walks"""

    @property
    def held(self) -> float:
        """m, the gap at which an obstacle is followed: where there is room for it"""
        return min(0.5 * self.terms.influence, 1.0 + 0.5 * self.speed**2 / self.acceleration)


@dataclass(frozen=True)
class PotentialRun:
    """What a point flew."""

    points: Array
    """(n, 2) or (n, 3) m"""
    outcome: Outcome
    clearance: float
    """m, least distance to an obstacle, swept"""
    trapped: int
    """steps spent in local minima"""

    @property
    def length(self) -> float:
        """m, of the path"""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


def potential_path(
    world: Map, start: ArrayLike, goal: ArrayLike, law: Law | None = None, height: float = 1.0
) -> PotentialRun:
    """Fly a point by a potential field alone, from rest, until it arrives or can go no further.

    Every step is swept: no obstacle is too thin to be hit.

    Args:
        world: what is in the way
        start: (2,) or (3,) m; with two numbers all is at one height
        goal: likewise
        law: the field; Khatib's without one
        height: m, of a path in the plane

    Raises:
        InputError: start and goal are not two points of the same plane or space.
    """
    law = law or Law()
    ends = [np.asarray(point, dtype=float) for point in (start, goal)]
    if ends[0].shape != ends[1].shape or ends[0].shape not in {(2,), (3,)} or not np.isfinite(ends).all():
        shapes = " and ".join(str(end.tolist()) for end in ends)
        raise InputError("potential_path", [Problem("start, goal", f"{shapes}: two or three finite numbers each")])
    planar = ends[0].shape == (2,)
    begin, end = (np.append(point, height) if planar else point for point in ends)
    run = Run(world, end, law, planar)
    return run.fly(begin) if law.method == "force" else run.descend(begin)


class Run:
    """One flight of a point."""

    def __init__(self, world: Map, goal: Array, law: Law, planar: bool) -> None:
        self.world, self.goal, self.law, self.planar = world, goal, law, planar
        self.random = np.random.default_rng(law.seed)
        self.points: list[Array] = []
        self.clearance = math.inf
        self.trapped = 0
        self.best, self.since = math.inf, 0

    def near(self, position: Array) -> Near:
        """Return what repels at a position."""
        reach = self.law.terms.influence + self.law.radius
        return near_map(self.world, position, reach, self.planar).grown(self.law.radius)

    def clear(self, points: Array) -> Array:
        """Return the room (n,) m at points (n, 3), -inf out of bounds."""
        room = self.world.distance(points) - self.law.radius
        return np.where(self.within(points), room, -np.inf)

    def within(self, points: Array) -> Array:
        """Return whether points (..., 3) are above the ground and within bounds."""
        axes = 2 if self.planar else 3
        inside = points[..., 2] >= self.world.ground - ROUNDING
        if self.world.bounds is not None:
            low, high = self.world.bounds[:, :axes]
            flat = points[..., :axes]
            inside = inside & ((flat >= low - ROUNDING) & (flat <= high + ROUNDING)).all(axis=-1)
        return np.asarray(inside)

    def ending(self, position: Array) -> Outcome | None:
        """Return how the run ends at a position it has reached, if it does."""
        remaining = norm(self.goal - position)
        if remaining <= self.law.tolerance:
            return Outcome.ARRIVED
        self.since += 1
        if remaining < self.best - NEARER * self.law.tolerance:
            self.best, self.since = remaining, 0
        return Outcome.STUCK if self.since * self.law.step > self.law.patience else None

    def moved(self, before: Array, after: Array) -> Outcome | None:
        """Add a step to the path and return how it ends the run, if it does."""
        least = self.world.swept(before, after)
        self.clearance = min(self.clearance, least)
        self.points.append(after)
        if least < self.law.radius or least <= 0:
            return Outcome.COLLIDED
        return None if self.within(after) else Outcome.LEFT_BOUNDS

    def result(self, outcome: Outcome) -> PotentialRun:
        """Return what was flown."""
        points = np.array(self.points)
        return PotentialRun(points[:, :2] if self.planar else points, outcome, self.clearance, self.trapped)

    def fly(self, position: Array) -> PotentialRun:
        """Take the force as an acceleration."""
        law, velocity = self.law, np.zeros(3)
        memory = Escaping(law.speed, norm(self.goal - position))
        outcome = self.moved(position, position)
        while outcome is None and (outcome := self.ending(position)) is None:
            near = self.near(position)
            memory = memory.approached(norm(self.goal - position), law.step, max(law.step, law.escape.window))
            force, memory = self.force(memory, position, velocity, near)
            self.trapped += memory.trapped
            velocity = limited(
                velocity + law.step * limited(force - law.damping * velocity, law.acceleration), law.speed
            )
            if law.braking:
                velocity = self.braked(position, velocity, near)
            before, position = position, position + law.step * velocity
            outcome = self.moved(before, position)
        return self.result(outcome)

    def force(self, memory: Escaping, position: Array, velocity: Array, near: Near) -> tuple[Array, Escaping]:
        """Return the acceleration (3,) m/s² that the field asks for, and the new memory."""
        law, way = self.law, self.goal - position
        numbers = law.terms.numbers
        pull = attraction(way, numbers[0], numbers[1])[1]
        pushes = near.facing[:, None] * repulsions(way, near.gaps, near.away, numbers)[:, 1:]
        push = pushes.sum(axis=0)
        pull = law.terms.strengthened(norm(way), law.speed, memory.closing) * pull
        at = Situation(
            position=position,
            way=direction(way),
            push=direction(push),
            near=near,
            speed=law.speed,
            held=law.held,
            reach=law.terms.influence,
            planar=self.planar,
            clear=self.clear,
        )
        memory = decided(law.escape, memory, at, law.step, self.random)
        if not memory.trapped:
            return pull + push, memory
        if law.escape.kind == "walk":
            return law.acceleration * memory.axis, memory
        if memory.following:
            wanted = law.speed * along(memory.axis, memory.away, memory.gap, law.held)
            return (wanted - velocity) / law.step, memory
        chosen = law.escape.side == "chosen"
        return pull + turned_all(pushes, near.away, at.way, memory.axis, law.escape.angle, chosen), memory

    def braked(self, position: Array, velocity: Array, near: Near) -> Array:
        """Return a velocity from which the point stops before obstacles and bounds."""
        law = self.law
        gaps, away = walls(self.world, position, 2 if self.planar else 3)
        gaps, away = np.append(near.gaps - MARGIN, gaps), np.concatenate([near.away, away])
        return held_back(velocity, gaps, away, np.zeros(len(gaps)), law.acceleration, law.step)

    def descend(self, position: Array) -> PotentialRun:
        """Go to the neighbour of least potential, again and again."""
        law = self.law
        sides = [side for side in product((-1.0, 0.0, 1.0), repeat=2 if self.planar else 3) if any(side)]
        steps = law.speed * law.step * np.array([(*side, 0.0)[:3] for side in sides])
        here, walk = self.potential(position), 0
        outcome = self.moved(position, position)
        while outcome is None and (outcome := self.ending(position)) is None:
            ways = [step for step in steps if self.free(position, position + step)]
            if not ways:
                return self.result(Outcome.STUCK)
            heights = [self.potential(position + step) for step in ways]
            choice = int(np.argmin(heights))
            if walk == 0 and heights[choice] >= here:
                if law.escape.kind != "walk":
                    return self.result(Outcome.STUCK)
                walk = WALK
            if walk > 0:
                walk, self.trapped = walk - 1, self.trapped + 1
                choice = int(self.random.integers(len(ways)))
            before, position, here = position, position + ways[choice], heights[choice]
            outcome = self.moved(before, position)
        return self.result(outcome)

    def free(self, before: Array, after: Array) -> bool:
        """Return whether the straight way between two points is."""
        return bool(self.within(after)) and self.world.swept(before, after) > self.law.radius

    def potential(self, position: Array) -> float:
        """Return the potential at a position, m²/s²."""
        return potential_at(self.world, position, self.goal, self.law.terms, self.law.radius, self.planar)


def potential_at(
    world: Map, position: Array, goal: Array, terms: Terms, radius: float = 0.0, planar: bool = False
) -> float:
    """Return the potential (m²/s²) at a position (3,) m; the repulsion of an obstacle is greatest on its surface."""
    near = near_map(world, position, terms.influence + radius, planar).grown(radius)
    way, numbers = goal - position, terms.numbers
    pull = attraction(way, numbers[0], numbers[1])[0]
    return float(terms.boost * pull + repulsions(way, near.gaps, near.away, numbers)[:, 0].sum())


def walls(world: Map, position: Array, axes: int) -> tuple[Array, Array]:
    """Return gaps (n,) m to the bounds of a world, in space the ground too, and directions (n, 3) away from them."""
    gaps: list[float] = []
    away: list[Array] = []
    if world.bounds is not None:
        for k in range(axes):
            gaps += [position[k] - world.bounds[0, k], world.bounds[1, k] - position[k]]
            away += [np.eye(3)[k], -np.eye(3)[k]]
    if axes == 3:
        gaps.append(position[2] - world.ground)
        away.append(np.eye(3)[2])
    return np.array(gaps), np.array(away).reshape(-1, 3)
