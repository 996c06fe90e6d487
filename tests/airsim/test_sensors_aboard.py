"""Sensors aboard: noise as it is said to be, samples when AirSim takes them, rays that hit what is there."""

import math
from collections import deque
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenery import at, call, put, simulated, vector

from crosstrack import frames
from crosstrack.airsim.firmware.air import pressure
from crosstrack.airsim.scene.earth import RADIUS, geodetic, local, magnetic_field
from crosstrack.airsim.scene.poses import angles, from_angles, matrix, onto, seen_from
from crosstrack.airsim.scene.sensors.imu import Imu, ImuSettings
from crosstrack.airsim.scene.sensors.lidar import Lidar, LidarSettings
from crosstrack.airsim.scene.sensors.timing import TICK, Sampling, Timing
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import KinematicsState, Pose
from crosstrack.frames import Origin
from crosstrack.types import Array
from crosstrack.world.shapes import Box, Cylinder, Sphere

VEHICLE = '{"Vehicles": {"V": {"VehicleType": "SimpleFlight", %s}}}'


def with_sensors(sensors: str) -> str:
    """Return settings of a vehicle with sensors."""
    return VEHICLE % f'"Sensors": {{{sensors}}}'


def series(simulator: Simulator, name: str, count: int, every: float = 0.03) -> list[Any]:
    """Return what a sensor shows again and again."""
    found = []
    for _ in range(count):
        simulator.idle(every)
        found.append(call(simulator, name, "", ""))
    return found


class Reference:
    """AirSim's interval and delay line, tick by tick."""

    def __init__(self, frequency: float, latency: float, startup: float) -> None:
        self.interval = float(np.float32(1.0) / np.float32(frequency))
        self.latency, self.startup = latency, startup
        self.line: deque[tuple[int, int]] = deque([(0, 0)])
        self.last = self.value = self.shown = 0
        self.samples, self.begun, self.any = 0, startup <= 0.0, False

    def tick(self, now: int) -> int | None:
        """Return which sample is shown after a tick at a time (ns)."""
        elapsed = (now - self.last) * 1e-9
        over = elapsed + 1e-12 >= (self.interval if self.begun else self.startup)
        if over:
            self.last, self.begun = now, True
            self.samples += 1
            self.line.append((now, self.samples))
        if self.line and (now - self.line[0][0]) * 1e-9 + 1e-12 >= self.latency:
            self.value = self.line.popleft()[1]
        if over:
            self.shown, self.any = self.value, True
        return self.shown if self.any else None


@pytest.mark.parametrize(
    ("frequency", "latency", "startup"), [(50, 0.2, 1.0), (50, 0, 0), (10, 0.3, 0.5), (100, 0.05, 0)]
)
def test_samples_come_when_airsim_takes_them(frequency: float, latency: float, startup: float) -> None:
    sampling = Sampling(Timing(update_frequency=frequency, update_latency=latency, startup_delay=startup))
    reference = Reference(frequency, latency, startup)
    for k in range(1, 1500):
        expected = reference.tick(k * TICK)
        if expected is None and latency == 0:
            continue  # before the first sample AirSim shows zeros, and this what there was at the start
        assert sampling.shown(k * TICK) == expected, k


def test_a_unit_at_rest_feels_its_weight() -> None:
    simulator = simulated()
    data = call(simulator, "getImuData", "", "")
    np.testing.assert_allclose(data.linear_acceleration, [0, 0, -9.80665], atol=0.3)
    simulator = simulated()
    put(simulator, at(0, 0, -50, pitch=30))
    simulator.vehicle("").quadrotor.acceleration[:] = 0
    data = call(simulator, "getImuData", "imu", "")
    nose = -9.80665 * np.array([-math.sin(math.radians(30)), 0, math.cos(math.radians(30))])
    np.testing.assert_allclose(data.linear_acceleration, nose, atol=0.3)
    np.testing.assert_array_equal(data.orientation, from_angles(0, 30, 0))


def test_noise_of_an_inertial_unit() -> None:
    """Deviations of white noise and of the walk of the biases, against the settings."""
    unit = Imu(ImuSettings(sensor_type=2), np.random.default_rng(5))
    steps, state = 15_000, KinematicsState()
    history = type("Still", (), {"at": lambda self, time: state})()
    moment = type("Moment", (), {"history": history})()
    rates = np.array([unit.sample(moment, k, k, 1).angular_velocity for k in range(steps)])
    walk = math.radians(0.3) / 60 / math.sqrt(0.003)
    assert rates.std() == pytest.approx(walk, rel=0.03)
    ends = []
    for seed in range(300):
        unit = Imu(ImuSettings(sensor_type=2, gyro_bias_stability=1000.0), np.random.default_rng(seed))
        unit.sample(moment, 0, 1, 10_000)
        ends.append(unit.bias[0])
    expected = math.radians(1000) / 3600 * math.sqrt(10_000 * 0.003 / 500)
    assert np.std(ends) == pytest.approx(expected, rel=0.1)


