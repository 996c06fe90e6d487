"""The terms of the field: forces are gradients of potentials, and nothing depends on where the world stands."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.avoid.potential_field import Factor, Terms, attraction, bell, repulsion, slowness
from crosstrack.avoid.potential_turning import cross, rotated, turned
from crosstrack.types import Array
from crosstrack.vectors import direction

STEP = 1e-6
GOAL = np.array([4.0, -3.0, 1.0])
OBSTACLE = np.array([0.5, 0.8, 0.2])


def slope(potential: object, point: Array) -> Array:
    """Return the gradient of a potential by central differences."""
    assert callable(potential)
    steps = STEP * np.eye(3)
    return np.array([(potential(point + step) - potential(point - step)) / (2 * STEP) for step in steps])


@pytest.mark.parametrize("point", [[0.0, 0.0, 0.0], [3.7, -2.9, 1.1], [20.0, 5.0, -8.0]])
@pytest.mark.parametrize("conic", [math.inf, 2.0])
def test_attraction_is_the_negative_gradient_of_its_potential(point: list[float], conic: float) -> None:
    at = np.array(point)
    force = attraction(GOAL - at, 0.7, conic)[1]
    assert force == pytest.approx(-slope(lambda p: attraction(GOAL - p, 0.7, conic)[0], at), rel=1e-6, abs=1e-7)


def test_attraction_and_its_potential_go_on_where_the_cone_begins() -> None:
    inner, outer = (attraction(np.array([2.0 + side, 0.0, 0.0]), 0.7, 2.0) for side in (-1e-9, 1e-9))
    assert inner[0] == pytest.approx(outer[0], abs=1e-8)
    assert inner[1] == pytest.approx(outer[1], abs=1e-8)


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("factor", ["none", "obstacle", "vehicle"])
@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.0])
def test_repulsion_is_the_negative_gradient_of_its_potential(planar: bool, factor: Factor, exponent: float) -> None:
    flat = np.array([1.0, 1.0, 0.0 if planar else 1.0])
    goal, obstacle = GOAL * flat, OBSTACLE * flat
    numbers = Terms(repulsion=3.0, influence=2.0, factor=factor, exponent=exponent).numbers

    def field(point: Array) -> tuple[float, Array]:
        away = point - obstacle
        gap = float(np.linalg.norm(away))
        return repulsion(goal - point, gap, away / gap, numbers)

    for point in np.array([[0.1, 0.2, 0.3], [1.2, 0.3, 0.5], [-0.4, 0.9, 0.1]]) * flat:
        force = field(point)[1]
        assert np.linalg.norm(force) > 0
        assert force * flat == pytest.approx(-slope(lambda p: field(p)[0], point) * flat, rel=1e-5, abs=1e-6)


def test_factor_of_the_vehicle_pulls_to_the_goal_beside_pushing_from_the_obstacle() -> None:
    numbers = Terms(repulsion=1.0, influence=2.0, factor="vehicle", exponent=2.0).numbers
    way = np.array([0.0, 3.0, 0.0])
    force = repulsion(way, 0.5, np.array([-1.0, 0.0, 0.0]), numbers)[1]
    excess = 1 / 0.5 - 1 / 2.0
    assert force == pytest.approx([-excess * 9 / 0.25, excess**2 * 3.0, 0.0])


def test_goal_beside_an_obstacle_is_the_lowest_point_only_with_the_factor_of_the_vehicle() -> None:
    goal, wall = np.array([0.3, 0.0, 0.0]), 0.0
    x = np.linspace(0.05, 3, 2000)
    lowest = {}
    for factor in ("none", "vehicle"):
        terms = Terms(attraction=1.0, repulsion=0.5, influence=1.0, factor=factor)
        heights = [
            attraction(goal - [at, 0, 0], 1.0, math.inf)[0]
            + repulsion(goal - [at, 0, 0], at - wall, np.array([1.0, 0, 0]), terms.numbers)[0]
            for at in x
        ]
        lowest[factor] = x[int(np.argmin(heights))]
    assert lowest["vehicle"] == pytest.approx(0.3, abs=0.002)
    assert lowest["none"] > 0.5


def test_repulsion_begins_at_its_influence_without_a_jump() -> None:
    numbers = Terms(repulsion=5.0, influence=2.0).numbers
    away = np.array([1.0, 0.0, 0.0])
    near, far = (repulsion(GOAL, gap, away, numbers) for gap in (2.0 - 1e-6, 2.0))
    assert near[0] == pytest.approx(0.0, abs=1e-11)
    assert np.linalg.norm(near[1]) < 1e-5
    assert far[0] == 0.0
    assert (far[1] == 0.0).all()


def test_repulsion_stays_finite_on_the_obstacle() -> None:
    potential, force = repulsion(GOAL, 0.0, np.array([1.0, 0.0, 0.0]), Terms(factor="vehicle").numbers)
    assert np.isfinite(force).all()
    assert math.isfinite(potential)


@given(st.floats(0.1, 20), st.floats(-1e3, 1e3))
def test_slowness_is_finite_grows_as_the_approach_slows_and_is_bounded(step: float, closing: float) -> None:
    value = slowness(step, closing)
    assert 1.0 - 1e-12 <= value <= 3.0 + 1e-12
    assert slowness(step, closing - 0.1 * step) >= value - 1e-12


def test_slowness_takes_approach_as_positive() -> None:
    assert slowness(2.0, 2.0) == pytest.approx(1.0)
    assert slowness(2.0, 0.0) == pytest.approx(1.5)
    assert slowness(2.0, -2.0) == pytest.approx(3.0)


def test_bump_near_the_goal_is_that_of_the_article() -> None:
    terms = Terms(near_goal=3.0)
    for remaining in (0.0, 0.5, 2.0, 9.0):
        expected = 3 * math.exp(-((remaining - 0.5) ** 2) / 2) + 1
        assert terms.strengthened(remaining, 1.0, 0.0) == pytest.approx(expected)
    assert bell(0.5, 0.5) == 1.0


unit = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1).map(direction)


@given(unit, unit, st.floats(-3, 3))
def test_rotation_keeps_the_size_and_the_part_along_the_axis(vector: Array, axis: Array, angle: float) -> None:
    out = rotated(vector, axis, angle)
    assert np.linalg.norm(out) == pytest.approx(1.0)
    assert out @ axis == pytest.approx(vector @ axis, abs=1e-12)
    assert rotated(out, axis, -angle) == pytest.approx(vector, abs=1e-12)


@given(unit, unit, st.floats(0.1, 1.5))
def test_turned_repulsion_keeps_its_size_and_leans_to_where_the_attraction_passes(
    away: Array, way: Array, angle: float
) -> None:
    axis = direction(cross(away, np.array([0.6, 0.0, 0.8])))
    out = turned(2.0 * away, away, way, axis, angle, True)
    if np.linalg.norm(axis) > 0:
        assert np.linalg.norm(out) == pytest.approx(2.0)
    if way @ away < 0 and np.linalg.norm(way - (way @ away) * away) > 0.1:
        assert out @ away == pytest.approx(2.0 * math.cos(angle))
        assert out @ way >= 2.0 * away @ way - 1e-12
