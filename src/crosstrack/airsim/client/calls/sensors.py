"""Calls about sensors but cameras."""

from crosstrack.airsim.client.call import Call, query
from crosstrack.airsim.structs import (
    BarometerData,
    DistanceSensorData,
    GeoPoint,
    GpsData,
    ImuData,
    LidarData,
    MagnetometerData,
)


class Sensors:
    """Calls about sensors but cameras."""

    @query
    def get_lidar_data(self, lidar: str = "", vehicle: str = "") -> Call[LidarData]:
        """Return what a lidar saw last."""
        return Call("getLidarData", lidar, vehicle)

    @query
    def get_imu_data(self, imu: str = "", vehicle: str = "") -> Call[ImuData]:
        """Return what an inertial measurement unit measured last."""
        return Call("getImuData", imu, vehicle)

    @query
    def get_barometer_data(self, barometer: str = "", vehicle: str = "") -> Call[BarometerData]:
        """Return what a barometer measured last."""
        return Call("getBarometerData", barometer, vehicle)

    @query
    def get_magnetometer_data(self, magnetometer: str = "", vehicle: str = "") -> Call[MagnetometerData]:
        """Return what a magnetometer measured last."""
        return Call("getMagnetometerData", magnetometer, vehicle)

    @query
    def get_gps_data(self, gps: str = "", vehicle: str = "") -> Call[GpsData]:
        """Return what a satellite receiver said last."""
        return Call("getGpsData", gps, vehicle)

    @query
    def get_distance_sensor_data(self, sensor: str = "", vehicle: str = "") -> Call[DistanceSensorData]:
        """Return what a distance sensor measured last."""
        return Call("getDistanceSensorData", sensor, vehicle)

    @query
    def test_line_of_sight_to_point(self, point: GeoPoint, vehicle: str = "") -> Call[bool]:
        """Return whether nothing is between the vehicle and a point."""
        return Call("simTestLineOfSightToPoint", point, vehicle)

    @query
    def test_line_of_sight_between_points(self, first: GeoPoint, second: GeoPoint) -> Call[bool]:
        """Return whether nothing is between two points."""
        return Call("simTestLineOfSightBetweenPoints", first, second)