def test_a_barometer() -> None:
    simulator = simulated()
    put(simulator, at(0, 0, -30))
    simulator.idle(0.1)
    truth = call(simulator, "simGetGroundTruthEnvironment", "")
    data = call(simulator, "getBarometerData", "barometer", "")
    assert data.pressure == pytest.approx(truth.air_pressure, abs=15)
    assert data.qnh == pytest.approx(1013.25)
    height = 44330.77 * (1 - (data.pressure / 101325) ** (1 / 5.25588))  # ICAO Doc 7488
    assert data.altitude == pytest.approx(height, abs=0.2)
    simulator = simulated(settings=with_sensors('"b": {"SensorType": 1, "Enabled": true, "PressureFactorSigma": 0}'))
    shown = series(simulator, "getBarometerData", 3000, 0.021)
    noise = np.array([one.pressure for one in shown]) - pressure(122.0)
    assert noise.std() == pytest.approx(2.7, rel=0.05)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.06
    assert len({one.time_stamp for one in shown}) == 3000


def test_drift_of_a_barometer_taken_at_once_is_that_of_many_steps() -> None:
    """x ← α x + (1 - α) σ n: after many steps its variance is that of the stationary process."""
    text = '"b": {"SensorType": 1, "Enabled": true, "UncorrelatedNoiseSigma": 0, "PressureFactorTau": 0.1, %s}'
    simulator = simulated(settings=with_sensors(text % '"PressureFactorSigma": 0.01'))
    keep, base = math.exp(-0.021 / 0.1), pressure(122.0)
    for every in (0.021, 0.105):
        drift = np.array([one.pressure / base - 1 for one in series(simulator, "getBarometerData", 2000, every)])
        assert drift.std() == pytest.approx(0.01 * math.sqrt((1 - keep) / (1 + keep)), rel=0.08)
        expected = keep ** (every / 0.021)
        assert np.corrcoef(drift[1:], drift[:-1])[0, 1] == pytest.approx(expected, abs=0.07)


def test_a_satellite_receiver_settles() -> None:
    simulator = simulated()
    simulator.idle(0.9)
    assert not call(simulator, "getGpsData", "", "").is_valid
    shown = series(simulator, "getGpsData", 150)
    first = next(one for one in shown if one.is_valid)
    assert first.gnss.eph == pytest.approx(100)
    fixes = [one.gnss.fix_type for one in shown if one.is_valid]
    assert sorted(set(fixes)) == [0, 2, 3]
    assert fixes == sorted(fixes)
    for one in shown:
        if one.is_valid:
            age = one.time_stamp * 1e-9
            assert one.gnss.eph == pytest.approx(0.1 + 99.9 * math.exp(-age / 0.9), rel=1e-9)
            assert (one.gnss.fix_type == 3) == (one.gnss.eph <= 3)


def test_a_satellite_receiver_is_late() -> None:
    simulator = simulated(settings=with_sensors('"g": {"SensorType": 3, "Enabled": true, "StartupDelay": 0}'))
    truth: dict[int, Array] = {}
    simulator.observers.append(lambda: truth.update({simulator.now: simulator.vehicle("").pose().position}))
    put(simulator, at(0, 0, -100))
    simulator.vehicle("").quadrotor.velocity[:] = 5, 0, 0
    for _ in range(60):
        simulator.idle(0.021)
    data = call(simulator, "getGpsData", "", "")
    late = (simulator.now - data.time_stamp) * 1e-9
    assert 0.2 <= late <= 0.25
    place = local(data.gnss.geo_point.latitude, data.gnss.geo_point.longitude, data.gnss.geo_point.altitude, Origin())
    np.testing.assert_allclose(place, truth[data.time_stamp], atol=0.03)
    assert np.linalg.norm(simulator.vehicle("").pose().position - truth[data.time_stamp]) > 0.5


def test_a_reset_starts_sensors_anew() -> None:
    simulator = simulated()
    simulator.idle(4.0)
    assert call(simulator, "getGpsData", "", "").gnss.fix_type == 3
    simulator.reset()
    simulator.idle(0.5)
    assert not call(simulator, "getGpsData", "", "").is_valid
    simulator.idle(3.6)
    assert call(simulator, "getGpsData", "", "").gnss.fix_type == 3


