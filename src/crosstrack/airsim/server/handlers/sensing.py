"""Calls that read sensors, and lines of sight."""

from typing import Any

import numpy as np

from crosstrack.airsim.scene.earth import local
from crosstrack.airsim.scene.sensors.suite import KINDS
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.aboard import equipment, eye_of
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import GeoPoint
from crosstrack.types import Array

BAROMETER, IMU, GPS, MAGNETOMETER, DISTANCE, LIDAR = range(1, 7)
HIGHEST = 1e6
"""m, altitude"""
SHORT = 1e-6
"""m, a line that nothing can be in the way of"""


def read(simulator: Simulator, kind: int, name: str, vehicle_name: str) -> Any:
    """Return what a sensor shows.

    Raises:
        Refused: the vehicle has none of that kind and name.
    """
    aboard = equipment(simulator).aboard(simulator.vehicle(vehicle_name))
    sensor = aboard.suite.named(name, kind)
    if sensor is None:
        raise Refused(f"No {KINDS[kind].words} with name {name} exist on vehicle")
    return sensor.read(aboard.moment())


def barometer(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what a barometer shows."""
    return read(simulator, BAROMETER, name, vehicle_name)


def imu(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what an inertial measurement unit shows."""
    return read(simulator, IMU, name, vehicle_name)


def gps(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what a satellite receiver shows."""
    return read(simulator, GPS, name, vehicle_name)


def magnetometer(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what a magnetometer shows."""
    return read(simulator, MAGNETOMETER, name, vehicle_name)


def distance(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what a distance sensor shows."""
    return read(simulator, DISTANCE, name, vehicle_name)


def lidar(simulator: Simulator, name: str, vehicle_name: str) -> Any:
    """Return what a lidar shows."""
    return read(simulator, LIDAR, name, vehicle_name)


def free(simulator: Simulator, start: Array, end: Array, vehicle: Any = None) -> bool:
    """Return whether nothing is between two points (3,) m, NED."""
    way = end - start
    far = float(np.linalg.norm(way))
    if not np.isfinite(far):
        raise Refused("the vehicle is nowhere")
    if far < SHORT:
        return True
    ranges, _ = eye_of(simulator, vehicle).cast(start, way[None] / far, far)
    return bool(ranges[0] >= far)


def in_sight(simulator: Simulator, point: GeoPoint, vehicle_name: str) -> bool:
    """Return whether a point of the Earth can be seen from a vehicle."""
    vehicle = simulator.pawn(vehicle_name)
    return free(simulator, vehicle.pose().position, place(simulator, point), vehicle)


def clear_between(simulator: Simulator, one: GeoPoint, two: GeoPoint) -> bool:
    """Return whether nothing is between two points of the Earth."""
    return free(simulator, place(simulator, one), place(simulator, two))


def place(simulator: Simulator, point: GeoPoint) -> Array:
    """Return where a point of the Earth is, (3,) m, NED.

    Raises:
        Refused: it is not finite, or no such latitude.
    """
    if not (abs(point.latitude) <= 90 and abs(point.longitude) <= 360 and abs(point.altitude) < HIGHEST):
        raise Refused(f"latitude {point.latitude}, longitude {point.longitude}, altitude {point.altitude} is nowhere")
    return local(point.latitude, point.longitude, point.altitude, simulator.origin)


HANDLERS = {
    "getBarometerData": barometer,
    "getImuData": imu,
    "getGpsData": gps,
    "getMagnetometerData": magnetometer,
    "getDistanceSensorData": distance,
    "getLidarData": lidar,
    "simTestLineOfSightToPoint": in_sight,
    "simTestLineOfSightBetweenPoints": clear_between,
}
