"""Frames against published values, rotation matrices and each other."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack import frames
from crosstrack.frames import Origin

ENU_OF_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FLU_OF_FRD = np.diag([1.0, -1.0, -1.0])
HOME = Origin(42.0, -82.0, 200.0)


def test_world_and_body_vectors_swap_as_their_definitions_say() -> None:
    north, east, down = np.eye(3)
    assert frames.enu_from_ned([north, east, down]).tolist() == [[0, 1, 0], [1, 0, 0], [0, 0, -1]]
    forward, right, down = np.eye(3)
    assert frames.flu_from_frd([forward, right, down]).tolist() == [[1, 0, 0], [0, -1, 0], [0, 0, -1]]


@pytest.mark.parametrize(
    ("there", "back"),
    [
        (frames.enu_from_ned, frames.ned_from_enu),
        (frames.flu_from_frd, frames.frd_from_flu),
        (frames.xyzw_from_wxyz, frames.wxyz_from_xyzw),
        (frames.attitude_enu_from_ned, frames.attitude_ned_from_enu),
    ],
)
def test_there_and_back_is_where_it_began(there, back) -> None:  # type: ignore[no-untyped-def]
    width = 3 if there in {frames.enu_from_ned, frames.flu_from_frd} else 4
    values = np.random.default_rng(1).normal(size=(2, 5, width))
    np.testing.assert_allclose(back(there(values)), values, atol=1e-15)


def test_scalar_part_moves() -> None:
    assert frames.xyzw_from_wxyz([1, 2, 3, 4]).tolist() == [2, 3, 4, 1]
    assert frames.wxyz_from_xyzw([2, 3, 4, 1]).tolist() == [1, 2, 3, 4]


def test_attitudes_are_the_same_rotation_seen_from_the_other_frames() -> None:
    ned = Rotation.random(50, random_state=2)
    expected = ENU_OF_NED @ ned.as_matrix() @ FLU_OF_FRD
    enu = frames.attitude_enu_from_ned(ned.as_quat())
    np.testing.assert_allclose(Rotation.from_quat(enu).as_matrix(), expected, atol=1e-14)


@given(st.floats(-50, 50))
def test_heading_and_yaw_point_the_same_way(heading: float) -> None:
    yaw = float(frames.yaw_from_heading(heading))
    assert -math.pi <= yaw < math.pi
    np.testing.assert_allclose([math.cos(yaw), math.sin(yaw)], [math.sin(heading), math.cos(heading)], atol=1e-12)
    level = Rotation.from_euler("z", heading).as_quat()
    seen = Rotation.from_quat(frames.attitude_enu_from_ned(level))
    np.testing.assert_allclose(seen.apply([1, 0, 0]), [math.cos(yaw), math.sin(yaw), 0], atol=1e-12)


@pytest.mark.parametrize(
    ("geodetic", "ecef"),
    [
        ([0, 0, 0], [6378137.0, 0, 0]),
        ([90, 0, 0], [0, 0, 6356752.314245]),  # the polar radius of WGS84
        ([42, -82, 200], [660675.2518247, -4700948.68316, 4245737.66222]),
    ],
)
def test_ecef_matches_published_values(geodetic: list[float], ecef: list[float]) -> None:
    np.testing.assert_allclose(frames.ecef_from_geodetic(geodetic), ecef, atol=1e-5)


@pytest.mark.parametrize(
    ("origin", "geodetic", "enu", "tolerance"),
    [
        # 1 km away at azimuth 33° and elevation 70°
        (
            HOME,
            [42.002581974253744, -81.997751960067460, 1139.701799575106],
            [186.277521, 286.842228, 939.692621],
            1e-5,
        ),
        # the Matterhorn from Zermatt, published to five digits
        (Origin(46.017, 7.750, 1673), [45.976, 7.658, 4531], [-7134.8, -4556.3, 2852.4], 0.06),
    ],
)
def test_local_points_match_published_values(
    origin: Origin, geodetic: list[float], enu: list[float], tolerance: float
) -> None:
    np.testing.assert_allclose(frames.local_from_geodetic(geodetic, origin), enu, atol=tolerance)


@given(st.floats(-90, 90), st.floats(-179.9, 179.9), st.floats(-5000, 1e6))
def test_geodetic_to_ecef_and_back_over_the_globe(latitude: float, longitude: float, altitude: float) -> None:
    there = frames.ecef_from_geodetic([latitude, longitude, altitude])
    back = frames.geodetic_from_ecef(there)
    np.testing.assert_allclose(frames.ecef_from_geodetic(back), there, atol=1e-7)
    np.testing.assert_allclose(back[[0, 2]], [latitude, altitude], atol=1e-8)


@given(
    st.floats(-89, 89),
    st.floats(-180, 180),
    st.tuples(*[st.floats(-10_000, 10_000)] * 3),
)
def test_local_to_geodetic_and_back_within_ten_kilometres(
    latitude: float, longitude: float, point: tuple[float, float, float]
) -> None:
    origin = Origin(latitude, longitude, 100.0)
    back = frames.local_from_geodetic(frames.geodetic_from_local(point, origin), origin)
    np.testing.assert_allclose(back, point, atol=1e-6)


def test_conversions_are_vectorised() -> None:
    points = np.random.default_rng(3).normal(scale=1000, size=(4, 5, 3))
    all_at_once = frames.geodetic_from_local(points, HOME)
    assert all_at_once.shape == (4, 5, 3)
    np.testing.assert_allclose(all_at_once[2, 3], frames.geodetic_from_local(points[2, 3], HOME), rtol=0, atol=1e-9)
