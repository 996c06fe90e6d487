"""Pictures: what a pinhole camera sees of planes, boxes and balls, in every type."""

import io
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image
from scenery import at, call, put, simulated, vector

from crosstrack import frames
from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.scene.images import NOTHING, Shot
from crosstrack.airsim.scene.palette import PALETTE
from crosstrack.airsim.scene.png import encoded
from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers import images
from crosstrack.airsim.server.handlers.images import MOST_PIXELS
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import ImageRequest, ImageResponse
from crosstrack.types import Array
from crosstrack.world.shapes import Box, Sphere
from crosstrack.world.world import World

WALL = Box((-50, 20, 0), (50, 21, 30))
"""20 m north of the origin"""
CAMERA = '{"Vehicles": {"V": {"VehicleType": "SimpleFlight", "Cameras": {"eye": {%s}}}}}'


def eye(captures: str = "", more: str = "") -> str:
    """Return settings of a vehicle with a camera in its middle that looks ahead."""
    return CAMERA % f'"X": 0, "Y": 0, "Z": 0, {more} "CaptureSettings": [{captures}]'


def taken(simulator: Simulator, kind: int, as_float: bool = False, compress: bool = False) -> ImageResponse:
    """Return a picture of the camera."""
    request = ImageRequest("eye", kind, as_float, compress)
    found: ImageResponse = call(simulator, "simGetImages", [request], "", False)[0]
    return found


def numbers(simulator: Simulator, kind: int) -> Array:
    """Return a picture as numbers (rows, columns)."""
    picture = taken(simulator, kind, as_float=True)
    assert picture.image_data_uint8 == b""
    return picture.image_data_float.reshape(picture.height, picture.width).astype(float)


def colours(simulator: Simulator, kind: int) -> NDArray[np.uint8]:
    """Return a picture as it comes (rows, columns, 3): blue, green, red."""
    picture = taken(simulator, kind)
    assert len(picture.image_data_float) == 0
    return np.frombuffer(picture.image_data_uint8, np.uint8).reshape(picture.height, picture.width, 3)


def test_depth_of_a_wall_and_the_ground() -> None:
    simulator = simulated(WALL, settings=eye())
    put(simulator, at(0, 0, -10))
    planar, along = numbers(simulator, 1), numbers(simulator, 2)
    assert planar.shape == (144, 256)
    down = (np.arange(144) + 0.5 - 72) / 128
    right = (np.arange(256) + 0.5 - 128) / 128
    ground = np.where(down > 0, 10 / np.maximum(down, 1e-9), np.inf)[:, None]
    top = down[:, None] > -20 / 20
    expected = np.where(top, np.minimum(20.0, ground), np.where(down[:, None] > 0, ground, NOTHING))
    expected = np.broadcast_to(expected, planar.shape)
    np.testing.assert_allclose(planar, expected, rtol=1e-5)
    slant = np.sqrt(1 + down[:, None] ** 2 + right**2)
    np.testing.assert_allclose(along, np.minimum(expected * slant, NOTHING), rtol=1e-5)
    np.testing.assert_allclose(numbers(simulator, 3), np.minimum(expected / 100, 1), rtol=1e-5)
    np.testing.assert_allclose(numbers(simulator, 4), np.minimum(0.25 / 2 / expected, 1), rtol=1e-5)


def test_sky_is_as_deep_as_half_precision_goes() -> None:
    simulator = simulated(settings=eye())
    put(simulator, at(0, 0, -10, pitch=60))
    assert (numbers(simulator, 1) == np.finfo(np.float16).max).all()
    assert (numbers(simulator, 3) == 1).all()
    assert (colours(simulator, 5) == PALETTE[call(simulator, "simGetSegmentationObjectID", "skysphere")][::-1]).all()


@settings(max_examples=25, deadline=None)
@given(
    st.floats(-180, 180),
    st.floats(-89, 89),
    st.floats(-180, 180),
    st.floats(20, 150),
    st.tuples(st.floats(-15, 15), st.floats(-15, 15), st.floats(-20, -3)),
)
def test_every_pixel_lies_on_what_it_shows(
    yaw: float, pitch: float, roll: float, fov: float, place: tuple[float, float, float]
) -> None:
    scene = Scene()
    pose = at(*place, yaw, pitch, roll)
    if scene.world.distance(frames.enu_from_ned(pose.position)) < 0.5:
        return
    shot = Shot(scene.eye, pose, 24, 18, fov)
    focal = 12 / math.tan(math.radians(fov / 2))
    v, u = np.mgrid[:18, :24].reshape(2, -1)
    rays = np.stack([np.ones(u.size), (u + 0.5 - 12) / focal, (v + 0.5 - 9) / focal], axis=1)
    depth = shot.planar.astype(float)
    hit = depth < NOTHING
    points = frames.enu_from_ned(pose.position + (rays[hit] * depth[hit, None]) @ matrix(pose.orientation).T)
    off = np.minimum(np.abs(points[:, 2]), np.abs(scene.world.distance(points)))
    assert (off < 1e-5 * np.maximum(depth[hit], 1) + scene.world.optimism).all()
    shown = shot.sighting.seen[hit]
    assert (np.abs(points[shown == 1, 2]) < 1e-4 * np.maximum(depth[hit][shown == 1], 1)).all()
    for number in np.unique(shown[shown > 1]):
        low, high = shot.eye.things[number].box
        part = points[shown == number]
        assert ((part >= low - 1e-2) & (part <= high + 1e-2)).all()


