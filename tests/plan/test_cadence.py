"""Knots along the legs: at the times of a vehicle that slows for corners, at rest at the ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.plan.cadence import MOST, MOST_EACH, STEP, evenly, spread
from crosstrack.trajectory.limits import MotionLimits

LIMITS = MotionLimits(speed=5.0, speed_vertical=2.0, acceleration=4.0, acceleration_vertical=2.0)


def test_a_straight_leg_is_a_trapezoid() -> None:
    knots, times = spread(np.array([[0.0, 0, 0], [20, 0, 0]]), 0.3, LIMITS)
    assert times[-1] == pytest.approx(20 / 5 + 5 / 4)
    t = np.minimum(times, times[-1] - times)
    from_end = np.where(t < 1.25, 2 * t**2, 3.125 + 5 * (t - 1.25))
    np.testing.assert_allclose(np.minimum(knots[:, 0], 20 - knots[:, 0]), from_end, atol=1e-9)


def test_a_short_leg_never_cruises_and_a_climb_has_limits_of_its_own() -> None:
    _, times = spread(np.array([[0.0, 0, 0], [1, 0, 0]]), 0.3, LIMITS)
    assert times[-1] == pytest.approx(2 * np.sqrt(1 / 4))
    _, times = spread(np.array([[0.0, 0, 0], [0, 0, 9]]), 0.3, LIMITS)
    assert times[-1] == pytest.approx(9 / 2 + 2 / 2)


def test_a_corner_is_passed_as_fast_as_its_arc_allows() -> None:
    route = np.array([[0.0, 0, 0], [20, 0, 0], [20, 20, 0]])
    knots, times = spread(route, 0.3, LIMITS)
    corner = int(np.flatnonzero((knots == route[1]).all(axis=1))[0])
    radius = 0.3 / (np.sqrt(2) - 1)
    v = np.sqrt(4 * radius)
    assert times[corner] == pytest.approx(5 / 4 + (5 - v) / 4 + (20 - 25 / 8 - (25 - v**2) / 8) / 5)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), count=st.integers(2, 30), scale=st.sampled_from([0.01, 1.0, 1000.0]))
def test_knots_lie_on_the_legs_in_order_and_keep_the_speed(seed: int, count: int, scale: float) -> None:
    route = scale * np.random.default_rng(seed).normal(size=(count, 3))
    for knots, times in (spread(route, 0.3, LIMITS), evenly(route, np.linspace(0.1, 9, count - 1), 0.3, LIMITS)):
        assert (np.diff(times) > 0).all()
        most = MOST + MOST_EACH * (count - 1)
        assert len(times) <= most + count + 1
        assert np.diff(times).max() <= max(STEP, times[-1] / most) + 1e-9
        away = np.abs(knots[:, None] - route).max(axis=2).min(axis=1)
        at = np.flatnonzero(away < 1e-12 * scale)
        assert len(at) == count
        for first, last, start, end in zip(at[:-1], at[1:], route[:-1], route[1:], strict=True):
            share = (knots[first : last + 1] - start) @ (end - start) / ((end - start) @ (end - start))
            assert (np.diff(share) > 0).all()
            np.testing.assert_allclose(
                knots[first : last + 1], start + share[:, None] * (end - start), atol=1e-9 * scale
            )
    knots, times = spread(route, 0.3, LIMITS)
    speeds = np.linalg.norm(np.diff(knots, axis=0), axis=1) / np.diff(times)
    assert speeds.max() <= 5 * (1 + 1e-9)


def test_a_millimetre_between_long_legs_takes_no_time_of_its_own() -> None:
    route = np.array([[0.0, 0, 5], [0.001, 0, 5], [100, 0, 5], [100.001, 0.001, 5], [200, 50, 5]])
    _, times = spread(route, 0.3, LIMITS)
    assert np.diff(times).min() >= 0.3 / 5 / 2 - 1e-12
    _, plain = spread(np.array([[0.0, 0, 5], [100, 0, 5], [200, 50, 5]]), 0.3, LIMITS)
    assert times[-1] <= plain[-1] + 3
