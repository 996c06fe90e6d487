"""A forest of round trunks."""

from dataclasses import dataclass

import numpy as np

from crosstrack.types import NonNegative, Positive
from crosstrack.world.generate.common import MOST_SHAPES, Corner, Seed, Size, check
from crosstrack.world.shapes import Cylinder, Shape


@dataclass(frozen=True)
class Forest:
    """Trunks scattered evenly over a rectangle, each wherever chance has it: they may touch."""

    seed: Seed = 0
    size: Size = (40.0, 20.0, 3.0)
    """m, the rectangle that the trunks' axes lie in, and their height"""
    density: NonNegative = 0.2
    """trees per m²"""
    radius: tuple[Positive, Positive] = (0.1, 0.3)
    """m, thinnest and thickest trunk"""
    clear: tuple[Corner, ...] = ()
    """m, points around which no trunk stands"""
    clear_radius: NonNegative = 2.0
    """m, from such a point to the bark"""
    origin: Corner = (0.0, 0.0)
    """m, lowest corner of the rectangle"""

    def __post_init__(self) -> None:
        thin, thick = self.radius
        check(
            (
                f"radius is {list(self.radius)}: the first must not be above the second" if thin > thick else "",
                f"size and density ask for {self.count} trees; at most {MOST_SHAPES}"
                if self.count > MOST_SHAPES
                else "",
            )
        )

    @property
    def count(self) -> int:
        """Trees before those near `clear` are felled."""
        return round(self.density * self.size[0] * self.size[1])

    def shapes(self, ground: float = 0.0) -> tuple[Shape, ...]:
        """Return the trunks."""
        rng = np.random.default_rng(self.seed)
        middle = rng.uniform(size=(self.count, 2)) * self.size[:2] + self.origin
        radius = rng.uniform(*self.radius, size=self.count)
        kept = np.ones(self.count, dtype=bool)
        for point in self.clear:
            kept &= np.linalg.norm(middle - point, axis=1) - radius >= self.clear_radius
        z = (ground, ground + self.size[2])
        trunks = zip(middle[kept].tolist(), radius[kept].tolist(), strict=True)
        return tuple(Cylinder((x, y), r, z) for (x, y), r in trunks)
