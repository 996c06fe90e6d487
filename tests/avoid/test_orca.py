"""Velocities that reciprocal avoidance allows, against sampled futures, and against an independent solver."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from crosstrack.avoid.orca import Orca
from crosstrack.avoid.orca_choice import choose
from crosstrack.avoid.orca_planes import apart, excess
from crosstrack.avoid.orca_velocity import least_slack, nearest, safest
from crosstrack.avoid.orca_walls import walls_around
from crosstrack.types import Array
from crosstrack.world.shapes import Cylinder
from crosstrack.world.world import World

seeds = st.integers(0, 2**32 - 1)
FREE = (0.0, 1.0, 0.0)


def gap_ahead(way: Array, velocity: Array, horizon: float) -> float:
    """Return the least distance to a ball within a horizon, from its closed form."""
    square = float(velocity @ velocity)
    time = min(horizon, max(0.0, float(way @ velocity) / square)) if square > 0 else 0.0
    return float(np.linalg.norm(way - time * velocity))


def boundary_of(way: Array, velocity: Array, radius: float, horizon: float) -> tuple[float, float, float, float]:
    px, py, pz = way.tolist()
    vx, vy, vz = velocity.tolist()
    return apart(px, py, pz, vx, vy, vz, radius, horizon)


@given(seeds)
def test_the_excess_is_the_way_to_the_boundary_of_the_velocity_obstacle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    horizon, radius = rng.uniform(0.5, 4), rng.uniform(0.2, 1)
    way = rng.normal(size=3)
    way *= rng.uniform(1.05, 8) * radius / np.linalg.norm(way)
    velocity = rng.uniform(-4, 4, 3)
    *normal, outside = boundary_of(way, velocity, radius, horizon)
    assert np.linalg.norm(normal) == pytest.approx(1)
    assert (outside < 0) == (gap_ahead(way, velocity, horizon) < radius)
    boundary = velocity - outside * np.array(normal)
    assert gap_ahead(way, boundary, horizon) == pytest.approx(radius, abs=1e-6)
    # No shorter change gets there.
    for _ in range(50):
        step = rng.normal(size=3)
        step *= 0.99 * abs(outside) / np.linalg.norm(step)
        assert (gap_ahead(way, velocity + step, horizon) < radius) == (outside < 0)


@given(seeds)
def test_two_that_take_half_each_stay_clear(seed: int) -> None:
    rng = np.random.default_rng(seed)
    horizon, radius = 2.0, 0.5
    way = rng.normal(size=3)
    way *= rng.uniform(0.6, 5) / np.linalg.norm(way)
    own, other = rng.uniform(-2, 2, (2, 3))
    *normal, outside = boundary_of(way, own - other, radius, horizon)
    n = np.array(normal)
    for _ in range(30):
        mine, its = rng.uniform(-3, 3, (2, 3))
        mine += max(0.0, n @ (own - 0.5 * outside * n - mine)) * n
        its -= max(0.0, -n @ (other + 0.5 * outside * n - its)) * n
        assert gap_ahead(way, mine - its, horizon) >= radius - 1e-6


def test_each_of_a_pair_sees_the_other_as_the_other_sees_it() -> None:
    one = np.array(apart(2.0, 0.3, 0.1, 1.0, 0.1, 0.0, 0.5, 2.0))
    two = np.array(apart(-2.0, -0.3, -0.1, -1.0, -0.1, 0.0, 0.5, 2.0))
    np.testing.assert_allclose(two[:3], -one[:3])
    assert two[3] == pytest.approx(one[3])


def test_what_points_straight_at_another_turns_to_its_right() -> None:
    x, y, _, outside = apart(4.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.5, 4.0)
    assert outside < 0
    assert y < 0 < -x


@pytest.mark.parametrize("distance", [0.3, 0.45, 0.5])
def test_nearer_than_the_margin_nothing_comes_closer(distance: float) -> None:
    *normal, outside = excess(distance, 0.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.5, 2.0)
    np.testing.assert_allclose(normal, [-1, 0, 0], atol=1e-12)
    assert outside <= 0


def half_spaces(rng: np.random.Generator, count: int) -> Array:
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return np.column_stack([normals, rng.uniform(-2, 0.7, count)])


def solved(planes: Array, target: Array) -> Any:
    return minimize(
        lambda v: 0.5 * (v - target) @ (v - target),
        np.zeros(3),
        jac=lambda v: v - target,
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda v: planes[:, :3] @ v - planes[:, 3], "jac": lambda _: planes[:, :3]},
        options={"maxiter": 200, "ftol": 1e-14},
    )


@given(seeds, st.integers(1, 12))
def test_the_nearest_velocity_is_that_of_another_solver(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    planes, target = half_spaces(rng, count), rng.uniform(-3, 3, 3)
    found, *velocity = nearest(planes, tuple(target))
    oracle = solved(planes, target)
    if found:
        assert (planes[:, :3] @ velocity >= planes[:, 3] - 1e-7).all()
        if oracle.success:
            assert np.linalg.norm(velocity - target) <= np.linalg.norm(oracle.x - target) + 1e-5
    else:
        assert not oracle.success or (planes[:, :3] @ oracle.x < planes[:, 3] - 1e-9).any()


@given(seeds, st.integers(4, 20))
def test_the_order_of_half_spaces_does_not_matter(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    planes, target = half_spaces(rng, count), tuple(rng.uniform(-3, 3, 3))
    found, *velocity = nearest(planes, target)
    again, *other = nearest(planes[rng.permutation(count)].copy(), target)
    assert again == found
    if found:
        np.testing.assert_allclose(other, velocity, atol=1e-6)


@given(seeds)
def test_where_no_velocity_is_left_the_least_is_missed_and_nothing_fixed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    fixed = half_spaces(rng, 4)
    fixed[:, 3] = -np.abs(fixed[:, 3])
    pair = half_spaces(rng, 1)
    pair[:, 3] = 0.5
    planes = np.concatenate([fixed, pair, pair * [-1, -1, -1, 1]])
    velocity = np.array(safest(planes, (0.0, 0.0, 0.0), 4))
    # Two opposite ones, each half a metre per second from rest, are missed by half each.
    assert least_slack(planes, 4) == pytest.approx(0.5, abs=1e-3)
    assert (fixed[:, :3] @ velocity >= fixed[:, 3] - 1e-7).all()
    np.testing.assert_allclose(planes[4:, 3] - planes[4:, :3] @ velocity, 0.5, atol=1e-3)


def decide(position: Array, velocity: Array, wanted: Array, others: Array, motion: Array, climb: float = 0.0) -> Array:
    count = len(others)
    around = (np.empty((0, 4)), others, motion, np.full(count, 0.2), np.ones(count, dtype=bool))
    rule = (0.2, 0.1, 2.0, 2.0, climb)
    return np.array(choose(position, velocity, wanted, FREE, *around, rule, 0.02)[0])


def test_what_is_free_is_not_changed() -> None:
    wanted = np.array([1.2, 0.3, -0.1])
    others = np.array([[-3.0, 0, 0], [0, 8, 0]])
    np.testing.assert_allclose(decide(np.zeros(3), wanted, wanted, others, np.zeros((2, 3))), wanted)


def test_a_decision_does_not_depend_on_where_and_which_way() -> None:
    rng = np.random.default_rng(3)
    others, motion = rng.uniform(-3, 3, (6, 3)), rng.uniform(-1, 1, (6, 3))
    others[:, 2] = motion[:, 2] = 0
    velocity, wanted = np.array([1.0, 0, 0]), np.array([1.9, 0.4, 0])
    c, s = math.cos(0.5), math.sin(0.5)
    turn, shift = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]), np.array([3.0, -2, 7])
    plain = decide(np.zeros(3), velocity, wanted, others, motion)
    moved = decide(shift, turn @ velocity, turn @ wanted, others @ turn.T + shift, motion @ turn.T)
    np.testing.assert_allclose(moved, turn @ plain, atol=1e-6)


def test_it_keeps_its_height_unless_it_may_climb() -> None:
    others, motion = np.array([[2.0, 0, 0.1]]), np.array([[-2.0, 0, 0]])
    velocity = np.array([2.0, 0, 0])
    assert decide(np.zeros(3), velocity, velocity, others, motion)[2] == pytest.approx(0, abs=1e-9)
    assert decide(np.zeros(3), velocity, velocity, others, motion, climb=1.0)[2] < -0.01


def test_walls_are_the_nearest_points_of_obstacles_ground_and_bounds() -> None:
    world = World(
        (Cylinder((2.0, 0.0), 0.5, (0.0, 5.0)), Cylinder((0.0, -3.0), 0.5, (0.0, 5.0))),
        bounds=np.array([[-9.0, -9, 0], [9, 9, 4]]),
    )
    walls = walls_around(world, np.array([0.0, 0.0, 1.0]), 0.2, 4.0)
    trees = walls[np.abs(walls[:, 2]) < 1e-9]
    assert trees[:, 3].min() == pytest.approx(1.3)
    south = trees[trees[:, 1] > 0.99]
    np.testing.assert_allclose(south[0], [0, 1, 0, 2.3], atol=1e-6)
    floor = walls[walls[:, 2] > 0.99]
    np.testing.assert_allclose(floor[:, 3].min(), 0.8)
    roof = walls[walls[:, 2] < -0.99]
    np.testing.assert_allclose(roof[:, 3], 2.8)


def test_its_defaults_leave_room_at_the_spacing_of_a_hundred_on_a_circle() -> None:
    assert 2 * 0.2 + Orca().margin < 2 * 10 * math.sin(math.pi / 100)
