"""A dead end: what turns a law that only looks ahead into a prisoner."""

from dataclasses import dataclass

import numpy as np

from crosstrack.types import Positive
from crosstrack.world.generate.common import Corner, Seed, Size, check
from crosstrack.world.shapes import Box, Shape


@dataclass(frozen=True)
class Trap:
    """Three walls as a U that is open towards -x; the seed draws the lengths of its arms."""

    seed: Seed = 0
    size: Size = (10.0, 8.0, 3.0)
    """m: the longest arms allowed (along x), the outside width (along y), and the height"""
    wall: Positive = 0.2
    """m, thickness of the walls"""
    origin: Corner = (0.0, 0.0)
    """m, lowest corner of the rectangle around it; its back is at the far end of x"""

    def __post_init__(self) -> None:
        room = min(self.size[0] / 2, self.size[1] / 2)
        check(
            [f"wall is {self.wall}: it must be below {room:g}, half of the smaller side" if self.wall >= room else ""]
        )

    def shapes(self, ground: float = 0.0) -> tuple[Shape, ...]:
        """Return the back, and the southern and the northern arm from half to all of the length allowed."""
        rng = np.random.default_rng(self.seed)
        (x, y), (long, wide, high) = self.origin, self.size
        south, north = (x + long * float(start) for start in rng.uniform(0, 0.5, size=2))
        end, top, thick = x + long, ground + high, self.wall
        return (
            Box((end - thick, y, ground), (end, y + wide, top)),
            Box((south, y, ground), (end, y + thick, top)),
            Box((north, y + wide - thick, ground), (end, y + wide, top)),
        )
