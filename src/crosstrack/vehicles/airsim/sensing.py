"""What AirSim's sensors see, as scans of the sensors that a mission names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from crosstrack.airsim.structs import ImageRequest
from crosstrack.errors import InputError, Problem
from crosstrack.frames import attitude_enu_from_ned, enu_from_ned, flu_from_frd
from crosstrack.protocols import Sensor
from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.distance_ring import DistanceRing
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.pose import axes
from crosstrack.types import Array, Scan, State
from crosstrack.vehicles.airsim.link import Link
from crosstrack.vehicles.airsim.settings import (
    CAMERA,
    DEPTH_PLANAR,
    DISTANCE,
    LIDAR,
    RING,
    depth_kind,
    differences,
    sensors_of,
)

NANO = 1e-9


@dataclass
class Seen:
    """What a sensor of AirSim measured at one instant."""

    stamp: int
    """ns"""
    place: Array
    """(3,) m, world, of the sensor"""
    ranges: Array
    """(rays,) m, along the beams of the mission's sensor; inf where nothing was hit"""


class Feed(Protocol):
    """A sensor of AirSim that stands for one of the mission."""

    @property
    def sensor(self) -> Any:
        """That of the mission."""

    def look(self, link: Link) -> Seen:
        """Ask AirSim what it measured last."""


