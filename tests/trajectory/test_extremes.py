"""Certified extremes of curves, against exact values, roots of polynomials and known motions."""

from fractions import Fraction

import numpy as np
import pytest
from curves import SHIFTS, exact, norm_squared, random_curve
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.trajectory.certified.extremes import axis_range, halfspace_peaks, largest_norm, norm_peaks
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

INSTANTS = [float(u) for u in np.linspace(0, 1, 12)]


def near(u: float) -> list[float]:
    """Unit times around one, and all along."""
    return [*INSTANTS, *(min(max(u + step, 0.0), 1.0) for step in (-1e-3, -1e-5, 0.0, 1e-5, 1e-3))]


def unit_time(curve: PiecewisePolynomial, piece: int, time: float) -> float:
    return float((time - curve.knots[piece]) / curve.durations[piece])


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(1, 4), st.integers(0, 4), st.sampled_from(SHIFTS))
def test_no_exact_norm_is_above_its_bound(seed: int, degree: int, dimensions: int, order: int, shift: float) -> None:
    curve = random_curve(seed, degree, dimensions, shift=shift)
    found = norm_peaks(curve, order)
    for piece in range(len(curve.durations)):
        bound = Fraction(float(found.bound[piece])) ** 2
        for u in near(unit_time(curve, piece, found.time[piece])):
            assert norm_squared(exact(curve, piece, u, order)) <= bound


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 13), st.integers(1, 3), st.integers(0, 3))
def test_bounds_are_tight(seed: int, degree: int, dimensions: int, order: int) -> None:
    curve = random_curve(seed, degree, dimensions)
    found = norm_peaks(curve, order)
    slack = 1e-8 if degree > 9 else 2e-9  # rounding grows with the condition of the Bernstein basis
    assert (found.attained <= found.bound).all()
    assert (found.bound <= found.attained * (1 + slack)).all()
    largest = largest_norm(curve, order)
    assert largest.value == found.bound.max()
    assert largest.attained == found.attained[largest.piece] == found.attained.max()


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.sampled_from(SHIFTS))
def test_attained_values_are_attained(seed: int, shift: float) -> None:
    curve = random_curve(seed, shift=shift, spread=1.0)
    for order in (1, 2, 3):
        top = largest_norm(curve, order)
        u = unit_time(curve, top.piece, top.time)
        assert norm_squared(exact(curve, top.piece, u, order)) == pytest.approx(top.attained**2, rel=1e-6)


@pytest.mark.parametrize("duration", [1e-3, 1.0, 1e3])
def test_minimum_jerk_from_rest_to_rest_has_its_known_peaks(duration: float) -> None:
    # p = d (10 x³ - 15 x⁴ + 6 x⁵), Flash and Hogan 1985: speed 15/8 d/T at half time, acceleration 10/√3 d/T²
    unit = np.outer([0, 0, 0, 10, -15, 6], [3.0, 4.0, 12.0])
    curve = PiecewisePolynomial(np.array([duration]), unit[None] / duration ** np.arange(6)[:, None])
    speed, acceleration, jerk = (largest_norm(curve, order) for order in (1, 2, 3))
    assert speed.value == pytest.approx(15 / 8 * 13 / duration, rel=1e-9)
    assert speed.time == pytest.approx(duration / 2)
    assert acceleration.value == pytest.approx(10 / 3**0.5 * 13 / duration**2, rel=1e-9)
    assert jerk.value == pytest.approx(60 * 13 / duration**3, rel=1e-9)
    assert largest_norm(curve, 1, [0, 1]).value == pytest.approx(15 / 8 * 5 / duration, rel=1e-9)
    assert largest_norm(curve, 1, [2]).value == pytest.approx(15 / 8 * 12 / duration, rel=1e-9)


