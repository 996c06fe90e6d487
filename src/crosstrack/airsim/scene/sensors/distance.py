"""A distance sensor: one ray."""

from typing import Literal

import numpy as np

from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.section import Above, AtLeast, Mounted
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor, mounting
from crosstrack.airsim.scene.sensors.timing import Timing
from crosstrack.airsim.structs import DistanceSensorData


class DistanceSettings(Enabled, Timing, Mounted):
    """A distance sensor of settings.json."""

    sensor_type: Literal[5]
    min_distance: AtLeast = 0.2
    """m, reported, but not enforced"""
    max_distance: Above = 40.0
    """m, what is measured where nothing is hit"""
    uncorrelated_noise_sigma: AtLeast = 0.2
    """m, of the noise"""


class Distance(Sensor):
    """Measure how far it is, straight ahead of the sensor."""

    def __init__(self, settings: DistanceSettings, random: np.random.Generator) -> None:
        super().__init__(settings, random)
        self.settings, self.pose = settings, mounting(settings)

    def blank(self) -> DistanceSensorData:
        """Return zeros."""
        return DistanceSensorData()

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> DistanceSensorData:
        """Return how far the obstacle is."""
        settings, pose = self.settings, moment.world_pose(time, self.pose)
        ahead = matrix(pose.orientation)[:, :1].T
        far = min(float(moment.sight.cast(pose.position, ahead, settings.max_distance)[0][0]), settings.max_distance)
        far += settings.uncorrelated_noise_sigma * float(self.random.standard_normal())
        return DistanceSensorData(time, far, settings.min_distance, settings.max_distance, self.pose)
