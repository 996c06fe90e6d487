"""The certified maximum of one polynomial, against its critical points and against known ones."""

from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.trajectory.certified.bernstein import DEEPEST, basis
from crosstrack.trajectory.certified.peak import peak
from crosstrack.types import Array


def enclose(control: Array, floor: float = -np.inf, tolerance: float = 1e-10) -> tuple[float, float, float]:
    control = np.asarray(control, float)
    scale = float(np.abs(control).max())
    return peak(control, floor, tolerance * scale, 0.0, np.empty((DEEPEST + 2, len(control) + 2)))


def bernstein(polynomial: np.polynomial.Polynomial) -> Array:
    powers = np.asarray(polynomial.coef, float)
    return np.asarray(basis(len(powers) - 1) @ powers)


def largest_by_roots(control: Array) -> float:
    """Largest value at the ends and at the roots of the derivative, which are the eigenvalues of its companion."""
    n = len(control) - 1
    powers = [comb(n, j) * sum((-1) ** (j - i) * comb(j, i) * control[i] for i in range(j + 1)) for j in range(n + 1)]
    polynomial = np.polynomial.Polynomial(powers)
    roots = polynomial.deriv().roots()
    inside = np.clip(roots.real[np.abs(roots.imag) < 1e-6], 0, 1)
    return float(np.max(polynomial(np.concatenate([[0.0, 1.0], inside]))))


@given(st.integers(0, 10**6), st.integers(1, 13))
def test_the_maximum_lies_between_value_and_bound(seed: int, degree: int) -> None:
    control = np.random.default_rng(seed).normal(size=degree + 1)
    scale = float(np.abs(control).max())
    bound, value, u = enclose(control)
    rounding = 1e-15 * 4**degree * scale  # of the powers that the oracle needs
    assert value - rounding <= largest_by_roots(control) <= bound + rounding
    assert value <= bound <= value + 1.1e-10 * scale
    assert 0 <= u <= 1


@pytest.mark.parametrize("degree", [2, 5, 8, 12, 14])
def test_chebyshev_polynomials_reach_one_many_times(degree: int) -> None:
    equal = np.polynomial.Chebyshev.basis(degree, domain=[0, 1]).convert(kind=np.polynomial.Polynomial)
    bound, value, _ = enclose(bernstein(equal), tolerance=1e-12)
    rounding = 1e-12 + 1e-15 * 6**degree
    assert abs(value - 1) < rounding
    assert value <= bound < value + rounding


@pytest.mark.parametrize(
    ("control", "expected", "where"),
    [
        ([2.0], 2.0, None),
        ([1.0, 1.0, 1.0, 1.0], 1.0, None),
        ([0.0, 3.0], 3.0, 1.0),
        ([3.0, 0.0], 3.0, 0.0),
        ([0.0, 1.0, 0.0], 0.5, 0.5),
        ([-1.0, -2.0, -4.0], -1.0, 0.0),
        ([0.0, 0.0, 0.0], 0.0, None),
        ([1e-300, 0.0, -1e-300], 1e-300, 0.0),
        ([0.0, 1e200, 0.0], 5e199, 0.5),
    ],
)
def test_simple_maxima(control: list[float], expected: float, where: float | None) -> None:
    bound, value, u = enclose(np.array(control))
    assert value == pytest.approx(expected, rel=1e-12)
    assert bound == pytest.approx(expected, rel=1e-9)
    assert bound >= expected
    assert where is None or u == pytest.approx(where)


@pytest.mark.parametrize("power", [2, 4, 6, 8])
def test_flat_tops_are_found(power: int) -> None:
    top = 1.0 / 3.0
    falling = 1.0 - np.polynomial.Polynomial([-top, 1.0]) ** power
    bound, value, u = enclose(bernstein(falling))
    assert value <= bound <= 1 + 1e-9
    assert value > 1 - 1e-9
    assert abs(u - top) ** power < 1e-9


def test_a_narrow_peak_between_samples_is_not_missed() -> None:
    # (4 u (1 - u))^13 squeezed: high only within a few percent of its place
    control = np.zeros(27)
    control[13] = 1.0
    bound, value, u = enclose(control)
    assert u == pytest.approx(0.5, abs=1e-6)
    assert value == pytest.approx(comb(26, 13) / 2**26, rel=1e-9)
    assert value <= bound < value + 1e-9


@given(st.integers(0, 10**6))
def test_below_a_floor_only_that_is_shown(seed: int) -> None:
    control = np.random.default_rng(seed).normal(size=9)
    _, top, _ = enclose(control)
    bound, value, _ = enclose(control, floor=top + 1.0)
    assert top <= bound <= top + 1.0 + 1e-9
    assert value <= top + 1e-9


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [0, 1, 3])
def test_without_numbers_nothing_is_certified(bad: float, place: int) -> None:
    control = np.ones(4)
    control[place] = bad
    assert peak(control, -np.inf, 1e-9, 0.0, np.empty((DEEPEST + 2, 6)))[0] == np.inf
