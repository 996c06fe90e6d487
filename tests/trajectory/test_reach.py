from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from crosstrack.trajectory.conditions import conditions
from crosstrack.trajectory.limits import Bound, MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.weights.excess import deviation, excesses
from crosstrack.trajectory.weights.reach import Reach, least_excess
from crosstrack.types import Array


def reached(points: Array, times: Array, s: int, allowed: Sequence[Bound], start: Array | None = None) -> Reach:
    asked = conditions(points, times, s, start, None, None, False, None)
    return least_excess(asked, points, allowed, minimum(points, times, s, start=start))


@pytest.mark.parametrize(("s", "peak"), [(2, 1.5), (3, 1.875), (4, 2.1875)])
def test_a_motion_from_rest_to_rest_has_one_peak(s: int, peak: float) -> None:
    allowed = [deviation(0.5), *MotionLimits(speed=1).bounds(2)]
    found = reached(np.array([[0.0, 0], [6, 0]]), np.array([0.0, 2]), s, allowed)
    assert found.at_least == pytest.approx(3 * peak, rel=0.02)
    assert found.at_least <= 3 * peak <= found.at_most
    assert found.binding[0][:2] == ("speed", 0)


def monomials(t: Array, order: int, terms: int) -> Array:
    """Return the derivatives of 1, t, t², ... at times (n,), (n, terms)."""
    rows = np.zeros((len(t), terms))
    for power in range(order, terms):
        rows[:, power] = np.prod(np.arange(power, power - order, -1)) * t ** (power - order)
    return rows


def on_a_grid(heights: Array, times: Array, s: int, most: float, speed: float) -> float:
    """Return the least excess on one axis held at 60 instants of every segment: a linear program in monomials."""
    terms, pieces = 2 * s, len(times) - 1
    spans, size = np.diff(times), 2 * s * (len(times) - 1)
    equal: list[Array] = []
    values: list[float] = []
    above: list[Array] = []
    below: list[Array] = []
    for i, span in enumerate(spans):
        for end, height in ((0.0, heights[i]), (span, heights[i + 1])):
            row = np.zeros(size)
            row[terms * i : terms * (i + 1)] = monomials(np.array([end]), 0, terms)[0]
            equal, values = [*equal, row], [*values, height]
        t = np.linspace(0, span, 60)
        low, high = sorted(heights[i : i + 2])
        for order, bounds in ((0, (high, -low, most)), (1, (0.0, 0.0, speed))):
            for side, level in ((1, bounds[0]), (-1, bounds[1])):
                rows = np.zeros((len(t), size + 1))
                rows[:, terms * i : terms * (i + 1)] = side * monomials(t, order, terms)
                rows[:, -1] = -bounds[2]
                above, below = [*above, rows], [*below, np.full(len(t), level)]
    for order in range(1, s):
        for i in range(pieces + 1):
            row = np.zeros(size)
            if i < pieces:
                row[terms * i : terms * (i + 1)] = monomials(np.zeros(1), order, terms)[0]
            if i > 0:
                row[terms * (i - 1) : terms * i] -= monomials(spans[i - 1 : i], order, terms)[0]
            equal, values = [*equal, row], [*values, 0.0]
    matrix = np.column_stack([np.array(equal), np.zeros(len(equal))])
    cost = np.append(np.zeros(size), 1.0)
    found = linprog(cost, np.concatenate(above), np.concatenate(below), matrix, values, bounds=(None, None))
    return float(found.fun)


@pytest.mark.parametrize("s", [2, 3])
@pytest.mark.parametrize(("most", "speed"), [(0.1, 1.5), (1.0, 1.2), (0.5, 3.0)])
def test_it_agrees_with_a_linear_program_on_a_fine_grid(s: int, most: float, speed: float) -> None:
    heights, times = np.array([0.0, 1.0, 0.4, 2.0]), np.array([0.0, 1.0, 1.8, 3.5])
    allowed = [deviation(most), *MotionLimits(speed=speed).bounds(1)]
    found = reached(heights[:, None], times, s, allowed)
    oracle = on_a_grid(heights, times, s, most, speed)
    assert found.at_least <= oracle * 1.005
    assert oracle <= found.at_most + 1e-9
    assert found.at_most <= max(1.0, 1.011 * found.at_least) or found.at_least > 1


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), s=st.sampled_from([2, 3]))
def test_no_trajectory_does_better(seed: int, s: int) -> None:
    rng = np.random.default_rng(seed)
    points, times = rng.uniform(-3, 3, (4, 2)), np.cumsum(rng.uniform(0.5, 2, 4))
    allowed = [deviation(0.1), *MotionLimits(speed=1.0).bounds(2)]
    found = reached(points, times, s, allowed)
    for _ in range(20):
        guided = minimum(points, times, s, guide=10 ** rng.uniform(-2, 6), velocities=tried(points, times, rng))
        assert excesses(allowed, guided, points).max() >= found.at_least


def tried(points: Array, times: Array, rng: np.random.Generator) -> Array:
    """Return velocities near those of the chords, at rest at the ends."""
    chords = np.diff(points, axis=0) / np.diff(times)[:, None]
    inner = 0.5 * (chords[1:] + chords[:-1]) * rng.uniform(0, 1.5)
    return np.concatenate([np.zeros((1, 2)), inner, np.zeros((1, 2))])
