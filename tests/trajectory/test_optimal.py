from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from crosstrack.errors import InputError
from crosstrack.trajectory.conditions import Conditions, conditions
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.effort import curvature, grams
from crosstrack.trajectory.times.effort_descent import effort
from crosstrack.trajectory.times.guided_descent import guided_effort
from crosstrack.trajectory.times.optimal import least_effort, least_effort_and_time
from crosstrack.trajectory.times.timing import square_root, trapezoid
from crosstrack.types import Array

UNIT = {2: 12.0, 3: 720.0, 4: 100800.0}
"""effort of one leg of 1 m in 1 s, from rest to rest"""


def route(seed: int, segments: int = 8) -> Array:
    return np.random.default_rng(seed).uniform(0, 20, (segments + 1, 3))


def times(durations: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(durations)])


def cost(waypoints: Array, durations: Array, s: int, guide: float | None = None, start: object = None) -> float:
    """Return the effort by the curve itself."""
    curve = minimum(waypoints, times(durations), s, guide=guide, start=start)  # type: ignore[arg-type] # given as lists
    extra = 0.0 if guide is None else Guide(chord(waypoints, durations), guide).error(curve)
    return curve.cost(s) + extra


def asked(waypoints: Array, durations: Array, s: int, guide: float | None = None, start: object = None) -> Conditions:
    return conditions(waypoints, times(durations), s, start, None, None, False, guide)  # type: ignore[arg-type] # as above


def difference(f: Callable[[Array], Array | float], y: Array) -> Array:
    """Return the derivatives by central differences of fourth order, first axis by y."""
    rows = []
    for e in np.eye(len(y)) * 2e-3:
        near = np.asarray(f(y + e)) - np.asarray(f(y - e))
        far = np.asarray(f(y + 2 * e)) - np.asarray(f(y - 2 * e))
        rows.append((8 * near - far) / 12 / 2e-3)
    return np.array(rows)


CASES = [
    (2, None, None),
    (3, None, None),
    (4, None, None),
    (3, 200.0, None),
    (4, 50.0, None),
    (3, 5.0, [[2, -1, 0], [np.nan, np.nan, np.nan]]),
]


@pytest.mark.parametrize(("s", "guide", "start"), CASES)
def test_slopes_of_the_effort_by_the_durations(s: int, guide: float | None, start: object) -> None:
    points = route(4, 5)
    y = np.log(np.random.default_rng(s).uniform(0.7, 4.0, 5))
    here = effort(asked(points, np.exp(y), s, guide, start), np.exp(y))
    assert here.value == pytest.approx(cost(points, np.exp(y), s, guide, start), rel=1e-10)
    numeric = difference(lambda y: cost(points, np.exp(y), s, guide, start), y)
    np.testing.assert_allclose(here.slopes, numeric, atol=1e-6 * np.abs(numeric).max())


@pytest.mark.parametrize("s", [2, 3, 4])
def test_slopes_are_the_hamiltonian_anywhere_on_the_segment(s: int) -> None:
    points, durations = route(5, 4), np.array([1.0, 2.5, 0.8, 3.0])
    curve = minimum(points, times(durations), s)
    here = effort(asked(points, durations, s), durations)
    for where in (0.0, 0.3, 0.9):
        t = curve.knots[:-1] + where * durations
        expected = (curve(t, s) ** 2).sum(axis=1)
        for k in range(1, s):
            expected += 2 * (-1) ** k * (curve(t, s + k) * curve(t, s - k)).sum(axis=1)
        np.testing.assert_allclose(here.slopes / durations, -expected, rtol=1e-7)


@pytest.mark.parametrize(("s", "guide", "start"), CASES)
def test_curvature_of_the_effort_by_the_durations(s: int, guide: float | None, start: object) -> None:
    points, price = route(6, 4), 3.0
    y = np.log([1.0, 2.5, 0.8, 3.0])
    conditions = asked(points, np.exp(y), s, guide, start)
    here = effort(conditions, np.exp(y))
    free = 3 * (s - 1)
    band = np.zeros((2 * free + 1, 5 * (free + 1) - 1))
    pinned = ~np.isnan(conditions.knots[:, :, 0])
    curvature(here.durations, here.knots, pinned, conditions.weights, price, grams(s), band)
    size = band.shape[1]
    lower = np.array([[band[i - j, j] if 0 <= i - j < len(band) else 0.0 for j in range(size)] for i in range(size)])
    whole = 2 * (lower + np.tril(lower, -1).T)
    places = np.arange(4) * (free + 1) + free
    others = np.setdiff1d(np.arange(size), places)
    cross = whole[np.ix_(others, places)]
    reduced = whole[np.ix_(places, places)] - cross.T @ np.linalg.solve(whole[np.ix_(others, others)], cross)
    numeric = difference(lambda y: effort(conditions, np.exp(y)).slopes + price * np.exp(y), y)
    np.testing.assert_allclose(reduced, numeric, atol=1e-6 * np.abs(numeric).max())


