from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import Infeasible, InputError
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.weights.choose import choose_weights, resting
from crosstrack.types import Array

WAYPOINTS = np.array([[0, 0], [1, 2], [2, -1], [4, 8], [5, 2]], float)
TIMES = np.array([0, 0.5400960100096803, 1.3039071123489652, 3.5307800095935304, 5])
"""of the tutorial"""


def strayed(curve: PiecewisePolynomial, points: Array) -> Array:
    """Return the largest distance of 500 samples of every piece from its chord, (N,)."""
    share = np.linspace(0, 1, 500)
    found = []
    for i, (start, end) in enumerate(pairwise(points)):
        powers = (share * curve.durations[i])[:, None] ** np.arange(curve.degree + 1)
        off = powers @ curve.coefficients[i] - start
        along = np.clip(off @ (end - start) / ((end - start) @ (end - start)), 0, 1)
        found.append(np.linalg.norm(off - along[:, None] * (end - start), axis=1).max())
    return np.array(found)


def fastest(curve: PiecewisePolynomial, order: int) -> float:
    """Return the largest norm of a derivative among 20000 samples."""
    t = np.linspace(0, curve.duration, 20000)
    return float(np.linalg.norm(curve(t, order), axis=1).max())


@pytest.mark.parametrize("derivative", [2, 3, 4])
@pytest.mark.parametrize("most", [3.0, 0.5, 0.2, 0.05, 1e-5])
def test_no_segment_strays_farther_than_allowed(derivative: int, most: float) -> None:
    chosen = choose_weights(WAYPOINTS, TIMES, derivative, max_deviation=most)
    assert chosen.deviations.max() <= most
    assert (strayed(chosen.curve, WAYPOINTS) <= chosen.deviations + 1e-9).all()
    assert chosen.peaks["deviation"] == chosen.deviations.max()
    np.testing.assert_allclose(chosen.curve(TIMES), WAYPOINTS, atol=1e-9)


@pytest.mark.parametrize("derivative", [2, 3, 4])
def test_the_guide_makes_the_trajectory_again(derivative: int) -> None:
    chosen = choose_weights(WAYPOINTS, TIMES, derivative, max_deviation=0.15)
    again = minimum(WAYPOINTS, TIMES, derivative, guide=chosen.guide)
    t = np.linspace(0, TIMES[-1], 300)
    np.testing.assert_allclose(again(t), chosen.curve(t), atol=1e-8)


def test_what_keeps_near_by_itself_needs_no_guide() -> None:
    chosen = choose_weights(WAYPOINTS, TIMES, 3, max_deviation=3)
    assert not chosen.weights.any()
    np.testing.assert_allclose(chosen.curve.coefficients, minimum(WAYPOINTS, TIMES, 3).coefficients, rtol=1e-9)


@pytest.mark.parametrize("most", [1.0, 0.5, 0.3])
def test_it_is_smoother_than_with_one_weight_for_all(most: float) -> None:
    costs = [
        curve.cost(3)
        for weight in np.geomspace(1e-2, 1e9, 150)
        if strayed(curve := minimum(WAYPOINTS, TIMES, 3, guide=weight), WAYPOINTS).max() <= most
    ]
    assert choose_weights(WAYPOINTS, TIMES, 3, max_deviation=most).curve.cost(3) <= min(costs)


def test_limits_hold_at_every_instant() -> None:
    limits = MotionLimits(speed=8, acceleration=38)
    chosen = choose_weights(WAYPOINTS, TIMES, 3, max_deviation=0.3, limits=limits)
    assert fastest(chosen.curve, 1) <= chosen.peaks["speed"] <= 8
    assert fastest(chosen.curve, 2) <= chosen.peaks["acceleration"] <= 38
    assert strayed(chosen.curve, WAYPOINTS).max() <= 0.3


def test_it_finds_weights_where_neither_guide_along_the_chords_has_any() -> None:
    limits = MotionLimits(speed=6.8)
    chosen = choose_weights(WAYPOINTS, TIMES, 3, max_deviation=0.3, limits=limits)
    assert chosen.kind == "least excess"
    assert fastest(chosen.curve, 1) <= 6.8
    assert strayed(chosen.curve, WAYPOINTS).max() <= 0.3


@pytest.mark.parametrize(
    ("most", "limits", "start", "culprit"),
    [
        (0.3, MotionLimits(speed=4), None, "speed on segment"),
        (0.3, MotionLimits(acceleration=10), None, "acceleration on segment"),
        (0.05, None, [[5, -5]], "deviation on segment 0"),
    ],
)
def test_what_nothing_can_meet_is_proven_and_blamed(
    most: float, limits: MotionLimits | None, start: list[list[float]] | None, culprit: str
) -> None:
    with pytest.raises(Infeasible, match="proven: no trajectory") as raised:
        choose_weights(WAYPOINTS, TIMES, 3, max_deviation=most, limits=limits, start=start)
    assert culprit in str(raised.value)


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(InputError) as raised:
        choose_weights(WAYPOINTS, TIMES, 3, max_deviation=-1, limits=MotionLimits(speed=0, speed_vertical=1))
    told = {problem.place for problem in raised.value.problems}
    assert told == {"max_deviation", "limits.speed", "limits.speed_vertical"}


def test_huge_coordinates_change_nothing() -> None:
    here = choose_weights(WAYPOINTS, TIMES, 3, max_deviation=0.3)
    there = choose_weights(WAYPOINTS + [5.0e5, 5.0e6], TIMES, 3, max_deviation=0.3)
    np.testing.assert_allclose(there.deviations, here.deviations, atol=0.03)
    assert there.deviations.max() <= 0.3


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), derivative=st.sampled_from([2, 3, 4]), dimensions=st.sampled_from([2, 3]))
def test_random_routes_are_kept_to(seed: int, derivative: int, dimensions: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.uniform(-5, 5, (rng.integers(2, 9), dimensions)), axis=0)
    times = np.concatenate([[0], np.cumsum(rng.uniform(0.3, 3, len(points) - 1))])
    most = 10 ** rng.uniform(-4, 0)
    chosen = choose_weights(points, times, derivative, max_deviation=most)
    assert strayed(chosen.curve, points).max() <= chosen.deviations.max() + 1e-9
    assert chosen.deviations.max() <= most


@pytest.mark.parametrize("derivative", [2, 3, 4])
def test_the_resting_motion_rests_on_straight_lines(derivative: int) -> None:
    curve = resting(WAYPOINTS, np.diff(TIMES), derivative)
    for order in range(1, derivative):
        np.testing.assert_allclose(curve(TIMES, order), 0, atol=1e-9)
    np.testing.assert_allclose(curve(TIMES), WAYPOINTS, atol=1e-12)
    assert strayed(curve, WAYPOINTS).max() < 1e-12
