"""City blocks between straight streets."""

from dataclasses import dataclass

import numpy as np

from crosstrack.types import Positive
from crosstrack.world.generate.common import MOST_SHAPES, Corner, Seed, Size, check
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape


@dataclass(frozen=True)
class City:
    """One building on each square block: a tower on a square, a round or an L-shaped floor.

    The middle lines of the streets lie at whole multiples of `block` + `street` from the origin, the first
    and the last street around the city.
    """

    seed: Seed = 0
    size: Size = (100.0, 100.0, 40.0)
    """m, along x and y, and the height of the tallest building allowed"""
    block: Positive = 16.0
    """m, side of a block"""
    street: Positive = 9.0
    """m, width that stays free between blocks"""
    lowest: Positive = 8.0
    """m, height of the lowest building allowed"""
    origin: Corner = (0.0, 0.0)
    """m, lowest corner"""

    def __post_init__(self) -> None:
        columns, rows = (size / (self.block + self.street) for size in self.size[:2])
        low, top = self.lowest, self.size[2]
        many = columns * rows > MOST_SHAPES
        check(
            (
                f"size {list(self.size[:2])} must hold a block and its street" if min(columns, rows) < 1 else "",
                f"size, block and street give {columns * rows:.6g} blocks; at most {MOST_SHAPES}" if many else "",
                f"lowest is {low}: it must not be above the height in size, {top}" if low > top else "",
            )
        )

    def shapes(self, ground: float = 0.0) -> tuple[Shape, ...]:
        """Return the buildings, west to east within south to north."""
        rng = np.random.default_rng(self.seed)
        pitch = self.block + self.street
        columns, rows = (int(size / pitch + 1e-9) for size in self.size[:2])
        return tuple(
            self._building(self.origin[0] + (i + 0.5) * pitch, self.origin[1] + (j + 0.5) * pitch, ground, rng)
            for j in range(rows)
            for i in range(columns)
        )

    def _building(self, x: float, y: float, ground: float, rng: np.random.Generator) -> Shape:
        """Return the building on the block around (x, y)."""
        half = 0.5 * self.block * float(rng.uniform(0.75, 1.0))
        z = (ground, ground + float(rng.uniform(self.lowest, self.size[2])))
        style = rng.uniform()
        if style < 0.6:
            return Box((x - half, y - half, z[0]), (x + half, y + half, z[1]))
        if style < 0.8:
            return Cylinder((x, y), half, z)
        notch = half * float(rng.uniform(0.0, 0.4))
        corners: tuple[tuple[float, float], ...] = (
            (-half, -half),
            (half, -half),
            (half, notch),
            (notch, notch),
            (notch, half),
            (-half, half),
        )
        turn = int(rng.integers(4))
        for _ in range(turn):
            corners = tuple((-b, a) for a, b in corners)
        return Prism(tuple((x + a, y + b) for a, b in corners), z)
