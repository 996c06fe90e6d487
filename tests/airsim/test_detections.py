"""Detections: things that are wanted, in view, and near enough; and the boxes around them."""

import numpy as np
import pytest
from scenery import at, call, put, simulated

from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import DetectionInfo, ImageRequest
from crosstrack.world.shapes import Box, Cylinder, Sphere

SHAPES = (
    Box((-2, 18, 9), (2, 20, 12)),
    Sphere((8, 25, 10), 2.0),
    Cylinder((-60, 0), 1.0, (0, 20)),
    Box((-1, 30, 9.5), (1, 31, 10.5)),
)
"""a box ahead, a ball beside it, a column out of view, and a box behind the first"""


def scenery() -> Simulator:
    """Return a simulator with a camera that looks north from 10 m up."""
    simulator = simulated(
        *SHAPES, settings='{"Vehicles": {"V": {"VehicleType": "SimpleFlight", "Y": 0, "Cameras": {"eye": {"X": 0}}}}}'
    )
    put(simulator, at(0, 0, -10))
    return simulator


def detected(simulator: Simulator, *patterns: str) -> dict[str, DetectionInfo]:
    """Return what is detected by some patterns, by name."""
    for pattern in patterns:
        call(simulator, "simAddDetectionFilterMeshName", "eye", 0, pattern, "", False)
    return {one.name: one for one in call(simulator, "simGetDetections", "eye", 0, "", False)}


def test_only_what_is_wanted_and_in_view() -> None:
    simulator = scenery()
    assert detected(simulator) == {}
    assert set(detected(simulator, "box*")) == {"Box_1"}
    assert set(detected(simulator, "SPHERE_?")) == {"Box_1", "Sphere_1"}
    assert set(detected(simulator, "*")) == {"Box_1", "Sphere_1"}
    call(simulator, "simClearDetectionMeshNames", "eye", 0, "", False)
    assert detected(simulator) == {}
    assert call(simulator, "simGetDetections", "eye", 5, "", False) == []


def test_within_a_radius() -> None:
    simulator = scenery()
    call(simulator, "simSetDetectionFilterRadius", "eye", 0, 2500.0, "", False)
    assert set(detected(simulator, "*")) == {"Box_1"}
    call(simulator, "simSetDetectionFilterRadius", "eye", 0, 2700.0, "", False)
    assert set(detected(simulator)) == {"Box_1", "Sphere_1"}


def test_boxes_hold_the_pixels_of_their_things() -> None:
    simulator = scenery()
    picture = call(simulator, "simGetImages", [ImageRequest("eye", 7, False, False)], "", False)[0]
    grey = np.frombuffer(picture.image_data_uint8, np.uint8).reshape(144, 256, 3)[..., 0]
    for name, found in detected(simulator, "*").items():
        rows, columns = np.nonzero(grey == call(simulator, "simGetSegmentationObjectID", name.lower()))
        low, high = found.box2D.min, found.box2D.max
        assert low[0] <= columns.min()
        assert columns.max() < high[0]
        assert low[1] <= rows.min()
        assert rows.max() < high[1]
        assert high[0] - low[0] < 1.3 * (columns.max() - columns.min() + 2)


def test_the_box_in_the_picture_of_a_box() -> None:
    found = detected(scenery(), "Box_1")["Box_1"]
    np.testing.assert_allclose(found.box2D.min, [128 - 128 * 2 / 18, 72 - 128 * 2 / 18], atol=1e-3)
    np.testing.assert_allclose(found.box2D.max, [128 + 128 * 2 / 18, 72 + 128 * 1 / 18], atol=1e-3)


def test_boxes_and_poses_in_space() -> None:
    simulator = scenery()
    put(simulator, at(0, 0, -10, yaw=20))
    found = detected(simulator, "Box_1")["Box_1"]
    turn = matrix(call(simulator, "simGetCameraInfo", "eye", "", False).pose.orientation)
    np.testing.assert_allclose(turn @ found.relative_pose.position, [19, 0, -0.5], atol=1e-6)
    np.testing.assert_allclose(turn @ found.box3D.min, [18, -2, 1], atol=1e-6)
    np.testing.assert_allclose(turn @ found.box3D.max, [20, 2, -2], atol=1e-6)
    np.testing.assert_allclose(turn @ matrix(found.relative_pose.orientation), np.eye(3), atol=1e-9)
    assert found.geo_point.altitude == pytest.approx(122 + 10.5)


def test_a_thing_that_surrounds_the_camera() -> None:
    simulator = simulated(Box((-50, 3, 0), (50, 4, 30)))
    put(simulator, at(0, 0, -10))
    call(simulator, "simAddDetectionFilterMeshName", "0", 0, "*", "", False)
    (found,) = call(simulator, "simGetDetections", "0", 0, "", False)
    np.testing.assert_allclose(found.box2D.min, [0, 0])
    np.testing.assert_allclose(found.box2D.max, [256, 144])


def test_unfit_filters_are_refused() -> None:
    simulator = scenery()
    with pytest.raises(Refused):
        call(simulator, "simGetDetections", "eye", 10, "", False)
    with pytest.raises(Refused):
        call(simulator, "simSetDetectionFilterRadius", "eye", 0, float("nan"), "", False)
    for k in range(1000):
        call(simulator, "simAddDetectionFilterMeshName", "eye", 0, f"x{k}", "", False)
    with pytest.raises(Refused, match="no more"):
        call(simulator, "simAddDetectionFilterMeshName", "eye", 0, "y", "", False)
