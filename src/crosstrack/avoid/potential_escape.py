"""Ways out of a local minimum: notice it, choose a side from the obstacle's geometry, turn the repulsion to it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Le

from crosstrack.avoid.potential_sources import Near
from crosstrack.avoid.potential_turning import continued
from crosstrack.types import Array, Positive, unset
from crosstrack.vectors import across, direction, norm

UP = np.array([0.0, 0.0, 1.0])
FLAT = 0.3
"""least sine of the angle between an obstacle's direction and the axis to go around"""
NARROW = 0.5
"""of the gap held while an obstacle is followed: nearer than this, what is ahead is followed next"""
NEARER = 0.5
"""of that gap: by how much nearer to the goal than it began a way around must lead"""
LOOK = 24
"""points along the attraction that are looked at for room, the gap held apart"""
ROUND = 10.0
"""of that gap: the way after which the place where it began counts as come back to"""

Clear = Callable[[Array], Array]
"""Says how much room (n,) m there is at points (n, 3) m."""
Side = Literal["chosen", "left", "right"]


@dataclass(frozen=True)
class Escape:
    """What to do in a local minimum of the field.

    The vehicle is in one when obstacles are near and the goal comes nearer more slowly than a share of the speed that
    it would have without them: V_ra < share l.

    `rotate` turns the repulsion of each obstacle by θ from the direction n away from it towards a direction t along it:
    the side on which the attraction passes it already, or, where it leads straight into the obstacle, the side that
    scores best in

        t·(attraction) + t·(repulsion) + room along t,

    each at most 1. So n x t, the axis of the rotation, is that of a trunk, or the direction of a beam, where that is
    the short way around. `left` and `right` turn counter-clockwise and clockwise about the vertical.
    With `keep`, a vehicle that is still held up follows the obstacle on that side, at a gap, until the free way towards
    the goal leads nearer to it than where that began. `walk` flies in a random direction for a while instead.

    Sources: Li 2020 (ICAICE), the rotation; the sides, the third dimension and what is kept are this library's own,
    the last after Kamon and Rivlin 1997 (IEEE Trans. Robotics and Automation 13(6), DistBug), who show that in the
    plane it finds the way out if there is one.
    """

    kind: Literal["none", "rotate", "walk"] = "none"
    """how to leave a local minimum"""
    angle_deg: Annotated[float, Gt(0), Le(120)] = 60.0
    """degrees, θ, by which the repulsion is turned"""
    side: Side = "chosen"
    """to which side it is turned"""
    keep: bool = False
    """whether an obstacle that still holds up is followed until the goal is nearer than before"""
    share: Annotated[float, Gt(0), Le(1)] = 0.6
    """of the free speed, the approach under which the vehicle counts as trapped"""
    held_up: Annotated[float, Gt(0), Le(1)] = 0.2
    """likewise, under which it counts as held up"""
    window: Positive = 1.0
    """s, over which the approach is averaged, and that a random walk lasts"""

    @property
    def angle(self) -> float:
        """rad, θ"""
        return math.radians(self.angle_deg)


@dataclass(frozen=True)
class Escaping:
    """What is remembered of the way to the goal and of the way around an obstacle."""

    closing: float
    """m/s, V_ra, averaged: how fast the goal comes nearer"""
    remaining: float
    """m, to the goal, at the last step"""
    axis: Array = field(default_factory=unset)
    """(3,) unit, that the repulsion is turned about, or the direction of a random walk; NaN when not trapped"""
    foot: Array = field(default_factory=unset)
    """(3,) m, point of the obstacle that is followed; NaN when none is"""
    away: Array = field(default_factory=unset)
    """(3,) unit, from there to the vehicle"""
    gap: float = math.inf
    """m, to there"""
    entry: Array = field(default_factory=unset)
    """(3,) m, where that began"""
    least: float = math.inf
    """m, to the goal where that began"""
    travelled: float = 0.0
    """m, since"""
    left: float = 0.0
    """s, that a random walk goes on"""
    turned: bool = False
    """whether the other side was tried already"""

    @property
    def trapped(self) -> bool:
        """Whether the vehicle is leaving a local minimum."""
        return not math.isnan(self.axis[0])

    @property
    def following(self) -> bool:
        """Whether it follows an obstacle."""
        return not math.isnan(self.foot[0])

    def approached(self, remaining: float, duration: float, window: float) -> "Escaping":
        """Return the same after a step of a duration (s) that left a distance (m) to the goal."""
        rate = (self.remaining - remaining) / duration
        closing = self.closing + min(1.0, duration / window) * (rate - self.closing)
        return replace(self, closing=closing, remaining=remaining)

    def freed(self, speed: float) -> "Escaping":
        """Return the memory after a way out: the approach is judged anew, from a free speed (m/s)."""
        return Escaping(speed, self.remaining)


