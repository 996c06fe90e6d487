from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.fastest import fastest
from crosstrack.trajectory.times.timing import constant_speed, rescaled, square_root, trapezoid
from crosstrack.types import Array

TUTORIAL = [[0, 0], [1, 2], [2, -1], [4, 8], [5, 2]]
positive = st.floats(0.1, 50.0)
routes = st.integers(0, 1000).map(lambda seed: np.random.default_rng(seed).uniform(-20, 20, (6, 3)))


def times(durations: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(durations)])


def test_constant_speed_is_the_tutorials() -> None:
    expected = [0, 0.5400960100096803, 1.3039071123489652, 3.5307800095935304, 5]
    np.testing.assert_allclose(times(constant_speed(TUTORIAL, total=5)), expected, rtol=1e-14)


def test_square_root_of_the_lengths() -> None:
    durations = square_root([[0, 0], [1, 0], [1, 4], [10, 4]], total=12.0)
    np.testing.assert_allclose(durations, [2, 4, 6], rtol=1e-14)


@given(route=routes, speed=positive, climb=positive)
def test_constant_speed_takes_the_longer_of_the_way_and_the_climb(route: Array, speed: float, climb: float) -> None:
    durations = constant_speed(route, MotionLimits(speed=speed, speed_vertical=climb))
    steps = np.diff(route, axis=0)
    expected = np.maximum(np.linalg.norm(steps, axis=1) / speed, np.abs(steps[:, 2]) / climb)
    np.testing.assert_allclose(durations, expected, rtol=1e-12)


@given(route=routes, speed=positive, acceleration=positive)
def test_a_trapezoid_covers_the_leg(route: Array, speed: float, acceleration: float) -> None:
    durations = trapezoid(route, MotionLimits(speed=speed, acceleration=acceleration))
    ramp = np.minimum(speed / acceleration, durations / 2)
    covered = acceleration * ramp * (durations - ramp)
    np.testing.assert_allclose(covered, np.linalg.norm(np.diff(route, axis=0), axis=1), rtol=1e-9)


@given(route=routes, speed=positive, acceleration=positive, climb=positive, lift=positive)
def test_a_trapezoid_keeps_within_vertical_limits(
    route: Array, speed: float, acceleration: float, climb: float, lift: float
) -> None:
    limits = MotionLimits(speed, climb, acceleration, lift)
    durations = trapezoid(route, limits)
    steps = np.diff(route, axis=0)
    upright = np.zeros_like(route)
    upright[:, 2] = route[:, 2]
    plain = trapezoid(route, MotionLimits(speed=speed, acceleration=acceleration))
    alone = trapezoid(upright, MotionLimits(speed=climb, acceleration=lift))
    longer = np.maximum(plain, alone)
    assert (durations >= longer * (1 - 1e-12)).all()
    together = np.isclose(np.abs(steps[:, 2]), np.linalg.norm(steps, axis=1) * min(climb / speed, lift / acceleration))
    steep = np.abs(steps[:, 2]) / np.linalg.norm(steps, axis=1)
    one_rules = (steep >= max(climb / speed, lift / acceleration)) | (steep <= min(climb / speed, lift / acceleration))
    np.testing.assert_allclose(durations[one_rules & ~together], longer[one_rules & ~together], rtol=1e-9)


def test_everything_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        trapezoid([[0, 0], [0, 0], [1, 0], [1, 0]], MotionLimits(speed=-1.0, speed_vertical=2.0), total=-3)
    assert [problem.place for problem in caught.value.problems] == [
        "waypoints[1]",
        "waypoints[3]",
        "limits.speed",
        "limits.speed_vertical",
        "limits.acceleration",
        "total",
    ]
    assert "must not repeat waypoints[0]" in str(caught.value)


@pytest.mark.parametrize("waypoints", [[[0, 0]], [0, 1], [[0, np.nan], [1, 1]], [["a"]], []])
def test_waypoints_that_are_none(waypoints: object) -> None:
    with pytest.raises(InputError, match="waypoints"):
        constant_speed(waypoints, total=1.0)  # type: ignore[arg-type] # what a caller without types may pass


def test_constant_speed_needs_a_speed_or_a_total() -> None:
    with pytest.raises(InputError, match=r"limits\.speed: must be given"):
        constant_speed(TUTORIAL)


