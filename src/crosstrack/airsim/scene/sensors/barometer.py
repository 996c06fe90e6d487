"""A barometer with white noise and a pressure that drifts with the weather."""

import math
from typing import Literal

import numpy as np

from crosstrack.airsim.firmware.air import SEA_LEVEL_PRESSURE, pressure
from crosstrack.airsim.scene.earth import geodetic
from crosstrack.airsim.scene.section import Above, AtLeast
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor
from crosstrack.airsim.scene.sensors.timing import Timing
from crosstrack.airsim.structs import BarometerData


class BarometerSettings(Enabled, Timing):
    """The barometer of settings.json."""

    sensor_type: Literal[1]
    pressure_factor_sigma: AtLeast = 0.0365 / 20
    """of the drift, a share of the pressure"""
    pressure_factor_tau: Above = 3600.0
    """s, of the drift"""
    uncorrelated_noise_sigma: AtLeast = 2.7
    """Pa, of the noise"""


class Barometer(Sensor):
    """Measure the pressure p, and the altitude 44307.7 m · (1 - (p/p₀)^0.190284) that the standard atmosphere gives it.

    The drift is a Gauss-Markov process, x ← α x + (1 - α) σ n, α = exp(-Δt/τ), with n of variance one, taken over all
    samples since the last one shown at once.
    """

    def __init__(self, settings: BarometerSettings, random: np.random.Generator) -> None:
        super().__init__(settings, random)
        self.settings = settings
        self.drift = 0.0

    def restart(self) -> None:
        """Start anew, without drift."""
        super().restart()
        self.drift = 0.0

    def blank(self) -> BarometerData:
        """Return zeros."""
        return BarometerData()

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> BarometerData:
        """Return the pressure at the vehicle."""
        altitude = geodetic(moment.history.at(time).position + moment.start, moment.origin)[2]
        settings = self.settings
        keep = math.exp(-self.sampling.period * 1e-9 / settings.pressure_factor_tau)
        spread = settings.pressure_factor_sigma * math.sqrt((1 - keep) / (1 + keep) * (1 - keep ** (2 * steps)))
        drift, noise = self.random.standard_normal(2)
        self.drift = keep**steps * self.drift + spread * drift
        measured = pressure(altitude) * (1 + self.drift) + settings.uncorrelated_noise_sigma * noise
        height = (1 - (measured / SEA_LEVEL_PRESSURE) ** 0.190284) * 145366.45 * 0.3048
        return BarometerData(time, height, measured, SEA_LEVEL_PRESSURE / 100)