@dataclass(frozen=True)
class Situation:
    """What a decision in a local minimum is made of."""

    position: Array
    """(3,) m"""
    way: Array
    """(3,) unit, where the attraction goes"""
    push: Array
    """(3,) unit, where the repulsion goes; zero without any"""
    near: Near
    """what repels"""
    speed: float
    """m/s, l, of a vehicle that nothing repels"""
    held: float
    """m, the gap at which obstacles are followed"""
    reach: float
    """m, how far to look along a side"""
    planar: bool
    """whether all is at one height"""
    clear: Clear
    """how much room there is; -inf where the vehicle may not be at all"""


def decided(escape: Escape, memory: Escaping, at: Situation, duration: float, random: np.random.Generator) -> Escaping:
    """Return the memory with what to do about a local minimum, if there is one.

    Args:
        escape: what to do in one
        memory: brought up to this step by `approached`
        at: the situation
        duration: s, since the last step
        random: for random walks
    """
    if escape.kind == "none":
        return memory
    stalled = len(at.near.gaps) > 0 and memory.closing < escape.share * at.speed
    if escape.kind == "walk":
        return walked(escape, memory, stalled, at, duration, random)
    if memory.following:
        return followed(escape, memory, at, duration)
    if not stalled:
        return memory.freed(memory.closing)
    if not memory.trapped:
        memory = replace(memory, axis=axis_around(escape, at))
    if escape.keep and memory.closing < escape.held_up * at.speed:
        return begun(escape, memory, at)
    return memory


def axis_around(escape: Escape, at: Situation) -> Array:
    """Return the axis (3,) to turn the repulsion of the nearest obstacle about."""
    if escape.side != "chosen":
        return UP if escape.side == "left" else -UP
    away = at.near.away[0]
    sides = tangents(away, at.planar)
    steps = at.reach * np.array([0.5, 1.0, 2.0])
    points = at.position + steps[:, None, None] * sides
    room = np.clip(at.clear(points.reshape(-1, 3)).reshape(points.shape[:2]) / at.reach, -1.0, 1.0).mean(axis=0)
    score = sides @ at.way + sides @ at.push + room
    best = sides[int(np.argmax(np.round(score, 9)))]
    return direction(np.cross(away, best))


def tangents(away: Array, planar: bool) -> Array:
    """Return directions (n, 3) along an obstacle: level ones first, left before right, then up and down."""
    level = np.array([-away[1], away[0], 0.0])
    level = level / norm(level) if norm(level) > FLAT else np.array([0.0, 1.0, 0.0])
    level = direction(across(level, away))
    if planar:
        return np.array([level, -level])
    steep = np.cross(away, level)
    angle = np.array([0, 8, 4, 12, 2, 14, 6, 10, 1, 15, 7, 9, 3, 13, 5, 11]) * np.pi / 8
    return np.asarray(np.cos(angle)[:, None] * level + np.sin(angle)[:, None] * steep)


def begun(escape: Escape, memory: Escaping, at: Situation) -> Escaping:
    """Return the memory at the beginning of a way around the nearest obstacle."""
    gap, away = float(at.near.gaps[0]), at.near.away[0]
    foot = at.position - gap * away
    axis = axis_around(escape, at)
    return Escaping(memory.closing, memory.remaining, axis, foot, away, gap, at.position, memory.remaining)


def followed(escape: Escape, memory: Escaping, at: Situation, duration: float) -> Escaping:
    """Return the memory on the way around: on the other side, once, when this one leads back or out of bounds."""
    if len(at.near.gaps) == 0:
        return memory.freed(at.speed)
    index = continued(memory.axis, memory.foot, at.position, at.near.gaps, at.near.away, NARROW * at.held)
    away = at.near.away[index]
    if at.way @ away >= 0 and memory.remaining - free_way(at) < memory.least - NEARER * at.held:
        return memory.freed(at.speed)
    if norm(np.cross(memory.axis, away)) < FLAT:
        memory = replace(memory, axis=axis_around(escape, at))
    gap = float(at.near.gaps[index])
    foot, travelled = at.position - gap * away, memory.travelled + duration * at.speed
    memory = replace(memory, foot=foot, away=away, gap=gap, travelled=travelled)
    if memory.turned:
        return memory
    ahead = at.position + at.held * direction(np.cross(memory.axis, away))
    back = memory.travelled > ROUND * at.held and norm(at.position - memory.entry) < at.held
    if back or at.clear(ahead[None])[0] == -math.inf:
        return replace(memory, axis=-memory.axis, travelled=0.0, turned=True)
    return memory


def free_way(at: Situation) -> float:
    """Return how far (m) there is room along the attraction."""
    steps = at.held * np.arange(1, LOOK + 1)
    blocked = at.clear(at.position + steps[:, None] * at.way) < 0
    return float(at.held * (np.argmax(blocked) if blocked.any() else LOOK))


def walked(
    escape: Escape, memory: Escaping, stalled: bool, at: Situation, duration: float, random: np.random.Generator
) -> Escaping:
    """Return the memory of a random walk: a direction, held for a window."""
    if memory.trapped:
        left = memory.left - duration
        return replace(memory, left=left) if left > 0 else memory.freed(at.speed)
    if not stalled:
        return memory
    way = random.normal(size=3) * [1.0, 1.0, 0.0 if at.planar else 1.0]
    return replace(memory, axis=direction(way), left=escape.window)
