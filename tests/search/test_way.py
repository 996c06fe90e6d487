"""Ways against the exact optimum around discs, and through places that are hard to get through."""

import time
from itertools import pairwise

import numpy as np
import pytest
from discs_optimum import shortest

from crosstrack.errors import Unreachable
from crosstrack.search.departure import departure
from crosstrack.search.taut import length, taut
from crosstrack.search.way import find_way
from crosstrack.types import Array
from crosstrack.world.generate import Forest, Maze
from crosstrack.world.grids import Voxels
from crosstrack.world.shapes import Box, Cylinder, Sphere
from crosstrack.world.world import World

CLEARANCE = 0.25
OPEN = np.array([[-np.inf, -np.inf, 0.25], [np.inf, np.inf, np.inf]])
LAYER = np.array([[-np.inf, -np.inf, 0.25], [np.inf, np.inf, 2.75]])


def kept(world: World, way: Array) -> float:
    return min(world.swept(a, b) for a, b in pairwise(way))


def checked(world: World, start: Array, goal: Array, box: Array) -> Array:
    """Return a way after checks of its ends, its clearance and its place."""
    way = find_way(world, start, goal, CLEARANCE, box)
    np.testing.assert_array_equal(way[[0, -1]], [start, goal])
    assert kept(world, way) >= CLEARANCE - 2e-3
    assert (way >= box[0]).all()
    assert (way <= box[1]).all()
    return way


@pytest.mark.parametrize("density", [0.1, 0.2, 0.4])
def test_ways_through_forests_are_nearly_the_shortest(density: float) -> None:
    start, goal, ratios = np.array([0.0, 6.0, 1.5]), np.array([20.0, 6.0, 1.5]), []
    for seed in range(6):
        size, clear = (20.0, 12.0, 3.0), ((0.0, 6.0), (20.0, 6.0))
        trees = Forest(seed, size, density, (0.2, 0.5), clear, 0.5).shapes()
        centres = np.array([tree.center for tree in trees if isinstance(tree, Cylinder)])
        radii = np.array([tree.radius for tree in trees if isinstance(tree, Cylinder)]) + CLEARANCE
        best = shortest(start, goal, centres, radii)
        ratios.append(length(checked(World(trees), start, goal, LAYER)) / best)
    assert min(ratios) > 1 - 2e-3  # a way in the plane is no longer than one in space, here
    assert np.median(ratios) < 1.005
    assert max(ratios) < 1.04


def test_around_one_trunk_it_is_two_tangents_and_an_arc() -> None:
    start, goal, radius = np.array([-3.0, 0.1, 1.0]), np.array([3.0, -0.2, 1.0]), 0.4
    way = checked(World((Cylinder((0.0, 0.0), radius, (-9.0, 9.0)),)), start, goal, LAYER)
    best = shortest(start, goal, np.zeros((1, 2)), np.array([radius + CLEARANCE]))
    assert best < length(way) + 2e-3
    assert length(way) < best * 1.001


def test_over_a_wall_it_is_shorter_than_around() -> None:
    wall = World((Box((-0.05, -20.0, 0.0), (0.05, 20.0, 1.5)),))
    way = checked(wall, np.array([-2.0, 0.0, 1.0]), np.array([2.0, 0.0, 1.0]), OPEN)
    assert way[:, 2].max() == pytest.approx(1.75, abs=0.03)
    assert length(way) < 4.6


@pytest.mark.parametrize("width", [0.51, 0.55, 0.7])
@pytest.mark.parametrize("thickness", [0.02, 0.3, 2.0])
@pytest.mark.parametrize("shift", [0.0, 0.031, 0.077])
def test_the_one_gap_that_is_wide_enough_is_found(width: float, thickness: float, shift: float) -> None:
    low, high = 2.0 + shift, 2.0 + shift + width
    walls = Box((4.0, -9.0, 0.0), (4.0 + thickness, low, 3.0)), Box((4.0, high, 0.0), (4.0 + thickness, 9.0, 3.0))
    box = np.array([[0.0, -5.0, 0.25], [9.0, 5.0, 2.75]])
    way = checked(World(walls), np.array([1.0, -1.0, 1.5]), np.array([8.0, -1.0, 1.5]), box)
    inside = way[(way[:, 0] > 4.0) & (way[:, 0] < 4.0 + thickness)]
    assert ((inside[:, 1] > low) & (inside[:, 1] < high)).all()


def test_gaps_that_are_too_narrow_are_passed_by_for_one_that_is_not() -> None:
    spans = (-5.0, -3.0), (-2.54, 0.0), (0.46, 2.0), (2.44, 4.0), (4.6, 5.0)
    walls = tuple(Box((4.0, a, 0.0), (4.2, b, 3.0)) for a, b in spans)
    box = np.array([[0.0, -5.0, 0.25], [9.0, 5.0, 2.75]])
    way = checked(World(walls), np.array([1.0, 0.2, 1.5]), np.array([8.0, 0.2, 1.5]), box)
    crossing = np.interp(4.1, way[:, 0], way[:, 1])
    assert 4.25 < crossing < 4.35


