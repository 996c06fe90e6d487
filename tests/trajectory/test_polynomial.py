"""Piecewise polynomials against numpy's and scipy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from crosstrack.errors import InputError
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array


def random_curve(seed: int, pieces: int = 4, degree: int = 5, dimensions: int = 3) -> PiecewisePolynomial:
    rng = np.random.default_rng(seed)
    return PiecewisePolynomial(rng.uniform(0.2, 3, pieces), rng.normal(size=(pieces, degree + 1, dimensions)))


@given(st.integers(0, 10**6), st.integers(0, 8), st.integers(0, 9))
def test_it_evaluates_as_numpy_does(seed: int, degree: int, order: int) -> None:
    curve = random_curve(seed, degree=degree)
    for piece, start in enumerate(curve.knots[:-1]):
        local = np.random.default_rng(seed).uniform(0, curve.durations[piece], 5)
        for d in range(3):
            wanted = np.polynomial.Polynomial(curve.coefficients[piece, :, d]).deriv(order)(local)
            scale = 1 + np.abs(wanted).max()
            np.testing.assert_allclose(curve(start + local, order)[:, d], wanted, atol=1e-9 * scale)


def test_shapes_follow_the_times_and_the_ends_answer_outside() -> None:
    curve = random_curve(3)
    assert curve(0.5).shape == (3,)
    assert curve(np.zeros((2, 5)), 1).shape == (2, 5, 3)
    np.testing.assert_array_equal(curve(np.array([-1.0, curve.duration + 9])), curve(np.array([0.0, curve.duration])))
    assert curve.degree == 5
    assert curve.duration == pytest.approx(curve.durations.sum())


def test_at_a_knot_the_later_piece_answers() -> None:
    step = PiecewisePolynomial(np.array([1.0, 1.0]), np.array([[[0.0]], [[1.0]]]))
    assert step(np.array([0.999, 1.0, 2.0])).ravel().tolist() == [0.0, 1.0, 1.0]


@given(st.integers(0, 10**6), st.integers(0, 7))
def test_derivative_is_a_curve_of_its_own(seed: int, order: int) -> None:
    curve = random_curve(seed)
    times = np.random.default_rng(seed).uniform(0, curve.duration, 20)
    np.testing.assert_allclose(curve.derivative(order)(times), curve(times, order), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("order", [0, 1, 3, 5, 6])
def test_cost_is_the_integral_of_the_square(order: int) -> None:
    curve = random_curve(7)

    def square(t: float) -> float:
        value: Array = curve(t, order)
        return float(value @ value)

    wanted = sum(quad(square, a, b - 1e-12)[0] for a, b in zip(curve.knots, curve.knots[1:], strict=False))
    assert curve.cost(order) == pytest.approx(wanted, rel=1e-8, abs=1e-12)


def test_a_negative_order_is_an_error() -> None:
    with pytest.raises(InputError, match="order: must be 0 or more, found -1"):
        random_curve(1)(0.0, -1)
