"""The field alone: what it arrives at, what traps it, and that nothing is too thin to be noticed."""

import math
from typing import Literal

import numpy as np
import pytest

from crosstrack.avoid.potential_braking import allowed, held_back
from crosstrack.avoid.potential_escape import Escape, Situation, axis_around
from crosstrack.avoid.potential_field import Terms
from crosstrack.avoid.potential_published import published_path
from crosstrack.avoid.potential_run import Law, potential_at, potential_path
from crosstrack.avoid.potential_sources import near_map
from crosstrack.errors import InputError
from crosstrack.types import Array, Outcome
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

TALL = (-500.0, 500.0)
WALL = World((Box((20.0, -8.0, -500.0), (21.0, 8.0, 500.0)),))
DISC = World((Cylinder((20.0, 0.0), 5.0, TALL),))
CLASSIC = Law(Terms(attraction=0.05, influence=8.0), patience=60.0)
IMPROVED = Law(
    Terms(attraction=0.05, influence=8.0, approach=True), Escape("rotate", keep=True), damping=0.3, braking=True
)


def test_wall_straight_ahead_traps_the_classic_field_and_not_the_improved_one() -> None:
    classic = potential_path(WALL, [0, 0], [40, 0], CLASSIC)
    assert classic.outcome is Outcome.STUCK
    assert np.abs(classic.points[:, 1]).max() < 1e-6
    improved = potential_path(WALL, [0, 0], [40, 0], IMPROVED)
    assert improved.outcome is Outcome.ARRIVED
    assert improved.clearance > 0
    assert improved.length < 1.8 * 40


def test_random_walk_leaves_the_same_minimum() -> None:
    law = Law(CLASSIC.terms, Escape("walk", window=8.0), braking=True, patience=400.0)
    assert potential_path(WALL, [0, 0], [40, 0], law).outcome is Outcome.ARRIVED


def test_descent_to_the_lowest_neighbour_ends_where_force_balances() -> None:
    run = potential_path(WALL, [0, 0], [40, 0], Law(CLASSIC.terms, method="descent"))
    assert run.outcome is Outcome.STUCK
    x, y = run.points[-1]
    step = 0.4
    here = np.array([x, y, 1.0])
    heights = [
        potential_at(WALL, here + step * np.array([i, j, 0.0]), np.array([40.0, 0.0, 1.0]), CLASSIC.terms, planar=True)
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]
    assert min(heights) == heights[4]


def test_path_in_space_goes_around_a_disc_in_the_way() -> None:
    run = potential_path(DISC, [0, 0, 1], [40, 0, 1], IMPROVED)
    assert run.outcome is Outcome.ARRIVED
    assert run.points.shape[1] == 3
    assert run.clearance > 0


@pytest.mark.parametrize("method", ["force", "descent"])
@pytest.mark.parametrize("thickness", [1e-3, 0.05])
def test_no_wall_is_too_thin_to_be_noticed(method: Literal["force", "descent"], thickness: float) -> None:
    wall = World((Box((20.0, -200.0, -500.0), (20.0 + thickness, 200.0, 500.0)),))
    for terms in (Terms(repulsion=0.0), Terms()):
        run = potential_path(wall, [0, 0], [40, 0.3], Law(terms, method=method))
        assert run.outcome is not Outcome.ARRIVED
        inside = run.points[:-1] if run.outcome is Outcome.COLLIDED else run.points
        assert inside[:, 0].max() < 20.0


def test_braking_point_never_touches_the_wall() -> None:
    wall = World((Box((20.0, -30.0, -500.0), (20.001, 30.0, 500.0)),))
    run = potential_path(wall, [0, 0], [40, 0.3], Law(Terms(repulsion=0.0), braking=True))
    assert run.outcome is Outcome.STUCK
    assert run.clearance > 0


def test_trap_open_towards_the_start_is_left_by_keeping_a_side() -> None:
    trap = World(
        (
            Box((40.0, -10.0, -500.0), (42.0, 10.0, 500.0)),
            Box((20.0, -12.0, -500.0), (42.0, -10.0, 500.0)),
            Box((20.0, 10.0, -500.0), (42.0, 12.0, 500.0)),
        )
    )
    kept = Law(Terms(attraction=0.5, influence=6.0), Escape("rotate", keep=True), braking=True)
    dropped = Law(kept.terms, Escape("rotate", keep=False), braking=True)
    assert potential_path(trap, [0, 0], [70, 1], kept).outcome is Outcome.ARRIVED
    assert potential_path(trap, [0, 0], [70, 1], dropped).outcome is Outcome.STUCK


