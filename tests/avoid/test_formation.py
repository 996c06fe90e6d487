"""Shapes, and the potentials that keep them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.avoid.formation import way_to_slot
from crosstrack.avoid.formation_field import around_obstacle, formed, from_others, strength
from crosstrack.avoid.formation_shapes import Shape, shape_error, slots
from crosstrack.types import Others

SHAPES: tuple[Shape, ...] = ("line", "v", "circle")
RULE = (0.8, 0.5, 1.5, 2.0)
NONE = np.zeros(3)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("count", [2, 3, 5, 8])
def test_neighbours_are_the_spacing_apart_around_the_middle(shape: Shape, count: int) -> None:
    places = slots(shape, count, 1.5, 0.3)
    away = np.linalg.norm(places[:, None] - places[None], axis=-1) + 9 * np.eye(count)
    assert away.min() == pytest.approx(1.5)
    np.testing.assert_allclose(places.mean(axis=0), 0, atol=1e-12)


def test_a_line_is_abreast_and_a_v_has_its_tip_ahead() -> None:
    heading = np.array([math.cos(0.7), math.sin(0.7), 0])
    np.testing.assert_allclose(slots("line", 5, 2.0, 0.7) @ heading, 0, atol=1e-12)
    assert np.argmax(slots("v", 5, 2.0, 0.7) @ heading) == 0
    radius = np.linalg.norm(slots("circle", 6, 2.0, 0.7), axis=1)
    np.testing.assert_allclose(radius, 2.0)


@given(st.sampled_from(SHAPES), st.integers(0, 2**32 - 1))
def test_the_error_of_a_shape_does_not_depend_on_where_it_is(shape: Shape, seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = slots(shape, 5, 2.0)
    off = rng.normal(size=(5, 3))
    assert shape_error(places + rng.normal(size=3), places) == pytest.approx(0, abs=1e-12)
    spread = off - off.mean(axis=0)
    assert shape_error(places + off, places) == pytest.approx(math.sqrt((spread**2).sum() / 5))


@given(st.integers(0, 2**32 - 1))
def test_attraction_alone_brings_any_positions_into_shape_and_leaves_the_middle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places = slots("v", 5, 2.0)
    positions = rng.uniform(-9, 9, (5, 3))
    ways = []
    for k in range(5):
        rest = np.delete(positions, k, axis=0)
        others = Others(rest, np.zeros((4, 3)), np.full(4, 0.2), np.ones(4, dtype=bool))
        ways.append(way_to_slot(places, k, positions[k], others))
    assert shape_error(positions + ways, places) == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(np.mean(ways, axis=0), 0, atol=1e-9)


def test_who_is_missing_leaves_no_shape() -> None:
    others = Others(np.zeros((3, 3)), np.zeros((3, 3)), np.full(3, 0.2), np.array([True, True, False]))
    np.testing.assert_array_equal(way_to_slot(slots("v", 5, 2.0), 0, np.ones(3), others), 0)


@given(st.floats(0.41, 2), st.floats(0.01, 1))
def test_repulsion_is_the_slope_of_its_potential(distance: float, more: float) -> None:
    near, reach = 0.4, 2.0

    def potential(d: float) -> float:
        return (d / reach - 1 - math.log(d / reach)) / (1 / near - 1 / reach) if d < reach else 0.0

    h = 1e-5
    slope = (potential(distance + h) - potential(distance - h)) / (2 * h)
    assert strength(distance, near, reach) == pytest.approx(-slope, abs=1e-4)
    assert strength(distance + more, near, reach) <= strength(distance, near, reach)


def test_vehicles_push_one_another_apart_equally() -> None:
    a, b = np.array([0.0, 0, 1]), np.array([0.6, 0.2, 1])
    one = from_others(a, b[None], np.array([0.2]), 0.2, 1.0)
    two = from_others(b, a[None], np.array([0.2]), 0.2, 1.0)
    np.testing.assert_allclose(one, -two)
    assert one @ (a - b) > 0


@given(st.floats(0, 2 * math.pi), st.floats(0, 1))
def test_passing_an_obstacle_turns_away_only_what_leads_into_it(angle: float, share: float) -> None:
    normal = np.array([math.cos(angle), math.sin(angle), 0])
    wanted = np.array([2.0, 0, 0])
    turned = around_obstacle(wanted, normal, share)
    inwards = max(0.0, -wanted @ normal)
    assert -turned @ normal == pytest.approx((1 - share) * inwards if inwards else -wanted @ normal)


def test_at_an_obstacle_the_shape_is_given_up() -> None:
    wanted, normal = np.array([1.0, 0, 0]), np.array([0.0, 1, 0])
    far = formed(wanted, np.array([0.0, -1, 0]), NONE, normal, math.inf, 0.2, RULE)
    there = formed(wanted, np.array([0.0, -1, 0]), NONE, normal, 0.2, 0.2, RULE)
    assert far[1] < -0.5
    assert there[1] > 0.5


def test_in_its_slot_with_nothing_near_the_course_is_flown() -> None:
    wanted = np.array([1.0, 0.5, 0.1])
    np.testing.assert_allclose(formed(wanted, NONE, NONE, NONE, math.inf, 0.2, RULE), wanted)
