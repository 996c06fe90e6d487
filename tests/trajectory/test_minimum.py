"""The closed form against exact arithmetic, dense quadratic programs and its own optimality."""

import json
from math import perm
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from exact import coefficients as exact_coefficients
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.trajectory.batch import minimum_batch
from crosstrack.trajectory.constrained.corridor import Boxes, Polytopes, Tube
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

NAN = np.nan
SEEDS = st.integers(0, 10**6)
ORDERS = st.sampled_from([2, 3, 4])
STILL = PiecewisePolynomial(np.array([1.0]), np.zeros((1, 1, 2)))
NONE: Any = None
TEXT: Any = "9"
FRACTION: Any = 1.0


def problem(seed: int, segments: int = 6, dimensions: int = 3) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(segments + 1, dimensions)) * 5, np.cumsum(np.r_[0.0, rng.uniform(0.3, 3, segments)])


def jumps(curve: PiecewisePolynomial, order: int) -> float:
    """Return the largest jump of a derivative at the inner knots relative to its largest value at the knots."""
    terms = range(order, curve.degree + 1)
    spans = curve.durations[:-1, None]
    before = sum(perm(k, order) * curve.coefficients[:-1, k] * spans ** (k - order) for k in terms)
    after = perm(order, order) * curve.coefficients[1:, order]
    return float(np.abs(before - after).max() / np.abs(after).max())


def relative_error(curve: PiecewisePolynomial, exact: Array) -> float:
    """Return the largest error of the motion within a segment, relative to its size, of a curve in one dimension."""
    scale = curve.durations[:, None] ** np.arange(curve.degree + 1)
    error = np.abs((curve.coefficients[:, :, 0] - exact) * scale)[:, 1:].max(axis=1)
    return float((error / np.abs(exact * scale)[:, 1:].max(axis=1)).max())


@given(SEEDS, ORDERS, st.integers(1, 5))
@settings(max_examples=25)
def test_it_is_the_curve_that_exact_arithmetic_finds(seed: int, s: int, segments: int) -> None:
    waypoints, times = problem(seed, segments, 1)
    curve = minimum(waypoints, times, s)
    exact = exact_coefficients(waypoints[:, 0].tolist(), curve.durations.tolist(), s)
    assert relative_error(curve, exact) < 1e-10


def test_the_optimum_of_the_tutorial_is_found() -> None:
    """Against 60-digit arithmetic."""
    file = Path(__file__).parents[1] / "data" / "minimum_jerk_optima.json"
    case = json.loads(file.read_text(encoding="utf-8"))["cases"][0]
    curve = minimum(case["waypoints"], case["times"], 3)
    assert curve.cost(3) == pytest.approx(case["objective"], rel=1e-12)


@pytest.mark.parametrize("s", [2, 3, 4])
@pytest.mark.parametrize(
    "durations",
    [
        (1.0, 1e-3, 1.0),
        (1e-3, 1000.0, 1e-3, 1000.0),
        (1000.0, 1e-3, 1e-3, 1e-3, 900.0),
        (100.0, 1e-3, 50.0),
        (1e-3, 1e-3, 1000.0, 1000.0),
    ],
)
def test_a_millisecond_beside_a_quarter_of_an_hour(s: int, durations: tuple[float, ...]) -> None:
    waypoints = np.array([0.0, 1, 1.5, -2, 3, 1])[: len(durations) + 1]
    curve = minimum(waypoints[:, None], np.cumsum([0, *durations]), s)
    exact = exact_coefficients(waypoints.tolist(), curve.durations.tolist(), s)
    # Forces at a knot differ by up to 1e42 here: what is left is the condition of the problem itself.
    assert relative_error(curve, exact) < (1e-6 if s == 4 else 1e-10)


@given(SEEDS, ORDERS)
def test_the_derivatives_are_continuous(seed: int, s: int) -> None:
    waypoints, times = problem(seed, 12)
    curve = minimum(waypoints, times, s)
    np.testing.assert_allclose(curve(curve.knots), waypoints, atol=1e-9)
    assert max(jumps(curve, order) for order in range(2 * s - 1)) < 1e-8
    for order in range(1, s):
        np.testing.assert_allclose(curve(np.array([0.0, curve.duration]), order), 0.0, atol=1e-7)


