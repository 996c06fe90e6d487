"""From forces to attitudes and rates: against scipy's rotations and finite differences."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.track.attitude import (
    axes_for,
    axes_of,
    capped,
    drag_of,
    drag_while,
    error_of,
    rate_along,
)
from crosstrack.types import GRAVITY, Array

ANGLES = st.floats(-math.pi, math.pi)
PUSH = st.floats(-15.0, 15.0)
NONE = np.zeros(3)


def columns(axes: tuple[float, ...]) -> Array:
    """Return body axes as the columns of a matrix."""
    return np.array(axes).reshape(3, 3).T


@given(ANGLES, st.floats(-1.4, 1.4), ANGLES)
def test_axes_are_those_of_the_rotation(yaw: float, pitch: float, roll: float) -> None:
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    np.testing.assert_allclose(columns(axes_of(turn.as_quat())), turn.as_matrix(), atol=1e-12)


@given(PUSH, PUSH, st.floats(1.0, 30.0), ANGLES)
def test_axes_for_a_force_point_along_it_and_at_the_yaw(x: float, y: float, z: float, yaw: float) -> None:
    force = np.array([x, y, z])
    frame = columns(axes_for((x, y, z), yaw))
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)
    np.testing.assert_allclose(frame[:, 2], force / np.linalg.norm(force), atol=1e-12)
    assert frame[:, 0] @ [-math.sin(yaw), math.cos(yaw), 0.0] == pytest.approx(0, abs=1e-12)
    assert frame[:, 0] @ [math.cos(yaw), math.sin(yaw), 0.0] > 0


@given(st.integers(0, 2**32 - 1))
def test_rates_are_the_derivative_of_the_attitude(seed: int) -> None:
    rng = np.random.default_rng(seed)
    force, change = rng.normal(0, 6, 3) + [0, 0, 14], rng.normal(0, 20, 3)
    if force[2] < 3:
        force[2] = 3.0
    yaw, spin, h = rng.uniform(-3, 3), rng.uniform(-2, 2), 1e-6

    def frame(t: float) -> Array:
        return columns(axes_for(tuple(force + t * change), yaw + t * spin))

    swing = frame(0).T @ (frame(h) - frame(-h)) / (2 * h)
    found = rate_along(axes_for(tuple(force), yaw), tuple(force), tuple(change), yaw, spin)
    np.testing.assert_allclose(found, [swing[2, 1], swing[0, 2], swing[1, 0]], atol=1e-5, rtol=1e-5)


@given(ANGLES, ANGLES, st.floats(-1.0, 1.0))
def test_the_error_of_a_turn_is_its_sine_along_its_axis(yaw: float, pitch: float, angle: float) -> None:
    turn = Rotation.from_euler("ZY", [yaw, pitch])
    axis = np.array([0.48, 0.6, 0.64])
    wanted = axes_of(turn.as_quat())
    flown = axes_of((turn * Rotation.from_rotvec(angle * axis)).as_quat())
    np.testing.assert_allclose(error_of(flown, wanted), math.sin(angle) * axis, atol=1e-12)


def test_drag_is_along_the_body_axes() -> None:
    turn = Rotation.from_euler("ZYX", [0.3, -0.7, 0.4])
    linear, square, air = np.array([0.5, 0.4, 0.1]), np.array([0.01, 0.02, 0.03]), np.array([4.0, -7.0, 2.0])
    seen = turn.inv().apply(air)
    expected = turn.apply(-(1.2 * linear + square * np.abs(seen)) * seen)
    found = drag_of(axes_of(turn.as_quat()), tuple(air), 1.2, linear, square)
    np.testing.assert_allclose(found, expected)


def test_drag_while_flying_agrees_with_the_thrust_that_meets_it() -> None:
    turn = Rotation.from_euler("ZYX", [0.3, 0.6, 0.2])
    axes, air = axes_of(turn.as_quat()), np.array([10.0, 2.0, 1.0])
    linear, square = np.array([0.5, 0.4, 0.2]), np.array([0.01, 0.01, 0.02])
    need = np.array([1.0, 0.0, GRAVITY])
    drag = np.array(drag_while(axes, tuple(air), tuple(need), linear, square))
    effort = math.sqrt((need - drag) @ turn.as_matrix()[:, 2] / GRAVITY)
    np.testing.assert_allclose(drag, drag_of(axes, tuple(air), effort, linear, square), rtol=0.02)


@given(PUSH, PUSH, PUSH)
def test_capped_rates_keep_their_direction(x: float, y: float, z: float) -> None:
    found = np.array(capped((x, y, z), 8.0))
    assert np.hypot(found[0], found[1]) <= 8 * (1 + 1e-12)
    assert abs(found[2]) <= 8
    assert found[0] * y == pytest.approx(found[1] * x, abs=1e-9)
    if np.hypot(x, y) <= 8:
        np.testing.assert_allclose(found[:2], [x, y])