def most(curve: PiecewisePolynomial, order: int, axes: slice) -> float:
    t = np.linspace(0, curve.duration, 5001)
    return float(np.linalg.norm(curve(t, order)[:, axes], axis=1).max())


@settings(max_examples=10)
@given(route=routes, tight=st.integers(0, 4))
def test_rescaled_meets_the_tightest_limit_and_passes_none(route: Array, tight: int) -> None:
    curve = minimum(route, times(constant_speed(route, total=9.0)), 4)
    rows = [(1, slice(0, 3)), (1, slice(2, 3)), (2, slice(0, 3)), (2, slice(2, 3)), (3, slice(0, 3))]
    peaks = [most(curve, order, axes) for order, axes in rows]
    at = enumerate(zip(peaks, rows, strict=True))
    # limits for the double pace, all but one of them loose
    values = [peak * 2.0**order * (1.0 if k == tight else 3.0) for k, (peak, (order, _)) in at]
    fast = rescaled(curve, MotionLimits(*values))
    assert fast.duration == pytest.approx(4.5, rel=1e-5)
    for value, (order, axes) in zip(values, rows, strict=True):
        assert most(fast, order, axes) <= value
    order = rows[tight][0]  # as exact as the duration, to which power it grows
    assert most(fast, *rows[tight]) == pytest.approx(values[tight], rel=order * 1e-5)
    t = np.linspace(0, 1, 50)
    np.testing.assert_allclose(fast(t * fast.duration), curve(t * curve.duration), atol=1e-9)


def test_rescaled_has_the_closed_form_of_one_leg() -> None:
    curve = minimum([[0, 0, 0], [3, 4, 0]], [0, 1], 3)
    assert rescaled(curve, MotionLimits(speed=2.0)).duration == pytest.approx(15 / 8 * 5 / 2, rel=1e-7)
    peak = 10 / np.sqrt(3)
    assert rescaled(curve, MotionLimits(acceleration=2.0)).duration == pytest.approx(np.sqrt(peak * 5 / 2), rel=1e-7)
    assert rescaled(curve, MotionLimits(jerk=2.0)).duration == pytest.approx(np.cbrt(60 * 5 / 2), rel=1e-7)


def test_rescaled_takes_a_loop_but_no_curve_that_starts_moving() -> None:
    loop = minimum([[0, 0], [4, 0], [4, 4], [0, 0]], [0, 2, 4, 6], 3, periodic=True)
    assert most(rescaled(loop, MotionLimits(speed=1.0)), 1, slice(0, 2)) == pytest.approx(1.0, rel=1e-5)
    moving = minimum([[0, 0], [4, 0]], [0, 2], 3, start=[[1, 0]])
    with pytest.raises(InputError, match=r"curve\.start: must be at rest"):
        rescaled(moving, MotionLimits(speed=1.0))


def test_rescaled_refuses_what_has_no_answer() -> None:
    curve = minimum([[0, 0, 0], [3, 4, 0]], [0, 1], 3)
    with pytest.raises(InputError, match="at least one limit"):
        rescaled(curve, MotionLimits())
    with pytest.raises(InputError, match="does not move"):
        rescaled(curve, MotionLimits(speed_vertical=1.0))
    with pytest.raises(InputError, match=r"limits\.jerk: must be above 0"):
        rescaled(curve, MotionLimits(jerk=0.0))


def test_whole_numbers_are_limits_too() -> None:
    waypoints = [[0, 0, 0], [10, 0, 1], [10, 5, 3]]
    whole = trapezoid(waypoints, MotionLimits(speed=4, speed_vertical=1, acceleration=2, acceleration_vertical=1))
    same = trapezoid(
        waypoints, MotionLimits(speed=4.0, speed_vertical=1.0, acceleration=2.0, acceleration_vertical=1.0)
    )
    np.testing.assert_array_equal(whole, same)
    assert np.isfinite(whole).all()


@pytest.mark.parametrize("limits", [None, 3.0, {"speed": 3}])
def test_limits_that_are_none_are_named(limits: Any) -> None:
    waypoints = [[0, 0, 0], [10, 0, 1]]
    curve = minimum(waypoints, [0, 3])
    for call in (
        lambda: trapezoid(waypoints, limits),
        lambda: fastest(waypoints, limits),
        lambda: rescaled(curve, limits),
    ):
        with pytest.raises(InputError, match="limits: must be MotionLimits"):
            call()
