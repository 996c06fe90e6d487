"""The sensors of one vehicle."""

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from crosstrack.airsim.scene.sensors.barometer import Barometer, BarometerSettings
from crosstrack.airsim.scene.sensors.distance import Distance, DistanceSettings
from crosstrack.airsim.scene.sensors.gps import Gps, GpsSettings
from crosstrack.airsim.scene.sensors.history import History
from crosstrack.airsim.scene.sensors.imu import Imu, ImuSettings
from crosstrack.airsim.scene.sensors.lidar import Lidar, LidarSettings
from crosstrack.airsim.scene.sensors.magnetometer import Magnetometer, MagnetometerSettings
from crosstrack.airsim.scene.sensors.sensor import Moment, Sensor, Sight
from crosstrack.airsim.structs import KinematicsState
from crosstrack.frames import Origin
from crosstrack.types import Array

SensorSettings = Annotated[
    BarometerSettings | ImuSettings | GpsSettings | MagnetometerSettings | DistanceSettings | LidarSettings,
    Field(discriminator="sensor_type"),
]


class Kind(NamedTuple):
    """A kind of sensor."""

    words: str
    """how AirSim calls it where there is none"""
    make: Any
    """from its settings and a generator"""


KINDS = {
    1: Kind("barometer", Barometer),
    2: Kind("IMU", Imu),
    3: Kind("gps", Gps),
    4: Kind("magnetometer", Magnetometer),
    5: Kind("distance sensor", Distance),
    6: Kind("lidar", Lidar),
}
"""by their number in settings.json"""


def usual() -> dict[str, SensorSettings]:
    """Return the sensors of a multirotor for which settings.json says nothing."""
    return {
        "barometer": BarometerSettings(sensor_type=1, enabled=True),
        "gps": GpsSettings(sensor_type=3, enabled=True),
        "imu": ImuSettings(sensor_type=2, enabled=True),
        "magnetometer": MagnetometerSettings(sensor_type=4, enabled=True),
    }


class Suite:
    """The sensors of a vehicle, and what they remember."""

    def __init__(self, settings: Mapping[str, SensorSettings], random: np.random.Generator) -> None:
        self.kinds = {name: one.sensor_type for name, one in sorted(settings.items()) if one.enabled}
        generators = random.spawn(len(self.kinds))
        self.sensors: dict[str, Sensor] = {
            name: KINDS[kind].make(settings[name], generator)
            for (name, kind), generator in zip(self.kinds.items(), generators, strict=True)
        }
        self.history = History()
        self.began: int | None = None

    def restart(self) -> None:
        """Start all sensors anew at the next instant that is observed."""
        self.began = None
        self.history.clear()
        for sensor in self.sensors.values():
            sensor.restart()

    def observe(self, now: int, state: KinematicsState) -> None:
        """Take in the true state at a time (ns), relative to the start of the vehicle."""
        self.began = now if self.began is None else self.began
        self.history.add(now, state)

    def named(self, name: str, kind: int) -> Sensor | None:
        """Return the sensor of a name and a kind, the first of the kind for no name; None where there is none."""
        found = (one for one in self.sensors if self.kinds[one] == kind and name in ("", one))
        first = next(found, None)
        return None if first is None else self.sensors[first]

    def moment(self, start: Array, origin: Origin, sight: Sight) -> Moment:
        """Return what the sensors know at the instant that was observed last."""
        now = self.history.times[-1]
        return Moment(now, now - (now if self.began is None else self.began), self.history, start, origin, sight)