def test_right_is_right_and_up_is_up() -> None:
    ball = Sphere((5, 20, 14), 1.0)
    simulator = simulated(ball, settings=eye())
    put(simulator, at(0, 0, -10))
    image = colours(simulator, 7)[..., 0]
    rows, columns = np.nonzero(image == call(simulator, "simGetSegmentationObjectID", "sphere_1"))
    assert columns.mean() == pytest.approx(128 * (1 + 5 / 20) - 0.5, abs=0.5)
    assert rows.mean() == pytest.approx(72 - 128 * 4 / 20 - 0.5, abs=0.5)
    span = 2 * 128 * 1.0 / 20
    assert rows.max() - rows.min() + 1 == pytest.approx(span, abs=2)


def test_roll_turns_the_picture() -> None:
    simulator = simulated(Sphere((5, 20, 10), 1.0), settings=eye())
    put(simulator, at(0, 0, -10, roll=90))
    number = call(simulator, "simGetSegmentationObjectID", "sphere_1")
    rows, columns = np.nonzero(colours(simulator, 7)[..., 0] == number)
    assert columns.mean() == pytest.approx(127.5, abs=1)
    assert rows.mean() == pytest.approx(71.5 - 128 * 5 / 20, abs=1)  # what was right of a camera is above it now


def test_segmentation_shows_numbers() -> None:
    simulator = simulated(WALL, settings=eye())
    put(simulator, at(0, 0, -10))
    assert call(simulator, "simSetSegmentationObjectID", "box_\\d", 42, True)
    image = colours(simulator, 5)
    assert (image[71, 128] == PALETTE[42][::-1]).all()
    assert call(simulator, "simSetSegmentationObjectID", "Box_1", -1, False)
    assert (colours(simulator, 5)[71, 128] == 0).all()
    assert len(np.unique(PALETTE, axis=0)) == 256


def test_normals_of_a_wall_and_the_ground() -> None:
    simulator = simulated(WALL, settings=eye())
    put(simulator, at(0, 0, -10))
    image = colours(simulator, 6)[..., ::-1].astype(int)
    assert image[60, 128].tolist() == [0, 127, 127]  # faces south
    assert image[143, 128].tolist() == [127, 127, 255]


def test_normals_of_a_ball_are_its_radii() -> None:
    world = World((Sphere((0, 10, 10), 3.0),))
    shot = Shot(Scene(world).eye, at(0, 0, -10), 64, 64, 60.0)
    hit = shot.sighting.seen == 2
    points = shot.origin + shot.rays[0][hit] * shot.sighting.ranges[hit, None]
    normals = shot.eye.normals(shot.origin, shot.rays[0], shot.sighting)[hit]
    np.testing.assert_allclose(normals, (points - [0, 10, 10]) / 3, atol=2e-3)
    assert hit.sum() > 500


def test_png_holds_the_same_picture() -> None:
    simulator = simulated(WALL, Sphere((5, 10, 5), 2.0), settings=eye())
    put(simulator, at(0, 0, -5))
    for kind in (0, 3, 5, 6, 7):
        png = Image.open(io.BytesIO(taken(simulator, kind, compress=True).image_data_uint8))
        assert png.mode == "RGBA"
        np.testing.assert_array_equal(np.array(png)[..., 2::-1], colours(simulator, kind))
        assert (np.array(png)[..., 3] == 255).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 40), st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_png_of_noise(width: int, height: int, seed: int) -> None:
    picture = np.random.default_rng(seed).integers(0, 256, (height, width, 4), dtype=np.uint8)
    np.testing.assert_array_equal(np.array(Image.open(io.BytesIO(encoded(picture)))), picture)


def test_sunlit_sides_are_brighter() -> None:
    box = Box((-3, 10, 0), (3, 16, 6))
    south, north = simulated(box, settings=eye()), simulated(box, settings=eye())
    put(south, at(0, 0, -3))
    put(north, at(30, 0, -3, yaw=180))
    lit = colours(north, 0)[71, 128].sum(dtype=int)
    assert lit > 1.2 * colours(south, 0)[71, 128].sum(dtype=int)


