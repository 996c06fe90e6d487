"""What all sensors that measure ranges have in common."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from annotated_types import Ge, Lt

from crosstrack.compiled import compiled
from crosstrack.protocols import Map
from crosstrack.sense.pose import axes, mounting
from crosstrack.types import Array, Finite, NonNegative, Positive, Scan, State, Vector

Share = Annotated[float, Ge(0), Lt(1)]


@dataclass(frozen=True)
class Ranging(ABC):
    """Measure ranges along beams that are fixed to the body."""

    range: Positive = 15.0
    """m, farther than which it sees nothing"""
    rate: Positive = 10.0
    """Hz, scans a second"""
    noise: NonNegative = 0.01
    """m, standard deviation of a range"""
    dropouts: Share = 0.0
    """share of the beams that measure nothing, by chance"""
    position: Vector = (0.0, 0.0, 0.0)
    """m, of the sensor in the body: forward, left, up"""
    yaw_deg: Finite = 0.0
    """degrees, to the left, which way it looks"""
    pitch_deg: Finite = 0.0
    """degrees, down, which way it looks"""

    @property
    @abstractmethod
    def rows(self) -> int:
        """Of the picture that the beams form."""

    @abstractmethod
    def beams(self) -> Array:
        """Return the beams as unit vectors (rays, 3) in axes of the sensor: forward, left, up; row by row."""

    def deviation(self, ranges: Array) -> Array | float:
        """Return the standard deviation of ranges (rays,), m."""
        return self.noise

    @cached_property
    def directions(self) -> Array:
        """(rays, 3) unit vectors, body"""
        directions = np.ascontiguousarray(
            self.beams() @ mounting(math.radians(self.yaw_deg), math.radians(self.pitch_deg)).T
        )
        directions.setflags(write=False)
        return directions

    def look(self, world: Map, state: State, random: np.random.Generator) -> Scan:
        """Return what it sees in a world from a true state; the ground of the world is seen too.

        A range that the noise takes beyond what the sensor reaches is not seen, one that it takes below zero is zero.
        """
        turned = axes(state.attitude)
        mount = np.array(self.position)
        origin = state.position + turned @ mount
        directions = self.directions @ turned.T
        ranges = world.cast(origin, directions, self.range)
        ranges = grounded(ranges, directions, float(origin[2]) - world.ground, self.range)
        if self.noise > 0.0:
            ranges = ranges + self.deviation(ranges) * random.standard_normal(len(ranges))
            ranges = np.where(ranges > self.range, np.inf, np.maximum(ranges, 0.0))
        if self.dropouts > 0.0:
            ranges[random.uniform(size=len(ranges)) < self.dropouts] = np.nan
        return Scan(state.time, mount, self.directions, ranges, self.range, self.rows)


@compiled
def grounded(ranges: Array, directions: Array, height: float, reach: float) -> Array:
    """Return ranges (rays,) cut short by the ground, which lies `height` (m) below where the rays begin."""
    out = np.empty(len(ranges))
    for i in range(len(ranges)):
        t = ranges[i]
        if height <= 0.0:
            t = 0.0
        elif -directions[i, 2] * reach >= height:
            t = min(t, -height / directions[i, 2])
        out[i] = t
    return out