def test_derivatives_above_the_degree_are_zero() -> None:
    curve = random_curve(1, degree=2)
    assert norm_peaks(curve, 5).bound.tolist() == [0.0] * 4
    assert [side.greatest.value for side in axis_range(curve, 3)] == [0.0] * 3


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.integers(1, 9), st.integers(0, 3), st.sampled_from(SHIFTS))
def test_no_exact_coordinate_is_outside_its_range(seed: int, degree: int, order: int, shift: float) -> None:
    curve = random_curve(seed, degree, 2, shift=shift)
    for axis, side in enumerate(axis_range(curve, order)):
        low, high = Fraction(side.least.value), Fraction(side.greatest.value)
        assert side.least.value <= side.least.attained <= side.greatest.attained <= side.greatest.value
        for piece in range(len(curve.durations)):
            for u in INSTANTS:
                assert low <= exact(curve, piece, u, order)[axis] <= high


def extremes_by_roots(powers: Array, duration: float) -> tuple[float, float]:
    polynomial = np.polynomial.Polynomial(powers)
    roots = polynomial.deriv().roots()
    inside = np.clip(roots.real[np.abs(roots.imag) < 1e-6 * duration], 0, duration)
    values = polynomial(np.concatenate([[0.0, duration], inside]))
    return float(values.min()), float(values.max())


@given(st.integers(0, 10**6), st.integers(2, 7))
def test_ranges_agree_with_the_roots_of_the_derivative(seed: int, degree: int) -> None:
    curve = random_curve(seed, degree, 2, pieces=2, spread=1.0)
    for axis, side in enumerate(axis_range(curve)):
        expected = np.array(
            [extremes_by_roots(c, d) for c, d in zip(curve.coefficients[:, :, axis], curve.durations, strict=True)]
        )
        scale = float(np.abs(expected).max()) + 1e-3
        assert side.least.value == pytest.approx(expected[:, 0].min(), abs=1e-7 * scale)
        assert side.greatest.value == pytest.approx(expected[:, 1].max(), abs=1e-7 * scale)


@settings(max_examples=20)
@given(st.integers(0, 10**6), st.integers(0, 2), st.sampled_from(SHIFTS))
def test_nothing_is_farther_outside_a_half_space_than_certified(seed: int, order: int, shift: float) -> None:
    rng = np.random.default_rng(seed)
    curve = random_curve(seed, shift=shift)
    pieces, normals = rng.integers(0, 4, 6), rng.normal(size=(6, 3))
    offsets = (normals * curve.coefficients[pieces, 0]).sum(axis=1) if order == 0 else rng.normal(size=6)
    found = halfspace_peaks(curve, order, pieces, normals, offsets)
    assert (found.piece == pieces).all()
    for row, piece in enumerate(pieces):
        sides = [Fraction(float(n)) for n in normals[row]]
        for u in near(unit_time(curve, piece, found.time[row])):
            values = exact(curve, int(piece), u, order)
            outside = sum((n * x for n, x in zip(sides, values, strict=True)), Fraction(0))
            assert outside - Fraction(float(offsets[row])) <= Fraction(float(found.bound[row]))


def test_half_spaces_tell_how_far_outside_the_worst_point_is() -> None:
    # x = 4 u (1 - u), so x <= 0.75 is exceeded by 0.25 at half time
    curve = PiecewisePolynomial(np.array([2.0]), np.array([[[0.0, 1.0], [2.0, 0.0], [-1.0, 0.0]]]))
    found = halfspace_peaks(curve, 0, np.array([0, 0]), np.array([[1.0, 0.0], [0.0, -1.0]]), np.array([0.75, 0.0]))
    np.testing.assert_allclose(found.bound, [0.25, -1.0], atol=1e-8)
    assert found.time[0] == pytest.approx(1.0)


@pytest.mark.parametrize("axes", [[2], [-1], [], [0.5]])
def test_axes_and_orders_that_a_curve_does_not_have_are_named(axes: list[int]) -> None:
    curve = PiecewisePolynomial(np.array([2.0]), np.ones((1, 3, 2)))
    with pytest.raises(InputError, match=r"largest_norm: 2 problems\n  order: .*\n  axes: must be from 0 to 1"):
        largest_norm(curve, -1, axes)
    with pytest.raises(InputError, match="axis_range: 1 problem"):
        axis_range(curve, -1)
