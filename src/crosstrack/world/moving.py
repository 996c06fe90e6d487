"""Obstacles that move at a steady velocity, for ever or back and forth."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array, Others, Positive, Vector
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.table import tabulate
from crosstrack.world.world import World

MOST_BALLS = 64
"""that one shape is covered with"""


@dataclass(frozen=True)
class Moving:
    """A solid, where it is at time 0, and how it moves."""

    shape: Shape
    """at time 0"""
    velocity: Vector
    """m/s, at time 0"""
    turns: Positive | None = None
    """s, after which it turns back, again and again; None where it never does"""

    def heading(self, time: float) -> tuple[float, float]:
        """Return for how long (s) it would have moved straight to be where it is at a time (s), and its sense, ±1."""
        if self.turns is None:
            return time, 1.0
        since = time % (2 * self.turns)
        return (since, 1.0) if since < self.turns else (2 * self.turns - since, -1.0)

    def shift(self, time: float) -> Array:
        """Return how far it has moved at a time (s), (3,) m."""
        return self.heading(time)[0] * np.array(self.velocity, dtype=float)

    def turning(self, before: float, after: float) -> Iterator[float]:
        """Yield the times (s) of an interval at which it turns back."""
        if self.turns is not None:
            for count in range(math.floor(before / self.turns) + 1, math.ceil(after / self.turns)):
                yield count * self.turns


@dataclass(frozen=True, eq=False)
class MovingObstacles:
    """Several of them, a `protocols.Traffic`."""

    movers: tuple[Moving, ...]
    ground: float = 0.0
    """m, height of the ground, which is no obstacle"""

    @cached_property
    def still(self) -> tuple[World, ...]:
        """Each alone, as it stands at time 0"""
        return tuple(World((mover.shape,), ground=self.ground) for mover in self.movers)

    @cached_property
    def balls(self) -> tuple[Array, Array, NDArray[np.int64]]:
        """Centres (n, 3) m and radii (n,) m of balls that hold them at time 0, and which mover is in each (n,)"""
        covers = [cover(world) for world in self.still]
        centers, radii = (np.concatenate(parts) for parts in zip(*covers, strict=True))
        return centers, radii, np.repeat(np.arange(len(covers)), [len(radii) for _, radii in covers])

    def at(self, time: float) -> World:
        """Return them as they stand at a time (s)."""
        return World(tuple(moved(mover.shape, mover.shift(time)) for mover in self.movers), ground=self.ground)

    def others(self, time: float) -> Others:
        """Return balls that hold them at a time (s), and how they move; a sphere is its own ball."""
        centers, radii, mover = self.balls
        shifts = np.array([each.shift(time) for each in self.movers])
        velocities = np.array([each.heading(time)[1] * np.array(each.velocity) for each in self.movers])
        return Others(centers + shifts[mover], velocities[mover], radii, np.zeros(len(radii), dtype=bool))

    def swept(self, start: Array, end: Array, before: float, after: float) -> float:
        """Return the least signed distance (m) to them of a point that goes straight from `start` to `end` (3,) m.

        It leaves at the time `before` and gets there at the time `after` (s). As seen from an obstacle that does
        not turn meanwhile it goes straight too, so what holds for `World.swept` holds here.
        """
        least = math.inf
        for mover, world in zip(self.movers, self.still, strict=True):
            times = [before, *mover.turning(before, after), after]
            parts = [(time - before) / (after - before) if after > before else 0.0 for time in times[:-1]]
            seen = [
                start + part * (end - start) - mover.shift(time)
                for part, time in zip([*parts, 1.0], times, strict=True)
            ]
            least = min(least, *(world.swept(one, two) for one, two in pairwise(seen)))
        return least


def moved(shape: Shape, by: Array) -> Shape:
    """Return a shape displaced by (3,) m."""
    x, y, z = by.tolist()
    match shape:
        case Sphere(center=(cx, cy, cz)):
            return replace(shape, center=(cx + x, cy + y, cz + z))
        case Cylinder(center=(cx, cy), z=(lo, hi)):
            return replace(shape, center=(cx + x, cy + y), z=(lo + z, hi + z))
        case Prism(z=(lo, hi)):
            polygon = tuple((px + x, py + y) for px, py in shape.polygon)
            return replace(shape, polygon=polygon, z=(lo + z, hi + z))
        case Box(min=(x0, y0, z0), max=(x1, y1, z1)):
            return Box((x0 + x, y0 + y, z0 + z), (x1 + x, y1 + y, z1 + z))


def cover(world: World) -> tuple[Array, Array]:
    """Return centres (n, 3) m and radii (n,) m of at most 64 balls that together hold the one shape of a world.

    Around a cylinder they stand in a stack. Any other shape is cut into cells about as wide as its thinnest side, and
    every cell that it reaches into gets the ball around it.
    """
    (shape,) = world.shapes
    match shape:
        case Sphere():
            return np.array([shape.center], dtype=float), np.array([shape.radius])
        case Cylinder(center=(x, y), z=(lo, hi)):
            count = min(math.ceil((hi - lo) / shape.radius), MOST_BALLS)
            half = (hi - lo) / count / 2
            heights = lo + half * (2 * np.arange(count) + 1)
            stack = np.column_stack([np.full(count, x), np.full(count, y), heights])
            return stack, np.full(count, math.hypot(shape.radius, half))
    table = tabulate(world.shapes, ())
    assert table is not None
    low, high = table.boxes[0].reshape(2, 3)
    counts = cell_counts(high - low)
    cell = (high - low) / counts
    centers = low + cell * (0.5 + np.array(list(product(*map(range, counts))), dtype=float))
    radius = float(np.linalg.norm(cell)) / 2
    held = world.distance(centers) <= radius
    return centers[held], np.full(int(held.sum()), radius)


def cell_counts(size: Array) -> list[int]:
    """Return into how many cells to cut a box (3,) m along each axis, at most 64 in all, as near to cubes as can be."""
    edge = float(size.min())
    while (counts := np.ceil(size / edge)).prod() > MOST_BALLS:
        edge *= 1.1
    return [int(count) for count in counts]