def test_a_vehicle_sees_others_but_not_itself() -> None:
    two = '{"Vehicles": {"A": {"VehicleType": "SimpleFlight"}, "B": {"VehicleType": "SimpleFlight", "X": 8}}}'
    simulator = simulated(settings=two)
    put(simulator, at(0, 0, -5), "A")
    put(simulator, at(8, 0, -5), "B")
    request = [ImageRequest("0", 1, True, False)]
    depth = call(simulator, "simGetImages", request, "A", False)[0].image_data_float.reshape(144, 256)
    assert depth[:72].min() == pytest.approx(8 - 0.46 - RADIUS, abs=5e-3)
    depth = call(simulator, "simGetImages", request, "B", False)[0].image_data_float.reshape(144, 256)
    assert (depth[:72] == NOTHING).all()


def test_sizes_and_fields_of_view_by_type() -> None:
    simulator = simulated(WALL, settings=eye('{"ImageType": 1, "Width": 64, "Height": 48, "FOV_Degrees": 40}'))
    put(simulator, at(0, 0, -10))
    assert numbers(simulator, 1).shape == (48, 64)
    assert numbers(simulator, 2).shape == (144, 256)
    call(simulator, "simSetCameraFov", "eye", 120.0, "", False)
    corner = numbers(simulator, 2)[71, 0]
    assert corner == pytest.approx(20 * math.hypot(1, 255 / 256 * math.tan(math.radians(60))), rel=1e-3)


def test_a_camera_goes_with_its_vehicle() -> None:
    simulator = simulated(WALL, settings=eye())
    put(simulator, at(0, 0, -10, yaw=90))
    call(simulator, "simSetCameraPose", "eye", at(0, -2, -1, yaw=-90), "", False)
    picture = taken(simulator, 1, as_float=True)
    np.testing.assert_allclose(picture.camera_position, [2, 0, -11], atol=1e-9)
    assert numbers(simulator, 1)[71, 128] == pytest.approx(18, abs=1e-4)
    assert picture.time_stamp == simulator.now


def test_a_gimbal_keeps_the_camera_level() -> None:
    simulator = simulated(WALL, settings=eye(more='"Gimbal": {"Stabilization": 1, "Pitch": 0, "Roll": 0},'))
    put(simulator, at(0, 0, -10, pitch=-20, roll=15))
    pose = call(simulator, "simGetCameraInfo", "eye", "", False).pose
    np.testing.assert_allclose(matrix(pose.orientation) @ vector(0, 0, 1), [0, 0, 1], atol=1e-9)


def test_optical_flow_is_told_to_be_absent() -> None:
    simulator = simulated(settings=eye())
    picture = taken(simulator, 8)
    assert "null" in picture.message
    assert (picture.width, picture.height, picture.image_data_uint8) == (0, 0, b"")
    assert call(simulator, "simGetImage", "eye", 9, "", False) == b""


def test_what_is_not_there_is_refused() -> None:
    simulator = simulated(settings=eye())
    for camera, kind, external in (("none", 0, False), ("eye", 10, False), ("eye", -1, False), ("eye", 0, True)):
        with pytest.raises(Refused):
            call(simulator, "simGetImage", camera, kind, "", external)
    with pytest.raises(Refused, match="Sim-API for 'W'"):
        call(simulator, "simGetImage", "eye", 0, "W", False)


def test_a_picture_asked_for_many_times_is_taken_once_and_only_so_many_are_answered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    simulator = simulated(WALL, settings=eye())
    looks, look = [], Shot.scene
    monkeypatch.setattr(Shot, "scene", lambda shot: looks.append(shot) or look(shot))  # type: ignore[func-returns-value]
    most = MOST_PIXELS // (256 * 144)
    asked = [ImageRequest("0"), ImageRequest("front_center", pixels_as_float=False, compress=False)] * (most // 2)
    answers = call(simulator, "simGetImages", asked, "", False)
    assert [one.camera_name for one in answers] == [one.camera_name for one in asked]
    assert len(looks) == len({(one.pixels_as_float, one.compress) for one in asked})
    assert answers[-1].image_data_uint8 is answers[1].image_data_uint8
    assert len(answers) * 256 * 144 <= MOST_PIXELS
    for count in (most + 1, 100_000):
        with pytest.raises(Refused, match="pixels"):
            call(simulator, "simGetImages", [ImageRequest("eye")] * count, "", False)


def test_one_picture_may_be_as_large_as_the_settings_say(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = simulated(WALL, settings=eye('{"ImageType": 1, "Width": 40, "Height": 20}'))
    monkeypatch.setattr(images, "MOST_PIXELS", 799)
    assert taken(simulator, 1, as_float=True).width == 40
    with pytest.raises(Refused, match="1600 pixels at once; at most 799"):
        call(simulator, "simGetImages", [ImageRequest("eye", 1)] * 2, "", False)