@pytest.mark.parametrize("s", [2, 3, 4])
@pytest.mark.parametrize("segments", [10_000, 100_000])
def test_very_many_segments(s: int, segments: int) -> None:
    rng = np.random.default_rng(s)
    waypoints = np.cumsum(rng.normal(size=(segments + 1, 3)), axis=0)
    curve = minimum(waypoints, np.cumsum(np.r_[0.0, rng.uniform(0.5, 2, segments)]), s)
    assert max(jumps(curve, order) for order in range(2 * s - 1)) < 1e-9


@given(SEEDS, ORDERS)
@settings(max_examples=20)
def test_any_change_costs_more(seed: int, s: int) -> None:
    """The cost along any admissible variation is a parabola with its vertex at the optimum."""
    rng = np.random.default_rng(seed)
    waypoints, times = problem(seed)
    ends: dict[str, Any] = {"start": rng.normal(size=(s - 1, 3)), "end": [[NAN] * 3, *rng.normal(size=(s - 2, 3))]}
    curve_of = PiecewisePolynomial(np.array([1.0, 2.5, 1.0]), rng.normal(size=(3, 5, 3)))
    guides = [Guide(curve_of, rng.uniform(0, 5, 6), order) for order in range(3)]
    curve = minimum(waypoints, times, s, guide=guides, **ends)
    free_end: dict[str, Any] = {"start": None, "end": rng.normal(size=(1, 3))}
    change = minimum(np.zeros((7, 3)), times, s, velocities=_inner(rng), **free_end)

    def cost(step: float) -> float:
        moved = PiecewisePolynomial(curve.durations, curve.coefficients + step * change.coefficients)
        return moved.cost(s) + sum(guide.error(moved) for guide in guides)

    up, down, here = cost(1.0), cost(-1.0), cost(0.0)
    assert up > here
    assert abs(up - down) < 1e-7 * (up + down)


def _inner(rng: np.random.Generator) -> Array:
    return np.array(np.vstack([np.zeros(3), rng.normal(size=(5, 3)), np.full(3, NAN)]))


@given(SEEDS, ORDERS)
def test_the_chord_as_a_guide_is_the_number_as_a_guide(seed: int, s: int) -> None:
    waypoints, times = problem(seed)
    weights = np.random.default_rng(seed).uniform(0, 1000, 6)
    given_as_curve = minimum(waypoints, times, s, guide=Guide(chord(waypoints, np.diff(times)), weights))
    constant = minimum(waypoints, times, s, guide=3.0)
    same = minimum(waypoints, times, s, guide=[Guide(chord(waypoints, np.diff(times)), 1.0)] * 3)
    np.testing.assert_allclose(constant.coefficients, same.coefficients, rtol=1e-7, atol=1e-7)
    assert max(jumps(given_as_curve, order) for order in range(s)) < 1e-9


def test_a_heavy_velocity_guide_is_followed_whatever_it_integrates_to() -> None:
    wanted = PiecewisePolynomial(np.array([10.0]), np.array([[[1.0], [0.2]]]))  # 1 + 0.2 t
    curve = minimum([[7.0], [27.0]], [0, 10], 3, start=[[NAN], [NAN]], end=[[NAN], [NAN]], guide=Guide(wanted, 1e6, 1))
    times = np.linspace(0, 10, 20)
    np.testing.assert_allclose(curve(times, 1)[:, 0], 1 + 0.2 * times, atol=1e-6)
    assert curve(0.0)[0] == pytest.approx(7)


def test_a_guide_beyond_its_end_is_held() -> None:
    short = PiecewisePolynomial(np.array([1.0]), np.array([[[0.0], [2.0]]]))
    long = PiecewisePolynomial(np.array([1.0, 9.0]), np.array([[[0.0], [2.0]], [[2.0], [0.0]]]))
    a, b = (minimum([[0.0], [1.0], [2.0]], [0, 3, 8], 3, guide=Guide(curve, 5.0)) for curve in (short, long))
    np.testing.assert_allclose(a.coefficients, b.coefficients, rtol=1e-12, atol=1e-12)


