"""Rounded corners: within the tolerance, tangent, and of the radius that geometry gives."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.path.polyline import Polyline
from crosstrack.path.rounded import rounded
from crosstrack.types import Array


def farthest(points: Array, corners: Array) -> float:
    """Return the greatest distance from points to a polyline, by brute force over its legs."""
    a, b = corners[:-1], corners[1:]
    along = b - a
    u = np.clip(((points[:, None] - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return float(np.linalg.norm(points[:, None] - a - u[..., None] * along, axis=-1).min(1).max())


@given(
    st.lists(st.tuples(*[st.floats(-15, 15)] * 3), min_size=3, max_size=15).filter(
        lambda points: all(math.dist(a, b) > 1e-3 for a, b in pairwise(points))
    ),
    st.floats(0.01, 2),
    st.floats(0.05, 10),
)
def test_it_stays_within_the_tolerance(
    points: list[tuple[float, float, float]], tolerance: float, radius: float
) -> None:
    corners = np.array(points)
    path = rounded(corners, tolerance, radius)
    samples = path(np.linspace(0, path.length, 3000))
    assert farthest(samples, corners) <= tolerance * (1 + 1e-9) + 1e-9


def test_a_right_angle_gets_the_arc_of_the_formula() -> None:
    path = rounded(np.array([[0, 0, 0], [20, 0, 0], [20, 20, 0]], float), tolerance=0.3, radius=50.0)
    radius = 0.9 * 0.3 / (math.sqrt(2) - 1)
    assert path.curvatures.tolist() == pytest.approx([0, 1 / radius, 0])
    assert path.length == pytest.approx(40 - 2 * radius + math.pi / 2 * radius)
    middle = path(path.length / 2)
    assert np.linalg.norm(middle - [20, 0, 0]) == pytest.approx(0.27)


def test_no_corner_is_cut_more_than_its_speed_needs() -> None:
    path = rounded(np.array([[0, 0, 0], [20, 0, 0], [20, 20, 0]], float), tolerance=5.0, radius=1.5)
    assert 1 / path.curvatures.max() == pytest.approx(1.5)


def test_gentle_turns_are_as_wide_as_a_tenth_of_the_tolerance_allows() -> None:
    path = rounded(np.array([[0, 0, 0], [20, 0, 0], [40, 1, 0]], float), tolerance=0.5, radius=1.5)
    corner = path(path.project(np.array([20.0, 0, 0]), 0.0, path.length))
    assert np.linalg.norm(corner - [20, 0, 0]) == pytest.approx(0.05, rel=1e-6)


def test_dense_points_on_a_circle_become_a_circle_as_wide() -> None:
    angle = np.linspace(0, 2 * math.pi, 2000)
    path = rounded(np.column_stack([10 * np.cos(angle), 10 * np.sin(angle), 0 * angle]), 0.3, 100.0)
    assert 1 / path.curvatures.max() > 9
    assert path.length == pytest.approx(20 * math.pi, rel=0.01)


@pytest.mark.parametrize("points", [23, 41, 81, 97, 161])
def test_even_points_on_a_circle_bend_evenly(points: int) -> None:
    """Dropping some of them would make the curvature come and go."""
    angle = np.linspace(0, 2 * math.pi, points)
    path = rounded(np.column_stack([8 * np.cos(angle), 8 * np.sin(angle), 0 * angle]), 0.3, 100.0)
    bent = path.curvatures[1:-1]
    np.testing.assert_allclose(bent[bent > 0], 1 / 8, rtol=0.02)
    assert path.lengths[1:-1][bent == 0].sum() < 0.02 * path.length


def test_noise_on_a_straight_line_makes_no_corners() -> None:
    rng = np.random.default_rng(0)
    x = np.arange(0, 50, 0.05)
    path = rounded(np.column_stack([x, rng.uniform(-0.01, 0.01, (len(x), 2))]), tolerance=0.3, radius=3.0)
    assert len(path.lengths) == 1


def test_a_turn_on_the_spot_stays_sharp() -> None:
    path = rounded(np.array([[0, 0, 0], [10, 0, 0], [0, 0, 0], [20, 0, 0]], float), 0.3, 3.0)
    assert path.length == pytest.approx(40)
    np.testing.assert_allclose(path(10.0), [10, 0, 0])


def test_a_loop_within_the_tolerance_is_not_lost() -> None:
    corners = Polyline([[0, 0], [0.01, 0], [0.01, 0.01], [0, 0]]).points
    assert rounded(corners, tolerance=1.0, radius=1.0).length > 0
