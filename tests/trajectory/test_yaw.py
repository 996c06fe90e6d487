"""Yaw against the direction it follows and finite differences; rests, reversals, full turns."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.path.pace import course_of
from crosstrack.trajectory.flatness.yaw import TURN_RATE, Faced, Fixed, Turning, Yaw, along_velocity, towards
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Envelope

corner = st.tuples(*[st.floats(-20, 20).map(lambda x: round(x, 2))] * 3)


def through(points: object, pace: float = 2.0) -> PiecewisePolynomial:
    corners = np.array(points, float)
    return minimum(corners, pace * np.arange(len(corners)), 4)


def loops(count: int) -> PiecewisePolynomial:
    angles = np.arange(4 * count + 1) * math.pi / 2
    return through(np.column_stack([6 * np.cos(angles), 6 * np.sin(angles), 5 + 0 * angles]), 1.5)


def assert_derivatives_agree(yaw: Yaw, duration: float) -> None:
    """Yaw is the integral of its rate, and the rate that of the acceleration: no jumps either."""
    t = np.linspace(0, duration, 20_001)
    middles, h = 0.5 * (t[1:] + t[:-1]), t[1]
    for order in (0, 1):
        steps = np.diff(yaw(t, order))
        integral = h / 6 * (yaw(t[:-1], order + 1) + 4 * yaw(middles, order + 1) + yaw(t[1:], order + 1))
        np.testing.assert_allclose(steps, integral, atol=1e-4 * (1 + np.abs(steps).max()) + 0.02 * h)


@settings(max_examples=15)
@given(st.lists(corner, min_size=3, max_size=6), corner)
def test_yaw_follows_its_vector_and_is_smooth(points: list[tuple[float, ...]], point: tuple[float, ...]) -> None:
    curve = through([(x, y, z + 4 * k) for k, (x, y, z) in enumerate(points)])
    t = np.linspace(0, curve.duration, 4001)
    for yaw, vector in (
        (along_velocity(curve), curve(t, 1)),
        (towards(curve, np.array(point)), np.array(point) - curve(t)),
    ):
        gaps = getattr(yaw, "gaps", np.array([[0.0, curve.duration]]))
        free = ~((gaps[:, :1] <= t) & (t <= gaps[:, 1:])).any(axis=0)
        direction = np.arctan2(vector[:, 1], vector[:, 0])
        np.testing.assert_allclose(np.exp(1j * (yaw(t) - direction)[free]), 1, atol=1e-9)
        assert (np.hypot(vector[:, 0], vector[:, 1])[free] > 0.2 - 1e-9).all()


BEND = PiecewisePolynomial(np.array([10.0]), np.array([[[0.0, 0, 0], [5, 0.15, 0], [-0.5, 0, 0]]]))
"""turns all but round at 0.15 m/s, too slow for a direction"""


@pytest.mark.parametrize("curve", [loops(2), BEND, through([[0, 0, 0], [8, 1, 0], [2, 6, 3], [0, -5, 1]])])
def test_rate_and_acceleration_are_derivatives(curve: PiecewisePolynomial) -> None:
    for yaw in (along_velocity(curve), towards(curve, np.array([1.0, 1.5, 0])), Fixed(2.0)):
        assert_derivatives_agree(yaw, curve.duration)


def test_yaw_rate_and_acceleration_go_over_into_turns_without_a_jump() -> None:
    yaw, moment = along_velocity(BEND), 1e-7
    assert isinstance(yaw, Turning)
    assert len(yaw.gaps) == 1
    for time in yaw.gaps[0]:
        for order in (0, 1, 2):
            assert yaw(time - moment, order) == pytest.approx(float(yaw(time + moment, order)), abs=1e-4)
        assert abs(yaw(time, 2)) > 1e-2


def test_full_turns_are_counted() -> None:
    curve = loops(3)
    for yaw, apart in ((along_velocity(curve), 1.5), (towards(curve, np.array([0.0, 0, 0])), 1e-9)):
        turned = float(yaw(curve.duration) - yaw(0.0))
        assert turned == pytest.approx(6 * math.pi, abs=apart)
        assert np.abs(np.diff(yaw(np.linspace(0, curve.duration, 5001)))).max() < 0.05


def test_a_vehicle_looks_ahead_before_it_moves_and_after_it_stopped() -> None:
    curve = through([[0, 0, 0], [-6, -8, 0]])
    yaw = along_velocity(curve)
    ahead = math.atan2(-8, -6)
    np.testing.assert_allclose(yaw(np.linspace(0, curve.duration, 50)), ahead, atol=1e-9)
    np.testing.assert_allclose(yaw(np.array([-1.0, 0.0, 99.0])), ahead, atol=1e-9)


def test_a_reversal_is_a_turn_round_at_a_rate_that_can_be_flown() -> None:
    curve = through([[0, 0, 0], [30, 0, 0], [0, 0, 0]], pace=8.0)
    yaw = along_velocity(curve)
    t = np.linspace(0, curve.duration, 4001)
    assert yaw(2.0) == pytest.approx(0, abs=1e-9)
    assert abs(yaw(14.0)) == pytest.approx(math.pi, abs=1e-9)
    assert np.abs(yaw(t, 1)).max() == pytest.approx(TURN_RATE, rel=0.02)
    assert_derivatives_agree(yaw, curve.duration)


def test_turns_that_meet_are_one() -> None:
    """Two reversals, closer together than a turn round takes, and then too many for any turn."""
    curve = through([[0, 0, 0], [40, 0, 0], [38, 0, 0], [80, 0, 0]], pace=4.0)
    yaw = along_velocity(curve)
    assert isinstance(yaw, Turning)
    assert len(yaw.gaps) == 3
    assert_derivatives_agree(yaw, curve.duration)
    often = through([[0, 0, 0], [3, 0, 0], [0, 0, 0], [3, 0, 0], [0, 0.1, 0]], pace=1.2)
    np.testing.assert_allclose(along_velocity(often)(np.linspace(0, 4.8, 9)), 0.0, atol=0.3)


def test_straight_up_there_is_no_direction() -> None:
    climb = through([[1, 1, 0], [1, 1, 9]])
    t = np.array([0.0, 1.0, 2.0])
    np.testing.assert_allclose(along_velocity(climb, before=0.4)(t), 0.4)
    np.testing.assert_allclose(towards(climb, np.array([1.0, 1.0, 5]), before=0.4)(t, 1), 0.0)
    np.testing.assert_allclose(towards(climb, np.array([1.0, 4.0]))(t), math.pi / 2)


def test_passing_over_the_point_turns_round_in_time() -> None:
    curve = through([[-10, 0, 5], [10, 0, 5]], pace=8.0)
    yaw = towards(curve, np.array([0.0, 0.0, 0.0]))
    assert yaw(1.0) == pytest.approx(0, abs=1e-9)
    assert abs(yaw(7.0)) == pytest.approx(math.pi, abs=1e-9)
    assert_derivatives_agree(yaw, curve.duration)


def test_a_faced_trajectory_is_the_same_course() -> None:
    curve = loops(1)
    envelope = Envelope(12.0, 6.0, 8.0, 4.0, 0.09)
    bare, faced = course_of(curve, envelope), course_of(Faced(curve, Fixed(1.0)), envelope)
    assert faced.path.length == bare.path.length
    s: Array = np.linspace(0, bare.path.length, 99)
    np.testing.assert_array_equal(faced.path(s), bare.path(s))
