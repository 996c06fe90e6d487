"""A magnetometer in the field of a dipole."""

from typing import Literal

import numpy as np

from crosstrack.airsim.scene.earth import geodetic, magnetic_field
from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.section import AtLeast, Number
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor
from crosstrack.airsim.scene.sensors.timing import Timing
from crosstrack.airsim.structs import MagnetometerData


class MagnetometerSettings(Enabled, Timing):
    """The magnetometer of settings.json."""

    sensor_type: Literal[4]
    noise_sigma: AtLeast = 0.005
    """gauss, of the noise of each axis"""
    scale_factor: Number = 1.0
    """what the field is multiplied by"""
    noise_bias: AtLeast = 0.0
    """gauss, each axis is off by at most that"""


class Magnetometer(Sensor):
    """Measure the field in the body."""

    def __init__(self, settings: MagnetometerSettings, random: np.random.Generator) -> None:
        super().__init__(settings, random)
        self.settings = settings
        self.bias = random.uniform(-1.0, 1.0, 3) * settings.noise_bias

    def blank(self) -> MagnetometerData:
        """Return zeros."""
        return MagnetometerData()

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> MagnetometerData:
        """Return the field at the vehicle."""
        state = moment.history.at(time)
        field = magnetic_field(*geodetic(state.position + moment.start, moment.origin))
        noise = self.settings.noise_sigma * self.random.standard_normal(3)
        body = matrix(state.orientation).T @ field * self.settings.scale_factor + noise + self.bias
        return MagnetometerData(time, body)