@given(SEEDS, ORDERS)
def test_straight_polynomials_are_reproduced(seed: int, s: int) -> None:
    """A polynomial of degree s - 1 costs nothing, so that free ends find it from enough waypoints."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(np.r_[0.0, rng.uniform(0.5, 2, 7)])
    coefficients = rng.normal(size=s)
    waypoints = np.polynomial.Polynomial(coefficients)(times)[:, None]
    free = np.full((s - 1, 1), NAN)
    curve = minimum(waypoints, times, s, start=free, end=free)
    between = np.linspace(0, times[-1], 30)
    wanted = np.polynomial.Polynomial(coefficients)(between)
    np.testing.assert_allclose(curve(between)[:, 0], wanted, atol=1e-7 * (1 + np.abs(wanted).max()))


@given(SEEDS, ORDERS)
def test_velocities_given_are_flown_and_those_of_the_optimum_change_nothing(seed: int, s: int) -> None:
    waypoints, times = problem(seed)
    curve = minimum(waypoints, times, s)
    velocities = curve(curve.knots, 1)
    velocities[[1, 3]] = NAN
    again = minimum(waypoints, times, s, velocities=velocities, start=np.zeros((s - 1, 3)), end=np.zeros((s - 1, 3)))
    np.testing.assert_allclose(again.coefficients, curve.coefficients, atol=1e-7 * np.abs(curve.coefficients).max())
    velocities[2] += 1
    moved = minimum(waypoints, times, s, velocities=velocities)
    np.testing.assert_allclose(moved(moved.knots[2], 1), velocities[2], atol=1e-9)
    assert moved.cost(s) > curve.cost(s)


@given(SEEDS, ORDERS, st.sampled_from([None, 20.0]))
def test_a_loop_has_no_seam(seed: int, s: int, guide: float | None) -> None:
    waypoints, times = problem(seed)
    waypoints[-1] = waypoints[0]
    curve = minimum(waypoints, times, s, periodic=True, guide=guide)
    both = np.array([0.0, curve.duration])
    for order in range(2 * s - 1 if guide is None else s):
        first, last = curve(both, order)
        np.testing.assert_allclose(first, last, atol=1e-7 * np.abs(curve(curve.knots, order)).max())
    # Begun at another waypoint it is the same loop.
    turned = minimum(
        np.vstack([waypoints[2:], waypoints[1:3]]),
        np.cumsum(np.r_[0.0, np.roll(np.diff(times), -2)]),
        s,
        periodic=True,
        guide=guide,
    )
    after = np.linspace(0, curve.duration - times[2] - 1e-9, 20)
    np.testing.assert_allclose(turned(after), curve(times[2] + after), atol=1e-6)


@pytest.mark.parametrize("s", [2, 3, 4])
def test_a_loop_of_uneven_durations_is_the_same_wherever_it_begins(s: int) -> None:
    points, durations = np.array([[0.0, 0], [1, 1], [2, 0]]), np.array([1e-3, 1000.0, 1.0])
    costs = []
    for k in range(3):
        there = np.roll(points, -k, axis=0)
        times = np.cumsum(np.r_[0.0, np.roll(durations, -k)])
        costs.append(minimum(np.vstack([there, there[:1]]), times, s, periodic=True).cost(s))
    np.testing.assert_allclose(costs, min(costs), rtol=1e-2)


@given(SEEDS, ORDERS, st.sets(st.integers(0, 2), min_size=1))
def test_no_other_ends_of_a_guided_loop_cost_less(seed: int, s: int, orders: set[int]) -> None:
    waypoints, times = problem(seed)
    waypoints[-1] = waypoints[0]
    rng = np.random.default_rng(seed)
    line = chord(waypoints + rng.normal(size=waypoints.shape), np.diff(times))
    guides = [Guide(line.derivative(k), rng.uniform(0, 50, 6) * rng.integers(0, 2, 6), k) for k in orders]

    def cost(curve: PiecewisePolynomial) -> float:
        return curve.cost(s) + sum(guide.error(curve) for guide in guides)

    loop = minimum(waypoints, times, s, periodic=True, guide=guides)
    ends = np.array([loop(0.0, k) for k in range(1, s)])
    for _ in range(4):
        other = ends + 1e-2 * rng.normal(size=ends.shape) * (1.0 + np.abs(ends))
        assert cost(minimum(waypoints, times, s, start=other, end=other, guide=guides)) > cost(loop)


@given(SEEDS, ORDERS)
def test_it_does_not_matter_where_in_the_world_or_when(seed: int, s: int) -> None:
    waypoints, times = problem(seed)
    here = minimum(waypoints, times, s)
    there = minimum(waypoints + [4.5e6, 6e5, 300.0], times + 2.0**20, s)
    np.testing.assert_allclose(there.coefficients[:, 1:], here.coefficients[:, 1:], rtol=1e-5, atol=1e-5)


@given(SEEDS, ORDERS, st.floats(0.1, 10))
def test_slower_by_a_factor_costs_its_power_less(seed: int, s: int, factor: float) -> None:
    waypoints, times = problem(seed)
    fast, slow = minimum(waypoints, times, s), minimum(waypoints, factor * times, s)
    assert slow.cost(s) == pytest.approx(fast.cost(s) * factor ** (1 - 2 * s), rel=1e-7)


def test_repeated_and_collinear_waypoints_and_out_and_back() -> None:
    hover = minimum([[1.0, 2.0]] * 3, [0, 1, 2], 4)
    np.testing.assert_array_equal(hover(np.linspace(0, 2, 9)), np.full((9, 2), [1.0, 2.0]))
    line = minimum([[0, 0], [1, 1], [3, 3]], [0, 1, 3], 3)
    between = line(np.linspace(0, 3, 50))
    np.testing.assert_allclose(between[:, 0], between[:, 1], atol=1e-12)
    back = minimum([[0.0], [5.0], [0.0]], [0, 2, 4], 3)
    np.testing.assert_allclose(back(np.linspace(0, 2, 20)), back(4 - np.linspace(0, 2, 20)), atol=1e-12)
    assert back(2.0, 1)[0] == pytest.approx(0, abs=1e-12)


def test_one_segment_from_rest_to_rest_is_the_known_polynomial() -> None:
    curve = minimum([[0.0], [1.0]], [0, 1], 3)
    np.testing.assert_allclose(curve.coefficients[0, :, 0], [0, 0, 0, 10, -15, 6], atol=1e-12)  # Flash and Hogan 1985
    assert curve.cost(3) == pytest.approx(720)
    snap = minimum([[0.0], [1.0]], [0, 1], 4)
    np.testing.assert_allclose(snap.coefficients[0, :, 0], [0, 0, 0, 0, 35, -84, 70, -20], atol=1e-12)


@given(SEEDS, ORDERS)
def test_the_batch_is_each_of_its_trajectories(seed: int, s: int) -> None:
    rng = np.random.default_rng(seed)
    waypoints = rng.normal(size=(5, 7, 3)) + 100
    times = np.cumsum(np.c_[np.zeros(5), rng.uniform(0.1, 3, (5, 6))], axis=1)
    times[2, 1:] += 3e4 * (s == 4)  # one far out of proportion
    start, end = rng.normal(size=(5, s - 1, 3)), np.full((1, 3), NAN)
    out = minimum_batch(waypoints, times, s, start=start, end=end)
    for k in range(5):
        alone = minimum(waypoints[k], times[k], s, start=start[k], end=end)
        np.testing.assert_allclose(out[k], alone.coefficients, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "options", "said"),
    [
        (([[0, 0], [1, NAN]], [0, 1]), {}, "waypoints[1, 1]: must be a finite number, found nan"),
        (([[0, 0], [1, 1]], [0, 0]), {}, "times[1]: must be after times[0], 0 s, found 0 s"),
        (([[0, 0], [1, 1]], [0, 1, 2]), {}, "times: must be one for each of the 2 waypoints, found 3"),
        (([[0, 0]], [0]), {}, "waypoints: must be at least 2, found 1"),
        (([0, 1], [0, 1]), {}, "waypoints: must have the shape (n, d), found (2,)"),
        (([[0, 0], [1]], [0, 1]), {}, "waypoints: must be an array of numbers, all rows equally long"),
        (([[0, 0], [1, 1]], [0, 1], 5), {}, "derivative: must be 2, 3 or 4, found 5"),
        (([[0, 0], [1, 1]], [0, 1]), {"start": [[0, 0, 0]]}, "start: must have the shape (k, 2), found (1, 3)"),
        (([[0, 0], [1, 1]], [0, 1], 2), {"end": [[0, 0]] * 2}, "end: must have at most 1 rows"),
        (([[0, 0], [1, 1]], [0, 1]), {"end": [[0, NAN]]}, "end[0]: must be finite, or NaN as a whole"),
        (([[0, 0], [1, 1]], [0, 1]), {"velocities": [[0, 0]]}, "velocities: must be one for each of the 2"),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": -1.0}, "guide: must be a weight of 0 or more, or guides, found -1.0"),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": "auto"}, "guide: must be a weight of 0 or more, or guides"),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": [1.0]}, "guide: must be a weight of 0 or more, or guides, found [1.0]"),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": {}}, "guide: must be a weight of 0 or more, or guides, found {}"),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": Guide(STILL, TEXT)}, "guide[0].weight: must be one or 1 numbers"),
        (
            ([[0, 0], [1, 1]], [0, 1]),
            {"guide": Guide(STILL, 1.0, FRACTION)},
            "guide[0].order: must be 0, 1 or 2, found 1.0",
        ),
        (([[0, 0], [1, 1]], [0, 1]), {"guide": Guide(NONE)}, "guide[0].curve: must be a PiecewisePolynomial"),
        (([[0, 0], [1, 1]], [0, 1], 3.0), {}, "derivative: must be 2, 3 or 4, found 3.0"),
        (([[0, 0], [1, 1]], [0, 1], np.array([3, 4])), {}, "derivative: must be 2, 3 or 4, found array([3, 4])"),
        (([[0, 0], [1, 1]], [0, 1]), {"limits": MotionLimits(speed=TEXT)}, "limits.speed: must be above 0 and finite"),
        (([[0, 0], [1, 1]], [0, 1]), {"corridor": Tube(TEXT)}, "corridor.radius: must be one or 1 numbers above 0"),
        (([[0, 0], [1, 1]], [0, 1]), {"corridor": Boxes([[1], [1, 2]], [[2, 2]])}, "corridor.low: must have the shape"),
        (([[0, 0], [1, 1]], [0, 1]), {"corridor": Polytopes([NONE])}, "corridor.faces[0]: must be a pair of A (m, 2)"),
        (([[0, 0], [1, 1]], [0, 1]), {"periodic": True}, "waypoints[1]: must be the first again"),
        (([[0, 0], [1, 1]], [0, 1e-300]), {}, "times: are too short or too long"),
        (
            ([[0, 0], [1, 1]], [0, 1]),
            {"start": [[NAN, NAN]] * 2, "end": [[NAN, NAN]] * 2},
            "waypoints: leave the trajectory undetermined: 2 waypoints and 0 derivatives",
        ),
    ],
)
def test_bad_input_is_named(arguments: tuple[Any, ...], options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        minimum(*arguments, **options)
    assert said in str(caught.value)


def test_everything_wrong_is_said_at_once() -> None:
    curve = PiecewisePolynomial(np.array([1.0]), np.full((1, 1, 3), NAN))
    with pytest.raises(InputError) as caught:
        minimum([[0, 0], [1, 1]], [0, 1], start=[[1, 2, 3]], end=[[1]], guide=Guide(curve, -1.0, 7))
    places = [problem.place for problem in caught.value.problems]
    assert places == ["start", "end", "guide[0].order", "guide[0].weight", "guide[0].curve", "guide[0].curve"]


@pytest.mark.parametrize(
    ("waypoints", "times", "said"),
    [
        (np.zeros((2, 3)), np.zeros((2, 3)), "waypoints: must have the shape (m, n, d)"),
        (np.zeros((2, 3, 1)), np.zeros((2, 2)), "times: must have the shape (2, 3), found (2, 2)"),
        (np.zeros((2, 3, 1)), np.zeros((2, 3)), "times[0, 1]: must be after 0 s, found 0 s"),
        ([[[0, 0], [1]]], [[0, 1]], "waypoints: must have the shape (m, n, d)"),
        (np.zeros((1, 2, 1)), "soon", "times: must have the shape (1, 2), found ()"),
        (np.ones((1, 3, 1)) * [[0.0], [1.0], [2.0]], [[0, 1e-300, 1]], "times[0]: are too short or too long"),
    ],
)
def test_bad_batches_are_named(waypoints: Any, times: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        minimum_batch(waypoints, times)
    assert said in str(caught.value)
