"""Certified deviations from polylines, against exact distances and known ones."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from curves import SHIFTS, exact, gap_squared, random_curve
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.trajectory.certified.polyline_distance import deviation_peaks, largest_deviation
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

INSTANTS = [float(u) for u in np.linspace(0, 1, 9)]


def along(curve: PiecewisePolynomial, seed: int, count: int) -> Array:
    """Corners near the curve, some of them repeated."""
    rng = np.random.default_rng(seed)
    near = curve.coefficients[:, 0][rng.integers(0, len(curve.durations), count)]
    points = near + rng.normal(size=near.shape) * 10 ** rng.uniform(-1, 2)
    points[rng.integers(1, count)] = points[0]
    return np.repeat(points, rng.integers(1, 3, count), axis=0)


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(1, 3), st.sampled_from(SHIFTS))
def test_no_exact_distance_from_the_polyline_is_above_the_bound(
    seed: int, degree: int, dimensions: int, shift: float
) -> None:
    curve = random_curve(seed, degree, dimensions, pieces=3, shift=shift)
    points = along(curve, seed, 5)
    found = largest_deviation(curve, points)
    scale = float(np.abs(points - points[0]).max()) + found.value
    assert found.attained <= found.value <= found.attained + 1e-6 + 1e-11 * scale
    best = Fraction(0)
    at = float((found.time - curve.knots[found.piece]) / curve.durations[found.piece])
    for piece, u in [(piece, u) for piece in range(3) for u in INSTANTS] + [(found.piece, min(at, 1.0))]:
        point = exact(curve, piece, u)
        best = max(best, min(gap_squared(point, a, b) for a, b in pairwise(points)))
    assert best <= Fraction(found.value) ** 2
    assert float(best) ** 0.5 >= found.attained - 1e-5 - 1e-9 * scale  # its time is where it is attained


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(1, 3), st.sampled_from(SHIFTS), st.booleans())
def test_no_exact_distance_from_its_leg_is_above_that_of_a_piece(
    seed: int, degree: int, dimensions: int, shift: float, chords: bool
) -> None:
    curve = random_curve(seed, degree, dimensions, pieces=3, shift=shift)
    points = None if chords else curve.coefficients[0, 0] + np.random.default_rng(seed).normal(size=(4, dimensions))
    found = deviation_peaks(curve, points)
    legs = np.concatenate([curve.coefficients[:, 0], curve(curve.duration)[None]]) if points is None else points
    assert (found.attained <= found.bound).all()
    assert (found.bound <= found.attained * (1 + 1e-10) + 2e-6).all()
    for piece in range(3):
        at = float((found.time[piece] - curve.knots[piece]) / curve.durations[piece])
        for u in [*INSTANTS, min(at, 1.0)]:
            gap = gap_squared(exact(curve, piece, u), legs[piece], legs[piece + 1])
            assert gap <= Fraction(float(found.bound[piece])) ** 2


def parabola(height: float) -> PiecewisePolynomial:
    """From (-1, 0) to (1, 0) over the top (0, height) in 2 s."""
    return PiecewisePolynomial(np.array([2.0]), np.array([[[-1.0, 0.0], [1.0, 2 * height], [0.0, -height]]]))


def test_the_top_of_an_arc_is_farthest_from_its_chord() -> None:
    found = largest_deviation(parabola(0.5), np.array([[-1.0, 0.0], [1.0, 0.0]]))
    assert found.value == pytest.approx(0.5, abs=1e-6)
    assert found.time == pytest.approx(1.0)


def test_half_way_between_two_legs_is_the_farthest_from_both() -> None:
    # straight across a corridor whose walls are the legs: the ridge of the distance is between them
    points = np.array([[0.0, 0.0], [0.0, 10.0], [4.0, 10.0], [4.0, 0.0]])
    curve = PiecewisePolynomial(np.array([8.0]), np.array([[[0.0, 1.0], [0.5, 0.0]]]))
    found = largest_deviation(curve, points)
    assert found.value == pytest.approx(2.0, abs=1e-6)
    assert found.time == pytest.approx(4.0, abs=1e-5)


@pytest.mark.parametrize("points", [[[3.0, 4.0]], [[3.0, 4.0], [3.0, 4.0]]])
def test_a_polyline_without_length_is_a_point(points: list[list[float]]) -> None:
    curve = PiecewisePolynomial(np.array([1.0]), np.array([[[0.0, 0.0], [3.0, 4.0]]]))
    assert largest_deviation(curve, np.array(points)).value == pytest.approx(5.0, abs=1e-6)


def test_overshooting_counts_from_the_end_of_the_leg() -> None:
    curve = PiecewisePolynomial(np.array([1.0, 1.0]), np.array([[[0.0, 0.0], [4.0, 0.0]], [[4.0, 0.0], [-4.0, 3.0]]]))
    points = np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 0.0]])
    np.testing.assert_allclose(deviation_peaks(curve, points).bound, [2.0, 13**0.5], atol=1e-6)


def test_a_curve_on_its_route_does_not_deviate() -> None:
    knots = np.array([[0.0, 0, 0], [10, 0, 0], [10, 20, 0], [10, 20, 5]]) + 5.4e6
    blend = np.array([0, 0, 0, 10.0, -15, 6])
    curve = PiecewisePolynomial(
        np.ones(3), knots[:-1, None] * np.eye(6)[0][:, None] + np.diff(knots, axis=0)[:, None] * blend[:, None]
    )
    assert largest_deviation(curve, knots).value < 1.1e-6
    assert deviation_peaks(curve).bound.max() < 1.1e-6


def test_long_routes_are_searched_as_their_nearest_legs_tell() -> None:
    rng = np.random.default_rng(5)
    corners = np.cumsum(rng.normal(size=(300, 3)), axis=0) * 5
    unit = np.zeros((299, 5, 3))
    unit[:, 0], unit[:, 1] = corners[:-1], np.diff(corners, axis=0)
    bow = rng.normal(size=(299, 3))
    unit[:, 1] += bow
    unit[:, 2] -= bow
    curve = PiecewisePolynomial(np.ones(299), unit)
    samples = curve(np.linspace(0, 299, 20_001))
    starts, legs = corners[:-1], np.diff(corners, axis=0)
    worst = 0.0
    for point in samples:
        foot = np.clip(((point - starts) * legs).sum(axis=1) / (legs**2).sum(axis=1), 0, 1)
        worst = max(worst, float(np.linalg.norm(point - starts - foot[:, None] * legs, axis=1).min()))
    found = largest_deviation(curve, corners)
    assert worst <= found.value < worst + 1e-3
    assert found.value - found.attained < 2e-6


def test_without_numbers_nothing_is_certified() -> None:
    curve = parabola(np.nan)
    assert largest_deviation(curve, np.zeros((2, 2))).value == np.inf


@pytest.mark.parametrize("points", [np.zeros((3, 3)), np.zeros((0, 2)), np.zeros(2), np.full((2, 2), np.nan)])
def test_polylines_that_are_none_are_named(points: Array) -> None:
    curve = PiecewisePolynomial(np.array([2.0]), np.ones((1, 3, 2)))
    with pytest.raises(InputError, match="largest_deviation: 1 problem\n  points: must"):
        largest_deviation(curve, points)
