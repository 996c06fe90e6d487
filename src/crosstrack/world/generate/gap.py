"""A wall with one narrow gap."""

from dataclasses import dataclass

import numpy as np

from crosstrack.types import Positive
from crosstrack.world.generate.common import Corner, Seed, Size, check
from crosstrack.world.shapes import Box, Shape


@dataclass(frozen=True)
class Gap:
    """A wall across y at half of x, open from bottom to top over one width; the seed places the gap."""

    seed: Seed = 0
    size: Size = (20.0, 10.0, 3.0)
    """m: the wall stands at half of the first, is as long as the second and as high as the third"""
    width: Positive = 1.0
    """m, of the gap"""
    wall: Positive = 0.2
    """m, thickness of the wall"""
    origin: Corner = (0.0, 0.0)
    """m, lowest corner of the rectangle"""

    def __post_init__(self) -> None:
        width, length = self.width, self.size[1]
        check(
            (
                f"width is {width}: it must be below the length of the wall, {length}" if width >= length else "",
                f"wall is {self.wall}: it must not be above {self.size[0]}" if self.wall > self.size[0] else "",
            )
        )

    def shapes(self, ground: float = 0.0) -> tuple[Shape, ...]:
        """Return the wall on either side of the gap, which is within the middle 80 % where there is room."""
        rng = np.random.default_rng(self.seed)
        length = self.size[1]
        margin = min(0.1 * length, 0.5 * (length - self.width))
        low = self.origin[1] + float(rng.uniform(margin, length - self.width - margin))
        middle, half = self.origin[0] + 0.5 * self.size[0], 0.5 * self.wall
        top, end = ground + self.size[2], self.origin[1] + length
        sides = ((self.origin[1], low), (low + self.width, end))
        return tuple(Box((middle - half, a, ground), (middle + half, b, top)) for a, b in sides if a < b)
