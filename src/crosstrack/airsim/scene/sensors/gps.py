"""A satellite receiver: exact, but late, and its dilution settles only after some time."""

import math
from typing import Literal

import numpy as np
from pydantic import Field

from crosstrack.airsim.scene.earth import geodetic
from crosstrack.airsim.scene.section import Above, AtLeast
from crosstrack.airsim.scene.sensors.sensor import Enabled, Moment, Sensor
from crosstrack.airsim.scene.sensors.timing import Timing
from crosstrack.airsim.structs import GeoPoint, GnssReport, GpsData

NO_FIX, FIX_2D, FIX_3D = 0, 2, 3


class GpsSettings(Enabled, Timing):
    """The satellite receiver of settings.json."""

    sensor_type: Literal[3]
    eph_time_constant: Above = Field(default=0.9, validation_alias="EPH_TimeConstant")
    """s, with which the horizontal dilution settles"""
    epv_time_constant: Above = Field(default=0.9, validation_alias="EPV_TimeConstant")
    """s, with which the vertical dilution settles"""
    eph_initial: AtLeast = 100.0
    epv_initial: AtLeast = 100.0
    eph_final: AtLeast = 0.1
    epv_final: AtLeast = 0.1
    eph_min3d: AtLeast = Field(default=3.0, validation_alias="EphMin3d")
    """at most which the fix is one in space"""
    eph_min2d: AtLeast = Field(default=4.0, validation_alias="EphMin2d")
    """at most which the fix is one in the plane"""
    update_latency: AtLeast = 0.2
    startup_delay: AtLeast = 1.0


class Gps(Sensor):
    """Report the true position and velocity of some time ago."""

    def __init__(self, settings: GpsSettings, random: np.random.Generator) -> None:
        super().__init__(settings, random)
        self.settings = settings

    def blank(self) -> GpsData:
        """Return no fix."""
        return GpsData()

    def dilution(self, age: float) -> tuple[float, float]:
        """Return the horizontal and the vertical dilution some time (s) after the restart."""
        s = self.settings
        eph = s.eph_final + (s.eph_initial - s.eph_final) * math.exp(-age / s.eph_time_constant)
        return eph, s.epv_final + (s.epv_initial - s.epv_final) * math.exp(-age / s.epv_time_constant)

    def sample(self, moment: Moment, time: int, count: int, steps: int) -> GpsData:
        """Return the fix of a time."""
        state = moment.history.at(time)
        point = GeoPoint(*geodetic(state.position + moment.start, moment.origin))
        eph, epv = self.dilution(self.sampling.when(count) * 1e-9)
        fix = FIX_3D if eph <= self.settings.eph_min3d else FIX_2D if eph <= self.settings.eph_min2d else NO_FIX
        return GpsData(time, GnssReport(point, eph, epv, state.linear_velocity, fix, time // 1000), is_valid=True)
