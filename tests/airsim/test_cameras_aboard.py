"""Cameras: where they are, how they project, and what is told of their lenses."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenery import at, call, put, simulated, vector

from crosstrack.airsim.scene.images import Shot
from crosstrack.airsim.scene.poses import from_angles, matrix, seen_from
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import Pose

MISSION = """{"Vehicles": {"V": {"VehicleType": "SimpleFlight", "X": 10, "Y": 5, "Z": -2,
    "Cameras": {"tall": {"X": 1, "Yaw": 90, "CaptureSettings": [{"Width": 100, "Height": 200, "FOV_Degrees": 60}]}}}},
    "ExternalCameras": {"tower": {"X": -5, "Y": 3, "Z": -20, "Pitch": -90}}}"""


@cache
def shared() -> Simulator:
    """Return one simulator for many examples."""
    return simulated(settings=MISSION)


def test_usual_cameras() -> None:
    simulator = simulated()
    for name, number, ahead in (
        ("front_center", "0", (1, 0, 0)),
        ("front_right", "1", (1, 0, 0)),
        ("front_left", "2", (1, 0, 0)),
        ("bottom_center", "3", (0, 0, 1)),
        ("back_center", "4", (-1, 0, 0)),
        ("fpv", "", (1, 0, 0)),
    ):
        one, two = (call(simulator, "simGetCameraInfo", key, "", False) for key in (name, number))
        np.testing.assert_array_equal(one.pose.position, two.pose.position)
        np.testing.assert_allclose(matrix(one.pose.orientation) @ [1, 0, 0], ahead, atol=1e-12)
    left, right = (call(simulator, "simGetCameraInfo", key, "", False).pose.position for key in "21")
    np.testing.assert_allclose(right - left, [0, 0.25, 0])


def test_the_projection_of_airsim() -> None:
    """What AirSim prints for its usual camera."""
    info = call(simulated(), "simGetCameraInfo", "0", "", False)
    expected = np.array([[0, 1, 0, 0], [0, 0, -16 / 9, 0], [0, 0, 0, 10], [-1, 0, 0, 0]])
    np.testing.assert_allclose(info.proj_mat.matrix, expected, atol=1e-6)
    assert info.fov == pytest.approx(89.9036, abs=1e-3)


@settings(max_examples=40, deadline=None)
@given(st.tuples(st.floats(2, 50), st.floats(-1, 1), st.floats(-1, 1)), st.floats(30, 120))
def test_the_projection_is_that_of_the_pictures(point: tuple[float, float, float], fov: float) -> None:
    simulator = shared()
    call(simulator, "simSetCameraFov", "tall", fov, "", False)
    info = call(simulator, "simGetCameraInfo", "tall", "", False)
    ahead, right, down = point[0], point[0] * point[1], point[0] * point[2]
    x, y, _, w = info.proj_mat.matrix.astype(float) @ [ahead, right, down, 1]
    shot = Shot(simulator.scene.eye, Pose(), 100, 200, fov)
    rays = shot.rays[0].reshape(200, 100, 3)  # they go east for right, north for ahead
    u, v = 50 * (1 + x / -w) - 0.5, 100 * (1 - y / -w) - 0.5
    expected = rays[100, 50, 0] / rays[100, 50, 1] - rays[100, 49, 0] / rays[100, 49, 1]  # a pixel
    assert (u - 49.5) * expected == pytest.approx(right / ahead, rel=1e-4, abs=1e-4)
    assert (v - 99.5) * expected == pytest.approx(down / ahead, rel=1e-4, abs=1e-4)


def test_poses_are_told_from_the_start_of_the_vehicle() -> None:
    simulator = simulated(settings=MISSION)
    put(simulator, at(13, 5, -7, yaw=180))
    pose = call(simulator, "simGetCameraInfo", "tall", "", False).pose
    np.testing.assert_allclose(pose.position, [2, 0, -5], atol=1e-9)
    np.testing.assert_allclose(matrix(pose.orientation) @ [1, 0, 0], [0, -1, 0], atol=1e-9)


def test_cameras_in_the_world_stay_where_they_are() -> None:
    simulator = simulated(settings=MISSION)
    put(simulator, at(13, 5, -7, yaw=180))
    info = call(simulator, "simGetCameraInfo", "tower", "", True)
    np.testing.assert_allclose(info.pose.position, [-5, 3, -20])
    call(simulator, "simSetCameraPose", "tower", at(1, 2, -3), "", True)
    np.testing.assert_allclose(call(simulator, "simGetCameraInfo", "tower", "", True).pose.position, [1, 2, -3])
    for name, external in (("tower", False), ("0", True)):
        with pytest.raises(Refused):
            call(simulator, "simGetCameraInfo", name, "", external)


def test_a_pose_that_was_set_is_relative_to_the_vehicle() -> None:
    simulator = simulated()
    vehicle = at(3, -4, -5, yaw=40, pitch=10, roll=-20)
    put(simulator, vehicle)
    mounted = at(0.1, 0.2, 0.3, yaw=-70, pitch=30)
    call(simulator, "simSetCameraPose", "front_center", mounted, "", False)
    found = seen_from(vehicle, call(simulator, "simGetCameraInfo", "0", "", False).pose)
    np.testing.assert_allclose(found.position, mounted.position, atol=1e-9)
    np.testing.assert_allclose(matrix(found.orientation), matrix(mounted.orientation), atol=1e-9)


def test_half_a_gimbal_takes_half_the_angle() -> None:
    text = MISSION.replace('"X": 1, "Yaw": 90', '"Gimbal": {"Stabilization": 0.5, "Pitch": 0}')
    simulator = simulated(settings=text)
    put(simulator, at(0, 0, -5, yaw=30, pitch=-20))
    pose = call(simulator, "simGetCameraInfo", "tall", "", False).pose
    np.testing.assert_allclose(matrix(pose.orientation), matrix(from_angles(30, -10, 0)), atol=1e-9)


def test_unfit_cameras_are_refused() -> None:
    simulator = simulated()
    for fov in (0.0, -5.0, 180.0, math.nan):
        with pytest.raises(Refused):
            call(simulator, "simSetCameraFov", "0", fov, "", False)
    for pose in (Pose(vector(math.nan, 0, 0)), Pose(vector(0, 0, 0), np.zeros(4))):
        with pytest.raises(Refused):
            call(simulator, "simSetCameraPose", "0", pose, "", False)


def test_distortion_is_kept() -> None:
    simulator = simulated()
    assert call(simulator, "simGetDistortionParams", "0", "", False) == [0.0] * 5
    call(simulator, "simSetDistortionParam", "0", "K3", 0.25, "", False)
    call(simulator, "simSetDistortionParam", "0", "Q", 0.25, "", False)
    assert call(simulator, "simGetDistortionParams", "0", "", False) == [0, 0, 0.25, 0, 0]


def test_lenses_follow_their_geometry() -> None:
    simulator = simulated()
    camera = "0", "", False
    before = call(simulator, "simGetImage", "0", 0, "", False)
    call(simulator, "simSetFocalLength", 24.0, *camera)
    assert call(simulator, "simSetFilmbackSettings", 36.0, 24.0, *camera) == pytest.approx(1.5)
    assert call(simulator, "simGetCameraInfo", *camera).fov == pytest.approx(2 * math.degrees(math.atan(36 / 2 / 24)))
    assert "73.7398" in call(simulator, "simGetCurrentFieldOfView", *camera)
    assert call(simulator, "simGetImage", "0", 0, "", False) == before
    call(simulator, "simSetCameraFov", "0", 50.0, "", False)
    assert call(simulator, "simGetFocalLength", *camera) == pytest.approx(18 / math.tan(math.radians(25)))
    call(simulator, "simSetFocusDistance", 300.0, *camera)
    call(simulator, "simSetFocusAperture", 4.0, *camera)
    call(simulator, "simEnableManualFocus", True, *camera)
    call(simulator, "simEnableFocusPlane", True, *camera)
    assert call(simulator, "simGetFocusDistance", *camera) == 300
    assert call(simulator, "simGetFocusAperture", *camera) == 4
    with pytest.raises(Refused):
        call(simulator, "simSetFocalLength", 0.0, *camera)


def test_presets_of_lenses_and_films() -> None:
    simulator = simulated()
    camera = "0", "", False
    assert any(
        text.startswith("Name: Universal Zoom;") for text in call(simulator, "simGetPresetLensSettings", *camera)
    )
    call(simulator, "simSetPresetLensSettings", "85mm Prime f/1.8", *camera)
    assert "85mm" in call(simulator, "simGetLensSettings", *camera)
    assert call(simulator, "simGetFocalLength", *camera) == 85
    call(simulator, "simSetPresetFilmbackSettings", "Super 8mm", *camera)
    assert "Super 8mm" in call(simulator, "simGetFilmbackSettings", *camera)
    call(simulator, "simSetPresetFilmbackSettings", "none", *camera)
    assert "Super 8mm" in call(simulator, "simGetFilmbackSettings", *camera)
    assert len(call(simulator, "simGetPresetFilmbackSettings", *camera)) > 5