def test_a_wall_without_a_gap_that_is_wide_enough_ends_with_the_sentence() -> None:
    walls = Box((4.0, -5.0, 0.0), (4.2, 0.0, 3.0)), Box((4.0, 0.45, 0.0), (4.2, 5.0, 3.0))
    box = np.array([[0.0, -5.0, 0.25], [9.0, 5.0, 2.75]])
    with pytest.raises(Unreachable, match=r"leave no gap that is 0\.5 m wide"):
        find_way(World(walls), np.array([1.0, 0.2, 1.5]), np.array([8.0, 0.2, 1.5]), CLEARANCE, box)


@pytest.mark.parametrize("seed", range(4))
def test_mazes_are_solved(seed: int) -> None:
    world, box = World(Maze(seed).shapes()), np.array([[0.0, 0.0, 0.25], [20.0, 20.0, 2.75]])
    way = checked(world, np.array([1.0, 1.0, 1.5]), np.array([19.0, 19.0, 1.5]), box)
    assert np.ptp(way[:, 2]) < 0.3


def test_without_bounds_the_window_grows_around_a_long_wall() -> None:
    world = World((Box((0.0, -40.0, -9.0), (0.2, 40.0, 60.0)),))
    way = checked(world, np.array([-2.0, 5.0, 1.5]), np.array([2.0, 5.0, 1.5]), LAYER)
    assert length(way) == pytest.approx(np.hypot(2.0, 35.25) + np.hypot(1.8, 35.25) + 0.2, rel=0.01)


def cage(low: Array, high: Array, wall: float = 0.1) -> tuple[Box, ...]:
    """Return six walls around a box."""
    boxes = []
    for axis in range(3):
        for side in (0, 1):
            a, b = low - wall, high + wall
            a[axis] = low[axis] - wall if side == 0 else high[axis]
            b[axis] = low[axis] if side == 0 else high[axis] + wall
            boxes.append(Box(tuple(a.tolist()), tuple(b.tolist())))
    return tuple(boxes)


def test_an_enclosed_goal_is_given_up_quickly_even_without_bounds() -> None:
    world = World(cage(np.array([9.0, -1.0, 0.5]), np.array([11.0, 1.0, 2.5])))
    start, goal = np.array([0.0, 0.0, 1.5]), np.array([10.0, 0.0, 1.5])
    for ends in ((start, goal), (goal, start)):
        with pytest.raises(Unreachable, match="goal: obstacles enclose it"):
            find_way(world, *ends, CLEARANCE, OPEN)
    began = time.process_time()
    with pytest.raises(Unreachable):
        find_way(world, start, goal, CLEARANCE, OPEN)
    assert time.process_time() - began < 5.0  # an unbounded search would never end


def test_a_goal_inside_an_obstacle_is_named() -> None:
    world = World((Sphere((5.0, 0.0, 1.0), 1.0),))
    with pytest.raises(Unreachable, match="goal: is inside an obstacle, 1 m deep"):
        find_way(world, np.array([0.0, 0.0, 1.0]), np.array([5.0, 0.0, 1.0]), CLEARANCE, OPEN)


def test_from_close_to_a_tree_it_leads_away_first() -> None:
    world = World((Cylinder((0.0, 0.0), 0.3, (0.0, 3.0)),))
    start, goal = np.array([0.38, 0.0, 1.5]), np.array([-3.0, 0.0, 1.5])
    way = find_way(world, start, goal, CLEARANCE, LAYER)
    assert kept(world, way[1:]) >= CLEARANCE - 2e-3
    assert world.swept(way[0], way[1]) >= 0.08 - 2e-3


def test_from_the_ground_it_rises_first() -> None:
    way = find_way(World(), np.array([0.0, 0.0, 0.05]), np.array([5.0, 0.0, 0.0]), CLEARANCE, LAYER)
    np.testing.assert_allclose(way, np.array([[0.0, 0, 0.05], [0, 0, 0.25], [5, 0, 0.25], [5, 0, 0]]))


def test_where_there_is_clearance_nothing_comes_before_the_way() -> None:
    point = np.array([1.0, 2.0, 1.0])
    np.testing.assert_array_equal(departure(World(), point, CLEARANCE, LAYER, "start"), point[None])


def test_voxels_are_flown_around_as_shapes_are() -> None:
    occupied = np.zeros((40, 40, 30), bool)
    occupied[18:20, :35] = True
    world = World(grids=(Voxels(occupied, (0.0, 0.0, 0.0), 0.1),))
    box = np.array([[0.0, 0.0, 0.25], [4.0, 6.0, 2.75]])
    way = checked(world, np.array([0.5, 1.0, 1.5]), np.array([3.5, 1.0, 1.5]), box)
    assert way[:, 1].max() > 3.5


@pytest.mark.parametrize("seed", range(3))
def test_pulling_taut_only_shortens_and_keeps_the_clearance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    balls = World(tuple(Sphere(tuple(rng.uniform(0, 6, 3).tolist()), 0.5) for _ in range(25)))
    way = np.array([[-2.0, -2, -2], [-2, 8, -2], [-2, 8, 8], [8, 8, 8]])
    short = taut(balls, way, CLEARANCE)
    np.testing.assert_array_equal(short[[0, -1]], way[[0, -1]])
    assert length(short) < length(way)
    assert kept(balls, short) >= CLEARANCE