def test_enclosed_goal_ends_the_run() -> None:
    walls = [((30.0, -10.0), (32.0, 10.0)), ((48.0, -10.0), (50.0, 10.0))]
    walls += [((30.0, -10.0), (50.0, -8.0)), ((30.0, 8.0), (50.0, 10.0))]
    world = World(tuple(Box((*low, -500.0), (*high, 500.0)) for low, high in walls))
    run = potential_path(world, [0, 0], [40, 0], Law(Terms(influence=6.0), Escape("rotate", keep=True), braking=True))
    assert run.outcome is Outcome.STUCK
    assert run.clearance > 0


def test_points_of_no_plane_are_refused() -> None:
    with pytest.raises(InputError, match="two or three finite numbers"):
        potential_path(DISC, [0, 0], [80, 0, 1])


def situation(world: World, here: Array, way: Array, planar: bool = False) -> Situation:
    near = near_map(world, here, 3.0, planar)
    return Situation(here, way, near.away[0], near, 3.0, 0.3, 3.0, planar, world.distance)


def test_axis_is_that_of_a_trunk_and_the_direction_of_a_beam() -> None:
    ahead, here = np.array([1.0, 0.0, 0.0]), np.zeros(3)
    trunk = World((Cylinder((2.0, 0.0), 0.4, (-60.0, 60.0)),))
    beam = World((Box((1.8, -60.0, -0.2), (2.2, 60.0, 0.2)),))
    assert np.abs(axis_around(Escape("rotate"), situation(trunk, here, ahead))) == pytest.approx([0, 0, 1], abs=1e-6)
    assert np.abs(axis_around(Escape("rotate"), situation(beam, here, ahead))) == pytest.approx([0, 1, 0], abs=1e-6)


@pytest.mark.parametrize("open_side", [1.0, -1.0])
def test_wall_is_passed_on_its_open_side(open_side: float) -> None:
    low, high = sorted([-40.0 * open_side, 1.5 * open_side])
    wall = World((Box((2.0, low, -40.0), (2.4, high, 40.0)),))
    axis = axis_around(Escape("rotate"), situation(wall, np.zeros(3), np.array([1.0, 0.0, 0.0])))
    along = np.cross(axis, [-1.0, 0.0, 0.0])
    assert along @ [0.0, open_side, 0.0] > 0.7


def test_allowed_approach_stops_within_the_gap() -> None:
    for gap, braking, delay in ((2.0, 3.0, 0.2), (0.1, 5.0, 0.0), (30.0, 1.0, 1.0)):
        speed = allowed(gap, braking, delay)
        assert speed * delay + speed**2 / (2 * braking) == pytest.approx(gap)
    assert allowed(-0.1, 3.0, 0.2) == 0.0


def test_velocity_is_held_back_only_across_the_obstacle() -> None:
    gaps, away = np.array([0.5]), np.array([[-1.0, 0.0, 0.0]])
    out = held_back(np.array([3.0, 2.0, -1.0]), gaps, away, np.zeros(1), 3.0, 0.2)
    assert out == pytest.approx([allowed(0.5, 3.0, 0.2), 2.0, -1.0])
    leaving = np.array([-3.0, 2.0, -1.0])
    assert held_back(leaving, gaps, away, np.zeros(1), 3.0, 0.2) == pytest.approx(leaving)


def test_published_program_walks_through_what_it_does_not_see() -> None:
    free = np.ones((100, 100), dtype=bool)
    open_path = published_path(free, np.zeros(2), np.array([80.0, 80.0]))
    assert math.dist(open_path[-1], (80, 80)) <= 2
    for k in range(30, 60):
        free[k, 90 - k] = False
    path = published_path(free, np.zeros(2), np.array([80.0, 80.0]))
    inside = [not free[int(x), int(y)] for x, y in path if 0 <= x < 100 and 0 <= y < 100]
    crossed = (path.sum(axis=1) > 95).any()
    assert crossed
    assert not any(inside)
