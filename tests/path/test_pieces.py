"""Lines and arcs: differential geometry, projection against brute force, and tracks that cross, close and turn back."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.path.pieces import Pieces
from crosstrack.path.polyline import Polyline
from crosstrack.path.rounded import rounded
from crosstrack.types import Array

coordinate = st.floats(-20, 20).map(lambda x: round(x, 3))
corners = st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=3, max_size=12).filter(
    lambda points: all(math.dist(a, b) > 0.5 for a, b in pairwise(points))
)


def smooth(points: object) -> Pieces:
    return rounded(np.array(points, float), tolerance=0.5, radius=2.0)


@given(corners, st.floats(0.01, 0.99))
def test_tangent_and_curvature_are_derivatives(points: list[tuple[float, float, float]], where: float) -> None:
    path, h = smooth(points), 1e-6
    k = int(where * len(path.lengths))
    s = path.knots[k] + 0.5 * path.lengths[k]
    h = min(h, 0.1 * path.lengths[k])
    tangent = (path(s + h) - path(s - h)) / (2 * h)
    bend = (path(s + h, 1) - path(s - h, 1)) / (2 * h)
    np.testing.assert_allclose(path(s, 1), tangent, atol=1e-6)
    assert np.linalg.norm(path(s, 1)) == pytest.approx(1)
    np.testing.assert_allclose(path(s, 2), bend, atol=1e-4 * (1 + path.curvatures[k] ** 2))


@given(corners)
def test_pieces_join_without_gaps(points: list[tuple[float, float, float]]) -> None:
    path = smooth(points)
    before, after = path(path.knots[1:-1] - 1e-10), path(path.knots[1:-1])
    np.testing.assert_allclose(before, after, atol=1e-7)
    np.testing.assert_allclose(path(0.0), points[0], atol=1e-9)
    np.testing.assert_allclose(path(path.length), points[-1], atol=1e-7)


@given(corners, st.tuples(coordinate, coordinate, coordinate), st.floats(0, 1), st.floats(0.1, 30))
def test_projection_is_the_closest_point_within_reach(
    points: list[tuple[float, float, float]], point: tuple[float, float, float], where: float, reach: float
) -> None:
    path = smooth(points)
    near = where * path.length
    s = path.project(np.array(point), near, reach)
    samples = np.linspace(near, min(near + reach, path.length), 4001)
    distances = np.linalg.norm(path(samples) - point, axis=1)
    assert near - 1e-9 <= s <= near + reach + 1e-9
    spacing = samples[1] - samples[0]
    assert np.linalg.norm(path(s) - point) <= distances.min() + 1e-9
    assert distances.min() <= np.linalg.norm(path(s) - point) + spacing + 1e-9


def test_outside_the_ends_the_ends_answer() -> None:
    path = Polyline([[0, 0, 0], [3, 4, 0]])
    np.testing.assert_allclose(path(np.array([-1.0, 6.0])), [[0, 0, 0], [3, 4, 0]])
    assert path.length == pytest.approx(5)


def track(path: Pieces, offset: float = 0.0, step: float = 0.1) -> Array:
    s = np.arange(0, path.length, step)
    side = np.cross(path(s, 1), [0, 0, 1])
    return path(s) + offset * side


def test_a_crossing_does_not_jump() -> None:
    t = np.linspace(0, 2 * np.pi, 200)
    eight = Polyline(np.column_stack([10 * np.sin(t), 10 * np.sin(t) * np.cos(t)]))
    progress, error = eight.trace(track(eight, 0.05))
    np.testing.assert_allclose(progress, np.arange(len(progress)) * 0.1, atol=0.1)
    assert error.max() < 0.06


def test_a_closed_path_is_flown_once_around() -> None:
    square = Polyline([[0, 0], [10, 0], [10, 10], [0, 10]], closed=True)
    assert square.length == pytest.approx(40)
    progress, error = square.trace(track(square))
    assert progress[-1] == pytest.approx(39.9, abs=0.01)
    assert error.max() < 1e-9


def test_legs_flown_to_and_fro_are_told_apart() -> None:
    path = Polyline([[0, 0], [10, 0], [0, 0], [20, 0]])
    progress, error = path.trace(track(path))
    np.testing.assert_allclose(progress, np.arange(len(progress)) * 0.1, atol=1e-9)
    assert error.max() < 1e-9


def test_a_cut_corner_is_followed_around() -> None:
    path = Polyline([[0, 0], [10, 0], [10, 10]])
    cut = np.array([[x, 0, 0] for x in np.arange(0, 9, 0.1)] + [[9 + d, d, 0] for d in np.arange(0, 1, 0.07)])
    straight = np.array([[10, y, 0] for y in np.arange(1, 10.01, 0.1)])
    progress, error = path.trace(np.vstack([cut, straight]))
    assert progress[-1] == pytest.approx(20, abs=0.11)
    assert error.max() == pytest.approx(0.5, abs=0.04)
    assert (np.diff(progress) >= 0).all()


def test_a_hairpin_cut_short_is_followed_around() -> None:
    """The way round the tip is long for an error that is small."""
    path = Polyline([[0, 0], [10, 0], [0, 1.5], [0, 10]])
    out = [[x, 0, 0] for x in np.arange(0, 7, 0.05)]
    back = [[x, 0.15 * (10 - x), 0] for x in np.arange(7, 0, -0.05)]
    progress, error = path.trace(np.array(out + back))
    assert progress[-1] > 19
    assert error.max() < 1.5


def test_duplicate_and_dense_points_change_nothing() -> None:
    plain = Polyline([[0, 0], [10, 0], [10, 10]])
    dense = Polyline([[0, 0], [0, 0], *([x / 100, 0] for x in range(1001)), [10, 0], [10, 10], [10, 10]])
    s = np.linspace(0, 20, 57)
    np.testing.assert_allclose(plain(s), dense(s), atol=1e-9)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([[0, 0], [0, 0]], "fewer than two distinct"),
        ([[0, 0, 0, 0], [1, 1, 1, 1]], "shape"),
        ([[0, 0], [math.nan, 1]], r"points\[1\]"),
        (["a", "b"], "not an array"),
        ([[0, 0], [1]], "not an array"),
    ],
)
def test_bad_points_are_named(points: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Polyline(points)
