"""A lidar whose lasers, one above the other, turn about the sensor's down axis."""

from typing import Literal

import numpy as np
from pydantic import Field

from crosstrack.airsim.scene.poses import matrix, onto
from crosstrack.airsim.scene.section import Above, Mounted, Number
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor, mounting
from crosstrack.airsim.scene.sensors.timing import Timing
from crosstrack.airsim.structs import LidarData, Pose
from crosstrack.types import Array

MOST_POINTS = 100_000
"""of one update"""


class LidarSettings(Enabled, Timing, Mounted):
    """A lidar of settings.json."""

    sensor_type: Literal[6]
    number_of_channels: int = Field(default=16, ge=1, le=1024)
    """lasers, one above the other"""
    range: Above = 100.0
    """m"""
    points_per_second: int = Field(default=100_000, ge=0, le=100_000_000)
    """of all lasers together"""
    rotations_per_second: int = Field(default=10, ge=0, le=1000)
    vertical_fov_upper: Number = Field(default=-15.0, ge=-90, le=90, validation_alias="VerticalFOVUpper")
    """degrees above the level of the sensor, of the first laser"""
    vertical_fov_lower: Number = Field(default=-45.0, ge=-90, le=90, validation_alias="VerticalFOVLower")
    """degrees above the level of the sensor, of the last laser"""
    horizontal_fov_start: Number = Field(default=0.0, ge=-360, le=360, validation_alias="HorizontalFOVStart")
    """degrees to the right, from where on points are taken"""
    horizontal_fov_end: Number = Field(default=359.0, ge=-360, le=360, validation_alias="HorizontalFOVEnd")
    """degrees to the right, up to where points are taken"""
    data_frame: Literal["VehicleInertialFrame", "SensorLocalFrame"] = "VehicleInertialFrame"
    """of the points: NED from the start of the vehicle, or forward, right, down of the sensor"""
    update_frequency: Above = 10.0


class Lidar(Sensor):
    """Measure what is around, without noise; an update takes in the turn since the one before."""

    def __init__(self, settings: LidarSettings, random: np.random.Generator) -> None:
        super().__init__(settings, random)
        self.settings, self.pose = settings, mounting(settings)
        self.local = settings.data_frame == "SensorLocalFrame"

    def blank(self) -> LidarData:
        """Return no points."""
        return LidarData()

    def columns(self, count: int) -> Array:
        """Return the bearings (degrees, to the right) at which each laser fires in an update."""
        settings = self.settings
        span = (self.sampling.when(count) - self.sampling.when(count - 1)) * 1e-9
        total = min(np.floor(settings.points_per_second * span + 0.5), MOST_POINTS)
        fired = int(total / settings.number_of_channels + 0.5)
        turn = settings.rotations_per_second * 360.0
        began = turn * self.sampling.when(count - 1) * 1e-9
        bearing = (began + turn * span * np.arange(fired) / max(fired, 1)) % 360.0
        first, last = settings.horizontal_fov_start % 360.0, settings.horizontal_fov_end % 360.0
        after, before = bearing >= first, bearing <= last
        kept: Array = bearing[after & before if first < last else after | before]
        return kept

    def beams(self, count: int) -> Array:
        """Return the unit vectors (n, 3) along which an update looks: forward, right, down of the sensor."""
        settings = self.settings
        up = np.linspace(settings.vertical_fov_upper, settings.vertical_fov_lower, settings.number_of_channels)
        around, up = np.radians(self.columns(count)), np.radians(up)[:, None]
        parts = np.broadcast_arrays(np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), -np.sin(up))
        return np.stack(parts, axis=-1).reshape(-1, 3)

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> LidarData:
        """Return the points that were hit."""
        state = moment.history.at(time)
        pose = moment.world_pose(time, self.pose)
        shown = onto(Pose(state.position, state.orientation), self.pose)
        if count == 0:
            return LidarData(time, pose=shown)
        beams = self.beams(count)
        directions = beams @ matrix(pose.orientation).T
        ranges, seen = moment.sight.cast(pose.position, directions, self.settings.range)
        hit = np.isfinite(ranges)
        points = beams[hit] * ranges[hit, None]
        if not self.local:
            points = directions[hit] * ranges[hit, None] + shown.position
        return LidarData(time, points.astype(np.float32).ravel(), shown, seen[hit].astype(np.int32))
