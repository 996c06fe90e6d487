"""A depth camera: a picture of ranges."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from crosstrack.sense.ranging import Ranging
from crosstrack.types import Array, NonNegative, Positive

Pixels = Annotated[int, Ge(1), Le(1024)]


@dataclass(frozen=True)
class DepthCamera(Ranging):
    """Measure the range behind every pixel of a pinhole camera; as with stereo, errors grow with the square of it."""

    range: Positive = 10.0
    """m, along a beam, farther than which it sees nothing"""
    rate: Positive = 15.0
    """Hz, pictures a second"""
    noise: NonNegative = 0.002
    """m, standard deviation of a range of 1 m"""
    width: Pixels = 64
    """pixels"""
    height: Pixels = 48
    """pixels"""
    fov_deg: Annotated[float, Gt(0), Lt(180)] = 90.0
    """degrees, field of view from the left to the right edge"""

    @property
    def rows(self) -> int:
        """Rows of pixels."""
        return self.height

    def deviation(self, ranges: Array) -> Array:
        """Return the standard deviation of ranges (rays,), m."""
        return self.noise * np.where(np.isfinite(ranges), ranges, 0.0) ** 2

    def beams(self) -> Array:
        """Return the beams (rays, 3) through the middle of the pixels, from the top left."""
        focal = 0.5 * self.width / math.tan(math.radians(self.fov_deg) / 2)
        left = (0.5 * self.width - 0.5 - np.arange(self.width)) / focal
        up = (0.5 * self.height - 0.5 - np.arange(self.height)) / focal
        beams = np.stack(np.broadcast_arrays(1.0, left, up[:, None]), axis=-1).reshape(-1, 3)
        unit: Array = beams / np.linalg.norm(beams, axis=1, keepdims=True)
        return unit