@dataclass(frozen=True)
class LidarFeed:
    """A lidar of AirSim, whose points fall into the beams of the mission's."""

    sensor: Lidar
    name: str
    local: bool
    """whether its points are in its own frame; else in the inertial frame of the vehicle"""

    def look(self, link: Link) -> Seen:
        """Return the last rotation."""
        data = link.client.get_lidar_data(self.name, link.name)
        place = enu_from_ned(data.pose.position) + link.home
        points = np.asarray(data.point_cloud[: len(data.point_cloud) // 3 * 3], dtype=float).reshape(-1, 3)
        if self.local:
            points = flu_from_frd(points)
        else:
            points = (enu_from_ned(points) + link.home - place) @ axes(attitude_enu_from_ned(data.pose.orientation))
        return Seen(data.time_stamp, place, binned(points, self.sensor))


def binned(points: Array, lidar: Lidar) -> Array:
    """Return the least range (rays,) m of points (n, 3) m, in a lidar's axes, in each of its beams; inf without any."""
    ranges = np.full(lidar.rings * lidar.columns, np.inf)
    far = np.linalg.norm(points, axis=1)
    points, far = points[(far > 0) & (far <= lidar.range)], far[(far > 0) & (far <= lidar.range)]
    rise = np.degrees(np.arcsin(points[:, 2] / far)) - lidar.lowest_deg
    spacing = (lidar.highest_deg - lidar.lowest_deg) / max(1, lidar.rings - 1) or 1.0
    ring = np.round(rise / spacing).astype(int)
    turn = np.degrees(np.arctan2(points[:, 1], points[:, 0])) / lidar.fov_deg + 0.5
    column = np.floor(turn * lidar.columns).astype(int)
    if lidar.fov_deg >= 360.0:
        column %= lidar.columns
    inside = (ring >= 0) & (ring < lidar.rings) & (column >= 0) & (column < lidar.columns)
    np.minimum.at(ranges, ring[inside] * lidar.columns + column[inside], far[inside])
    return ranges


@dataclass(frozen=True)
class CameraFeed:
    """A camera of AirSim, asked for distances: along its rays, or along its axis."""

    sensor: DepthCamera
    name: str
    kind: int
    """of the image, DEPTH_PERSPECTIVE or DEPTH_PLANAR"""

    def look(self, link: Link) -> Seen:
        """Return the picture of the moment.

        Raises:
            InputError: it is not of the size that the mission says.
        """
        (image,) = link.client.get_images([ImageRequest(self.name, self.kind, True, False)], link.name)
        if (image.width, image.height) != (self.sensor.width, self.sensor.height):
            found = f"pictures are {image.width} x {image.height}"
            wanted = f"the mission's sensor has {self.sensor.width} x {self.sensor.height} pixels"
            raise InputError("AirSim's settings.json", [Problem(f"Cameras.{self.name}", f"{found}; {wanted}")])
        far = np.asarray(image.image_data_float, dtype=float)
        if self.kind == DEPTH_PLANAR:
            far = far / self.sensor.beams()[:, 0]
        place = enu_from_ned(image.camera_position) + link.home
        return Seen(image.time_stamp, place, np.where(far <= self.sensor.range, far, np.inf))


@dataclass(frozen=True)
class RingFeed:
    """Distance sensors of AirSim, one for each beam of the mission's."""

    sensor: DistanceRing
    names: tuple[str, ...]

    def look(self, link: Link) -> Seen:
        """Return the last measurements."""
        found = [link.client.get_distance_sensor_data(name, link.name) for name in self.names]
        far = np.maximum([data.distance for data in found], 0.0)  # its noise is of both signs
        _, state = link.state()
        place = state.position + axes(state.attitude) @ np.array(self.sensor.position)
        return Seen(max(data.time_stamp for data in found), place, np.where(far <= self.sensor.range, far, np.inf))


@dataclass
class Sensing:
    """The sensors of one flight: each is asked when it is due.

    Args:
        link: to the vehicle
        sensors: of the mission

    Raises:
        InputError: AirSim's settings do not give the vehicle these sensors.
    """

    link: Link
    sensors: Sequence[Sensor]
    feeds: list[Feed] = field(init=False)
    last: list[int] = field(init=False)
    """ns, when each measured last what was seen"""

    def __post_init__(self) -> None:
        self.feeds = feeds_for(self.sensors, self.link.settings)
        self.last = [0 for _ in self.feeds]

    def scans(self, state: State, stamp: int) -> list[Scan]:
        """Return what is new.

        A sensor may have measured a command ago. Where it was then is known, and the origin of its scan is that place
        as the vehicle has it now.

        Args:
            state: of the vehicle now, true
            stamp: ns, AirSim's time now
        """
        found = []
        for k, feed in enumerate(self.feeds):
            if NANO * (stamp - self.last[k]) * feed.sensor.rate < 1.0 - NANO:
                continue
            seen = feed.look(self.link)
            if seen.stamp <= self.last[k]:
                continue
            self.last[k] = seen.stamp
            origin = (seen.place - state.position) @ axes(state.attitude)
            time, sensor = state.time - NANO * (stamp - seen.stamp), feed.sensor
            found.append(Scan(time, origin, sensor.directions, seen.ranges, sensor.range, sensor.rows))
        return found


def feeds_for(sensors: Sequence[Sensor], settings: Mapping[str, Any]) -> list[Feed]:
    """Return what stands for the sensors of a mission in a vehicle of AirSim's settings.

    Raises:
        InputError: something does not, with what to write into settings.json.
    """
    wanted, problems = sensors_of(sensors), differences(sensors, settings)
    if problems:
        raise InputError("AirSim's settings.json", problems)
    given = settings.get("Sensors", {})
    feeds: list[Feed] = []
    for k, sensor in enumerate(sensors):
        if isinstance(sensor, Lidar):
            name = f"{LIDAR}{k}"
            feeds.append(LidarFeed(sensor, name, given[name].get("DataFrame") == "SensorLocalFrame"))
        elif isinstance(sensor, DepthCamera):
            name = f"{CAMERA}{k}"
            kind = depth_kind(sensor, settings["Cameras"][name])
            assert kind is not None  # there are no differences
            feeds.append(CameraFeed(sensor, name, kind))
        elif isinstance(sensor, DistanceRing):
            names = tuple(name for name in wanted["Sensors"] if name.startswith(f"{RING}{k}{DISTANCE}"))
            feeds.append(RingFeed(sensor, names))
    return feeds
