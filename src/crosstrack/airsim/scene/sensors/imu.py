"""An inertial measurement unit with white noise and biases that walk."""

import math
from typing import Any, Literal

import numpy as np
from pydantic import Field

from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.section import Above, AtLeast
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor
from crosstrack.airsim.scene.sensors.timing import TICK, Timing
from crosstrack.airsim.structs import ImuData
from crosstrack.types import GRAVITY

WEIGHT = np.array([0.0, 0.0, GRAVITY])


class ImuSettings(Enabled):
    """The inertial measurement unit of settings.json."""

    sensor_type: Literal[2]
    angular_random_walk: AtLeast = 0.3
    """degrees/√h"""
    gyro_bias_stability_tau: Above = 500.0
    """s"""
    gyro_bias_stability: AtLeast = 4.6
    """degrees/h"""
    velocity_random_walk: AtLeast = 0.24
    """mg √s"""
    accel_bias_stability_tau: Above = Field(default=800.0)
    """s"""
    accel_bias_stability: AtLeast = 36.0
    """µg"""


class Imu(Sensor):
    """Measure rates and specific force at every tick.

    White noise of deviation w/√Δt over a tick Δt, and a bias that walks by b √(Δt/τ) a tick (Woodman, An introduction
    to inertial navigation, UCAM-CL-TR-696, section 3.2).
    """

    def __init__(self, settings: ImuSettings, random: np.random.Generator) -> None:
        super().__init__(Timing(update_frequency=1e9 / TICK), random)
        self.noise = np.array(
            [math.radians(settings.angular_random_walk) / 60.0, settings.velocity_random_walk * GRAVITY / 1e3]
        ) / math.sqrt(TICK * 1e-9)
        stability = np.array(
            [math.radians(settings.gyro_bias_stability) / 3600.0, settings.accel_bias_stability * 1e-6]
        )
        stability[1] *= GRAVITY
        tau = np.array([settings.gyro_bias_stability_tau, settings.accel_bias_stability_tau])
        self.walk = stability * np.sqrt(TICK * 1e-9 / tau)
        self.bias = np.zeros((2, 3))

    def restart(self) -> None:
        """Start anew, calibrated."""
        super().restart()
        self.bias = np.zeros((2, 3))

    def blank(self) -> Any:
        """Return zeros."""
        return ImuData()

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> ImuData:
        """Return what the vehicle feels."""
        state = moment.history.at(time)
        draws = self.random.standard_normal((2, 2, 3))
        noise = self.noise[:, None] * draws[0] + self.bias
        self.bias = self.bias + math.sqrt(steps) * self.walk[:, None] * draws[1]
        force = matrix(state.orientation).T @ (state.linear_acceleration - WEIGHT)
        return ImuData(time, state.orientation, state.angular_velocity + noise[0], force + noise[1])