@pytest.mark.parametrize(("s", "guide", "seed"), [(3, None, 0), (4, None, 1), (4, None, 2), (3, None, 3), (3, 20.0, 4)])
def test_no_general_optimiser_finds_less_effort(s: int, guide: float | None, seed: int) -> None:
    points = route(seed, 8 if guide is None else 4)
    begin = trapezoid(points, MotionLimits(speed=4.0, acceleration=5.0))
    total = begin.sum()
    found = least_effort(points, total, s, guide=guide)
    assert found.converged
    assert found.curve.duration == pytest.approx(total, rel=1e-12)
    scale = cost(points, begin, s, guide)
    for spread in (0.0, 0.4):
        shares = begin * np.exp(np.random.default_rng(seed).normal(0, spread, len(begin)))
        done = minimize(
            lambda d: cost(points, d, s, guide) / scale,
            shares * total / shares.sum(),
            method="SLSQP",
            bounds=[(0.05, total)] * len(begin),
            constraints={"type": "eq", "fun": lambda d: d.sum() - total},
            options={"ftol": 1e-12, "maxiter": 300},
        )
        assert done.success
        assert found.objective / scale == pytest.approx(done.fun, rel=1e-6)
        assert found.objective / scale <= done.fun * (1 + 1e-9)


@pytest.mark.parametrize("s", [2, 3, 4])
def test_one_leg_has_its_closed_form(s: int) -> None:
    leg, price = np.array([[1.0, 2.0, 3.0], [3.0, 5.0, 9.0]]), 2.5
    whole = least_effort(leg, 3.0, s)
    assert whole.objective == pytest.approx(UNIT[s] * 49.0 / 3.0 ** (2 * s - 1), rel=1e-12)
    found = least_effort_and_time(leg, price, s)
    expected = ((2 * s - 1) * UNIT[s] * 49.0 / price) ** (1 / (2 * s))
    assert found.curve.duration == pytest.approx(expected, rel=1e-6)
    assert found.objective == pytest.approx(found.curve.cost(s) + price * expected, rel=1e-12)


@pytest.mark.parametrize("s", [3, 4])
def test_effort_and_time_is_least_effort_in_its_time(s: int) -> None:
    points, price = route(7), 4.0
    found = least_effort_and_time(points, price, s)
    assert found.converged
    # in α times the time the effort is α^(1-2s) times as much, so the best pace has (2s - 1) J = ρ ΣT
    assert (2 * s - 1) * found.curve.cost(s) == pytest.approx(price * found.curve.duration, rel=1e-7)
    again = least_effort(points, found.curve.duration, s)
    np.testing.assert_allclose(again.curve.durations, found.curve.durations, rtol=1e-5)


def test_symmetries_of_least_effort() -> None:
    points = route(8)
    durations = least_effort(points, 20.0, 4).curve.durations
    np.testing.assert_allclose(least_effort(points[::-1], 20.0, 4).curve.durations[::-1], durations, rtol=1e-5)
    np.testing.assert_allclose(least_effort(3 * points - 7, 20.0, 4).curve.durations, durations, rtol=1e-5)
    np.testing.assert_allclose(least_effort(points, 60.0, 4).curve.durations, 3 * durations, rtol=1e-5)
    far = points + np.array([500_000.0, 5_000_000.0, 0.0])
    np.testing.assert_allclose(least_effort(far, 20.0, 4).curve.durations, durations, rtol=1e-5)


def test_hundreds_of_segments() -> None:
    points = route(9, 400)
    found = least_effort(points, 2000.0, 4)
    assert found.converged
    assert found.slope < 1e-6
    assert found.objective < 0.9 * cost(points, square_root(points, total=2000.0), 4)


def test_very_short_beside_very_long_legs() -> None:
    points = np.array([[0, 0, 0], [1e-3, 0, 0], [1000, 1, 0], [1000, 1, 0.01], [0, 0, 0]])
    found = least_effort(points, 60.0, 4)
    assert found.slope < 1e-4  # what rounding leaves of it, relative to the effort
    assert found.objective < 0.1 * cost(points, np.full(4, 15.0), 4)
    assert found.curve.duration == pytest.approx(60.0)