def test_the_dipole() -> None:
    """What AirSim says its model gives at two places, in tesla."""
    np.testing.assert_allclose(
        magnetic_field(47.637, -122.147, 622.0) * 1e-4, [2.50394e-05, 3.40771e-06, 3.6567e-05], rtol=2e-4
    )
    np.testing.assert_allclose(
        magnetic_field(47.646, -122.134, -378.0) * 1e-4, [2.5047e-05, 3.41024e-06, 3.65953e-05], rtol=2e-4
    )


def test_a_magnetometer_turns_with_its_vehicle() -> None:
    simulator = simulated(settings=with_sensors('"m": {"SensorType": 4, "Enabled": true, "NoiseSigma": 0}'))
    put(simulator, at(0, 0, 0, yaw=90))
    simulator.vehicle("").quadrotor["grounded"] = True
    north, east, down = magnetic_field(47.641468, -122.140165, 122.0)
    data = call(simulator, "getMagnetometerData", "m", "")
    np.testing.assert_allclose(data.magnetic_field_body, [east, -north, down], rtol=1e-9)


def test_a_distance_sensor() -> None:
    text = '"d": {"SensorType": 5, "Enabled": true, "UncorrelatedNoiseSigma": 0, "Pitch": -90, "Z": 0.5}, %s'
    ahead = '"e": {"SensorType": 5, "Enabled": true, "UncorrelatedNoiseSigma": 0, "Yaw": 30, "MaxDistance": 25}'
    simulator = simulated(Box((-50, 20, 0), (50, 21, 30)), settings=with_sensors(text % ahead))
    put(simulator, at(0, 0, -10))
    assert call(simulator, "getDistanceSensorData", "d", "").distance == pytest.approx(9.5)
    data = call(simulator, "getDistanceSensorData", "e", "")
    assert data.distance == pytest.approx(20 / math.cos(math.radians(30)))
    assert (data.min_distance, data.max_distance) == (0.2, 25)
    assert call(simulator, "getDistanceSensorData", "", "").distance == pytest.approx(9.5)
    put(simulator, at(0, 0, -10, yaw=180))
    simulator.idle(0.021)
    assert call(simulator, "getDistanceSensorData", "e", "").distance == 25


LIDAR = '"l": {"SensorType": 6, "Enabled": true, "X": 0.3, "Z": -0.2, "Pitch": 10, "VerticalFOVUpper": 10, %s}'


@pytest.mark.parametrize("yaw", [0.0, 130.0])
def test_lidar_points_lie_on_surfaces_in_both_frames(yaw: float) -> None:
    shapes = Box((-5, 8, 0), (5, 9, 6)), Cylinder((8, 0), 1.0, (0, 9)), Sphere((-6, -6, 3), 2.0)
    clouds = {}
    for frame in ("SensorLocalFrame", "VehicleInertialFrame"):
        sensors = LIDAR % f'"DataFrame": "{frame}"'
        simulator = simulated(*shapes, settings=VEHICLE % f'"X": 3, "Y": -2, "Sensors": {{{sensors}}}')
        put(simulator, at(0, 0, -4, yaw=yaw, pitch=5))
        simulator.vehicle("").quadrotor["grounded"] = True
        simulator.idle(0.105)
        simulator.vehicle("").place(Pose(vector(-3, 2, -4), from_angles(yaw, 5, 0)))
        simulator.idle(0.105)
        clouds[frame] = call(simulator, "getLidarData", "l", "")
    inertial = clouds["VehicleInertialFrame"]
    points = inertial.point_cloud.reshape(-1, 3).astype(float)
    assert len(points) > 1000
    world = simulator.scene.world
    places = frames.enu_from_ned(points + vector(3, -2, 0))
    off = np.minimum(np.abs(world.distance(places)), np.abs(places[:, 2]))
    assert off.max() < 1e-4
    own = clouds["SensorLocalFrame"]
    turned = own.point_cloud.reshape(-1, 3) @ matrix(own.pose.orientation).T + own.pose.position
    np.testing.assert_allclose(turned, points, atol=1e-4)
    assert len(inertial.segmentation) == len(points)
    ball = call(simulator, "simGetSegmentationObjectID", "sphere_1")
    on_ball = inertial.segmentation == ball
    assert on_ball.any()
    np.testing.assert_allclose(np.linalg.norm(places[on_ball] - [-6, -6, 3], axis=1), 2, atol=1e-4)


