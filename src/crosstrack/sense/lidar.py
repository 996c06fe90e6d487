"""A lidar: rings of beams around the vertical axis."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from crosstrack.sense.ranging import Ranging
from crosstrack.types import Array

Count = Annotated[int, Ge(1), Le(4096)]
Elevation = Annotated[float, Ge(-90), Le(90)]


@dataclass(frozen=True)
class Lidar(Ranging):
    """Spin rings of beams about the axis that points up from the body; all beams of a scan at one instant."""

    rings: Annotated[int, Ge(1), Le(256)] = 16
    """of beams, one above the other"""
    columns: Count = 360
    """beams of a ring"""
    lowest_deg: Elevation = -30.0
    """degrees, elevation of the lowest ring"""
    highest_deg: Elevation = 30.0
    """degrees, elevation of the highest ring"""
    fov_deg: Annotated[float, Gt(0), Le(360)] = 360.0
    """degrees, field of view around the vertical, half to either side"""

    def __post_init__(self) -> None:
        if self.lowest_deg > self.highest_deg:
            raise ValueError(f"lowest_deg is {self.lowest_deg}: it must not be above highest_deg, {self.highest_deg}")

    @property
    def rows(self) -> int:
        """Rings."""
        return self.rings

    def beams(self) -> Array:
        """Return the beams (rays, 3): the lowest ring first, each from right to left, or from behind all around."""
        around = np.radians(self.fov_deg * ((np.arange(self.columns) + 0.5) / self.columns - 0.5))
        up = np.radians(np.linspace(self.lowest_deg, self.highest_deg, self.rings))[:, None]
        parts = (np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up) + 0.0 * around)
        return np.stack(parts, axis=-1).reshape(-1, 3)