def test_start_velocity_and_velocities_at_waypoints_are_kept() -> None:
    points = route(10, 4)
    given = np.full((5, 3), np.nan)
    given[2] = [1.0, 2.0, 0.0]
    found = least_effort(points, 15.0, 3, start=[[3, 0, 0]], velocities=given)
    assert found.converged
    np.testing.assert_allclose(found.curve(0.0, 1), [3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(found.curve(found.curve.knots[2], 1), [1, 2, 0], atol=1e-9)
    plain = minimum(points, times(square_root(points, total=15.0)), 3, start=[[3, 0, 0]], velocities=given)
    assert found.objective < plain.cost(3)


def test_a_line_at_constant_speed_has_no_effort() -> None:
    free = [[np.nan, np.nan]]
    found = least_effort([[0, 0], [1, 1], [3, 3]], 3.0, 2, start=free, end=free)
    assert found.converged
    np.testing.assert_allclose(found.curve.durations, [1, 2], rtol=1e-6)


def test_what_cannot_be_optimised_is_told() -> None:
    with pytest.raises(InputError) as caught:
        least_effort([[0, 0], [1, 1], [1, 1]], 0.0)
    assert [problem.place for problem in caught.value.problems] == ["total", "waypoints[2]"]
    with pytest.raises(InputError, match="price"):
        least_effort_and_time([[0, 0], [1, 1]], np.nan)
    with pytest.raises(InputError, match="derivative: must be 2, 3 or 4"):
        least_effort([[0, 0], [1, 1]], 1.0, 5)
    free = [[np.nan] * 2] * 2
    with pytest.raises(InputError, match="undetermined"):
        least_effort([[0, 0], [1, 1]], 1.0, 3, start=free, end=free)


def moving(order: int) -> Guide:
    """Return a guide with a time of its own: a cubic in two pieces, continuous."""
    rng = np.random.default_rng(order)
    coefficients = rng.normal(0, 1, (2, 4, 3))
    spans = np.array([3.3, 9.0])
    coefficients[1, 0] = (coefficients[0] * spans[0] ** np.arange(4)[:, None]).sum(axis=0)
    return Guide(PiecewisePolynomial(spans, coefficients), np.array([2.0, 0.5, 1.0, 3.0]), order)


@pytest.mark.parametrize(("s", "order"), [(2, 2), (3, 0), (3, 1), (4, 2)])
def test_slopes_with_a_guide_that_has_its_own_time(s: int, order: int) -> None:
    points, guide = route(11, 4), moving(order)
    y = np.log([1.0, 2.5, 0.8, 3.0])

    def total(y: Array) -> float:
        curve = minimum(points, times(np.exp(y)), s, guide=guide)
        return curve.cost(s) + guide.error(curve)

    asked = conditions(points, times(np.exp(y)), s, None, None, None, False, guide)
    here = guided_effort(asked, [guide])
    assert here.value == pytest.approx(total(y), rel=1e-12)
    numeric = difference(total, y)
    np.testing.assert_allclose(here.slopes, numeric, atol=1e-6 * np.abs(numeric).max())


def test_a_guide_in_time_draws_the_waypoints_times_to_it() -> None:
    points = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    spans = np.array([2.0, 5.0, 3.0])
    guide = Guide(chord(points, spans), 1e3)
    found = least_effort(points, 10.0, 3, guide=guide)
    assert found.converged
    even = least_effort(points, 10.0, 3)
    assert np.abs(found.curve.durations - spans).max() < 0.5 * np.abs(even.curve.durations - spans).max()
    assert found.objective < even.curve.cost(3) + guide.error(even.curve)
    assert found.curve.duration == pytest.approx(10.0)


def test_a_loop_of_least_effort() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0]])
    found = least_effort(square, 8.0, 3, periodic=True)
    assert found.converged
    np.testing.assert_allclose(found.curve.durations, np.full(4, 2.0), rtol=1e-6)
    corners = np.array([[0.0, 0.0], [6.0, 0.0], [7.0, 4.0], [0.0, 2.0], [0.0, 0.0]])
    found = least_effort(corners, 8.0, 3, periodic=True)
    for order in (1, 2):
        np.testing.assert_allclose(found.curve(0.0, order), found.curve(8.0, order), atol=1e-8)
    # wherever a loop begins it is the same one
    turned = np.concatenate([corners[1:-1], corners[:2]])
    again = least_effort(turned, 8.0, 3, periodic=True)
    np.testing.assert_allclose(np.roll(again.curve.durations, 1), found.curve.durations, rtol=1e-4)
    assert again.objective == pytest.approx(found.objective, rel=1e-9)
    priced = least_effort_and_time(corners, 5.0, 3, periodic=True)
    assert 5 * priced.curve.cost(3) == pytest.approx(5.0 * priced.curve.duration, rel=1e-4)