def test_a_lidar_turns_on_from_update_to_update() -> None:
    made = LidarSettings(sensor_type=6, points_per_second=32_000, rotations_per_second=7, horizontal_fov_end=360 - 1e-9)
    lidar = Lidar(made, np.random.default_rng(1))
    spacing = []
    for k in range(1, 6):
        bearings = np.concatenate([lidar.columns(k), lidar.columns(k + 1)])
        spacing.append(np.diff(bearings) % 360)
        assert len(lidar.columns(k)) == 204  # 32 000 a second, for 0.102 s, by 16 lasers
    np.testing.assert_allclose(np.concatenate(spacing), 7 * 360 * 0.102 / 204, rtol=1e-6)


@pytest.mark.parametrize(("first", "last"), [(-30.0, 60.0), (90.0, 270.0), (200.0, 20.0)])
def test_a_lidar_keeps_to_its_field_of_view(first: float, last: float) -> None:
    made = LidarSettings(sensor_type=6, horizontal_fov_start=first, horizontal_fov_end=last, number_of_channels=8)
    beams = Lidar(made, np.random.default_rng(1)).beams(3)
    bearing = np.degrees(np.arctan2(beams[:, 1], beams[:, 0]))
    assert ((bearing - first) % 360 <= (last - first) % 360 + 1e-9).all()
    up = np.degrees(np.arcsin(-beams[:, 2]))
    np.testing.assert_allclose(np.unique(up.round(6)), np.linspace(-45, -15, 8), atol=1e-6)


def test_nothing_is_in_reach_of_a_lidar_that_looks_up() -> None:
    simulator = simulated(settings=with_sensors(LIDAR % '"VerticalFOVLower": 5, "Range": 20'))
    put(simulator, at(0, 0, -4, pitch=-10))
    simulator.idle(0.11)
    assert call(simulator, "getLidarData", "", "").point_cloud.shape == (0,)


def test_what_is_not_aboard_is_refused() -> None:
    simulator = simulated(settings=with_sensors('"off": {"SensorType": 6}'))
    with pytest.raises(Refused, match="No lidar with name off exist on vehicle"):
        call(simulator, "getLidarData", "off", "")
    with pytest.raises(Refused, match="No IMU with name gps exist"):
        call(simulator, "getImuData", "gps", "")
    with pytest.raises(Refused, match="Vehicle API for 'x'"):
        call(simulator, "getImuData", "", "x")


def test_noise_comes_from_the_seed() -> None:
    def shown(seed: int) -> list[float]:
        simulator = simulated(seed=seed)
        values: list[float] = call(simulator, "getImuData", "", "").angular_velocity.tolist()
        return values + [one.pressure for one in series(simulator, "getBarometerData", 5)]

    assert shown(3) == shown(3)
    assert shown(3) != shown(4)


def test_a_sample_stays_until_the_next() -> None:
    simulator = simulated()
    simulator.idle(0.1)
    one, two = (call(simulator, "getBarometerData", "", "") for _ in range(2))
    assert (one.pressure, one.time_stamp) == (two.pressure, two.time_stamp)


@settings(max_examples=50, deadline=None)
@given(st.floats(-170, 170), st.floats(-60, 60), st.floats(0.1, 5e4), st.floats(-180, 180))
def test_great_circles(longitude: float, latitude: float, far: float, bearing: float) -> None:
    """Haversine formula for the distance, and the first bearing along the great circle."""
    origin = Origin(latitude, longitude, 10.0)
    angle = math.radians(bearing)
    lat, lon, height = geodetic(vector(far * math.cos(angle), far * math.sin(angle), -5), origin)
    a, b, d = math.radians(latitude), math.radians(lat), math.radians(lon - longitude)
    half = math.sin((b - a) / 2) ** 2 + math.cos(a) * math.cos(b) * math.sin(d / 2) ** 2
    assert 2 * RADIUS * math.asin(math.sqrt(half)) == pytest.approx(far, rel=1e-5, abs=1e-3)
    toward = math.atan2(math.sin(d) * math.cos(b), math.cos(a) * math.sin(b) - math.sin(a) * math.cos(b) * math.cos(d))
    assert math.cos(toward - angle) == pytest.approx(1, abs=1e-6)
    assert height == pytest.approx(15)


@settings(max_examples=50, deadline=None)
@given(st.floats(-179, 179), st.floats(-85, 85), st.floats(-179, 179))
def test_angles_and_poses_undo_each_other(yaw: float, pitch: float, roll: float) -> None:
    assert angles(from_angles(yaw, pitch, roll)) == pytest.approx((yaw, pitch, roll), abs=1e-6)
    one, two = at(1, 2, 3, yaw, pitch, roll), at(-4, 5, 6, roll, pitch, yaw)
    back = seen_from(one, onto(one, two))
    np.testing.assert_allclose(back.position, two.position, atol=1e-9)
    np.testing.assert_allclose(matrix(back.orientation), matrix(two.orientation), atol=1e-9)
