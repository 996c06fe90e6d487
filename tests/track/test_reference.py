"""Trajectories sampled for the loop, against the trajectories themselves."""

import numpy as np
import pytest

from crosstrack.track.reference import AHEAD, motion, reference
from crosstrack.trajectory.flatness.yaw import Faced, along_velocity
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial

POINTS = np.array([[0.0, 0, 10], [12, 3, 11], [18, 14, 12], [5, 20, 10], [-6, 8, 9]])
CURVE = minimum(POINTS, np.array([0.0, 2.5, 5.0, 7.5, 11.0]), 4)


@pytest.mark.parametrize(("order", "bound"), [(0, 1e-10), (1, 1e-8), (2, 1e-5), (3, 0.01)])
def test_it_is_the_trajectory(order: int, bound: float) -> None:
    stretch = reference(CURVE, 0.3, 1.0)
    times = np.random.default_rng(1).uniform(1.0, 5.8, 400)
    found = np.array([motion(stretch.rows, t - 1.0)[3 * order : 3 * order + 3] for t in times])
    np.testing.assert_allclose(found, CURVE(times, order), atol=bound * np.abs(CURVE(times, order)).max())


def test_it_rests_before_and_after() -> None:
    moving = PiecewisePolynomial(np.array([1.0]), np.array([[[0.0, 0, 5], [4.0, 0, 0], [1.0, 0, 0]]]))
    stretch = reference(moving, 0.7, -1.0)
    for since, place in ((0.5, [0, 0, 5]), (3.0, [5, 0, 5])):
        found = motion(stretch.rows, since)
        np.testing.assert_allclose(found[:3], place, atol=1e-12)
        np.testing.assert_array_equal(found[3:15], 0)
        assert found[15:] == (0.7, 0)


def test_it_turns_where_the_trajectory_says_where_to_look() -> None:
    yaw = along_velocity(CURVE)
    stretch = reference(Faced(CURVE, yaw), 0.0, 3.0)
    for t in (3.2, 4.7):
        found = motion(stretch.rows, t - 3.0)
        np.testing.assert_allclose(found[15:], [yaw(t), yaw(t, 1)], atol=1e-3)


def test_another_stretch_is_taken_before_this_one_ends() -> None:
    stretch = reference(CURVE, 0.0)
    assert stretch.covering(2.0) is stretch
    late = stretch.covering(9.0)
    assert late.begin <= 9.0
    for t in (9.0, 9.0 + AHEAD):
        np.testing.assert_allclose(motion(late.rows, t - late.begin)[:3], CURVE(t), atol=1e-9)
