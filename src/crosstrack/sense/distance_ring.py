"""Single beams around the vehicle, as of time-of-flight sensors on small drones."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le

from crosstrack.sense.ranging import Ranging
from crosstrack.types import Array, NonNegative, Positive


@dataclass(frozen=True)
class DistanceRing(Ranging):
    """Measure single ranges around the body, the first ahead, then to the left."""

    range: Positive = 4.0
    """m, farther than which it sees nothing"""
    rate: Positive = 20.0
    """Hz, scans a second"""
    noise: NonNegative = 0.02
    """m, standard deviation of a range"""
    count: Annotated[int, Ge(1), Le(360)] = 8
    """beams, evenly around"""

    @property
    def rows(self) -> int:
        """One."""
        return 1

    def beams(self) -> Array:
        """Return the beams (rays, 3)."""
        around = 2 * np.pi * np.arange(self.count) / self.count
        return np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=-1)
