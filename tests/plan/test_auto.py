"""The planner that finds its own way: certified clearance, limits, motion to begin with, and rest wherever it ends."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from crosstrack.errors import Unreachable
from crosstrack.plan.auto import HORIZON, Auto, begun
from crosstrack.plan.auto_corridor import polytopes
from crosstrack.plan.auto_fit import at_rest
from crosstrack.plan.auto_stop import braking, settled, stop_and_go
from crosstrack.protocols import PlanningTask
from crosstrack.trajectory.certified.clearance import least_clearance
from crosstrack.trajectory.certified.extremes import axis_range, largest_norm
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Envelope
from crosstrack.world.generate import Forest
from crosstrack.world.shapes import Box, Cylinder, Sphere
from crosstrack.world.world import World

RADIUS, SPEED, ACCELERATION = 0.2, 4.0, 7.0
ENVELOPE = Envelope(12.0, 4.0, ACCELERATION, 3.0, 0.1)
LIMITS = MotionLimits(speed=SPEED, speed_vertical=4.0, acceleration=ACCELERATION, acceleration_vertical=3.0)
BOUNDS = np.array([[0.0, 0.0, 0.0], [16.0, 12.0, 3.0]])
START, GOAL = np.array([1.0, 6.0, 1.5]), np.array([15.0, 6.0, 1.5])


def forest(seed: int, density: float = 0.3) -> World:
    clear = ((1.0, 6.0), (15.0, 6.0))
    return World(Forest(seed, (16.0, 12.0, 3.0), density, (0.2, 0.5), clear, 0.5).shapes(), bounds=BOUNDS)


def task(world: World, start: Array = START, goal: Array = GOAL, motion: Array | None = None) -> PlanningTask:
    motion = np.zeros((2, 3)) if motion is None else motion
    return PlanningTask(np.array([start, goal]), SPEED, 1.0, ENVELOPE, world, RADIUS, motion=motion)


def planned(asked: PlanningTask) -> PiecewisePolynomial:
    """Return a plan after checks of its ends, its smoothness and its place."""
    curve = Auto().plan(asked)
    assert isinstance(curve, PiecewisePolynomial)
    np.testing.assert_allclose(curve(0.0), asked.waypoints[0], atol=1e-9)
    end, goal = curve(curve.duration), asked.waypoints[-1]
    if at_rest(asked.motion) or flown(curve) < 0.9 * HORIZON:
        np.testing.assert_allclose(end, goal, atol=1e-6)
    for order in (1, 2):
        np.testing.assert_allclose(curve(0.0, order), asked.motion[order - 1], atol=1e-6)
        np.testing.assert_allclose(curve(curve.duration, order), 0.0, atol=1e-5)
        before, after = (curve(curve.knots[1:-1] + shift, order) for shift in (-1e-9, 1e-9))
        np.testing.assert_allclose(before, after, atol=1e-4)
    lowest = min(asked.world.ground + RADIUS, float(asked.waypoints[:, 2].min()))
    assert axis_range(curve)[2].least.value >= lowest
    return curve


def flown(curve: PiecewisePolynomial) -> float:
    """Return the length of a curve, m."""
    points = curve(np.linspace(0.0, curve.duration, 2000))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize("seed", range(6))
def test_plans_are_clear_and_keep_the_limits(seed: int) -> None:
    world = forest(seed)
    curve = planned(task(world))
    assert least_clearance(curve, world).value >= RADIUS + 0.02
    for _, order, axes, most in LIMITS.bounds(3):
        assert largest_norm(curve, order, axes).value <= most * (1 + 1e-6)
    for side, (low, high) in zip(axis_range(curve), BOUNDS.T, strict=True):
        assert side.least.value > low
        assert side.greatest.value < high
    assert flown(curve) / curve.duration > 0.4 * SPEED


@pytest.mark.parametrize("seed", range(4))
def test_a_plan_made_in_flight_goes_on_from_the_motion(seed: int) -> None:
    world, rng = forest(seed), np.random.default_rng(seed)
    first = planned(task(world))
    for share in rng.uniform(0.1, 0.8, 3):
        time = share * first.duration
        motion = first(np.array([time, time]), 1)
        motion[1] = first(time, 2)
        position = first(time) + rng.normal(size=3) * 0.01
        second = planned(task(world, start=position, motion=motion))
        room = min(float(world.distance(position)), RADIUS + 0.05)
        assert least_clearance(second, world).value >= room - 0.035
        assert largest_norm(second, 2).value <= ACCELERATION * 1.25


def test_with_a_wall_ahead_it_turns_or_stops_in_time() -> None:
    world = World((Box((8.0, -9.0, 0.0), (8.1, 4.0, 9.0)),))
    motion = np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    for gap in (1.2, 1.5, 2.5):
        start = np.array([8.0 - gap, 0.0, 2.0])
        curve = planned(task(world, start, np.array([12.0, 0.0, 2.0]), motion))
        assert least_clearance(curve, world).value >= RADIUS


@pytest.mark.parametrize("seed", range(10))
def test_braking_ends_at_rest_and_hits_nothing_where_it_can(seed: int) -> None:
    rng = np.random.default_rng(seed)
    velocity, push = rng.normal(size=3) * [2.0, 2.0, 0.3], rng.normal(size=3)
    curve = braking(World(), np.array([0.0, 0.0, 9.0]), np.array([velocity, push]), 0.25, LIMITS)
    np.testing.assert_allclose(curve(0.0, 1), velocity, atol=1e-9)
    np.testing.assert_allclose(curve(0.0, 2), push, atol=1e-9)
    np.testing.assert_allclose(curve(curve.duration, 1), 0.0, atol=1e-9)
    assert largest_norm(curve, 2).value <= 1.15 * ACCELERATION
    ahead = velocity / np.linalg.norm(velocity)
    wall = World((Sphere(tuple(np.array([0.0, 0.0, 9.0]) + ahead * (np.linalg.norm(velocity) * 0.6 + 1.2)), 0.5),))
    curve = braking(wall, np.array([0.0, 0.0, 9.0]), np.array([velocity, push]), 0.25, LIMITS)
    assert least_clearance(curve, wall).value > 0.2


def test_points_on_the_way_are_flown_through() -> None:
    world = forest(1)
    via = np.array([8.0, 9.0, 2.0])
    while world.distance(via) < 0.4:
        via = via + [0.0, 0.1, 0.0]
    asked = replace(task(world), waypoints=np.array([START, via, GOAL]))
    curve = planned(asked)
    assert np.linalg.norm(curve(curve.knots) - via, axis=1).min() < 1e-6


def test_from_too_close_to_a_tree_it_leaves() -> None:
    world = World((Cylinder((5.0, 5.0), 0.3, (0.0, 3.0)),), bounds=BOUNDS)
    start = np.array([5.0 + 0.3 + 0.21, 5.0, 1.5])
    curve = planned(task(world, start, np.array([1.0, 5.0, 1.5])))
    assert least_clearance(curve, world).value > RADIUS - 0.01


def test_goals_that_cannot_be_reached_are_named() -> None:
    world = World((Sphere((15.0, 6.0, 1.5), 0.5),), bounds=BOUNDS)
    with pytest.raises(Unreachable, match=r"goal: is inside an obstacle, 0\.5 m deep"):
        Auto().plan(task(world))
    with pytest.raises(Unreachable, match=r"goal: is 0\.1 m from an obstacle"):
        Auto().plan(task(world, goal=np.array([14.4, 6.0, 1.5])))
    blocked = World((Box((8.0, -1.0, -1.0), (8.1, 13.0, 4.0)),), bounds=BOUNDS)
    with pytest.raises(Unreachable, match="goal"):
        Auto().plan(task(blocked))


def test_a_goal_next_to_where_it_is_is_settled_on() -> None:
    motion = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    curve = settled(START, motion, START + [0.02, 0.0, 0.0], LIMITS)
    np.testing.assert_allclose(curve(curve.duration), START + [0.02, 0.0, 0.0], atol=1e-12)
    assert planned(task(World(), START, START + [0.02, 0.0, 0.0], motion)).duration == curve.duration


def test_stop_and_go_stays_on_the_legs_within_the_limits() -> None:
    way = np.array([[0.0, 0, 1], [3, 0, 1], [3, 0.4, 1], [3, 0.4, 4]])
    curve = stop_and_go(way, LIMITS)
    np.testing.assert_allclose(curve(curve.knots), way, atol=1e-12)
    np.testing.assert_allclose(curve(curve.knots, 1), 0.0, atol=1e-12)
    peaks = [largest_norm(curve, order, axes).value / most for _, order, axes, most in LIMITS.bounds(3)]
    assert max(peaks) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_polytopes_hold_their_legs_and_only_clear_space(seed: int) -> None:
    world, rng = forest(seed, 0.4), np.random.default_rng(seed)
    way = planned(task(world))
    legs = way(np.linspace(0, way.duration, 60))
    gaps = np.array([world.swept(a, b) for a, b in pairwise(legs)])
    wanted, box = np.minimum(gaps, 0.25), np.array([[0.0, 0.0, 0.2], [16.0, 12.0, 3.0]])
    inside = 0
    for (normals, offsets), a, b, clearance in zip(
        polytopes(world, legs, wanted, 0.8, box), legs[:-1], legs[1:], wanted, strict=True
    ):
        assert (normals @ np.array([a, b]).T <= offsets[:, None] + 1e-9).all()
        points = 0.5 * (a + b) + rng.uniform(-0.45, 0.45, (300, 3))  # within the reach
        within = (points @ normals.T <= offsets).all(axis=1)
        inside += int(within.sum())
        assert (world.distance(points[within]) >= clearance - 0.04).all()
    assert inside > 1000


def test_the_first_part_of_a_way_is_as_long_as_the_horizon() -> None:
    way = np.array([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [3.0, 4.0, 1.0], [3.0, 4.0, 9.0]])
    through = np.array([False, True, False, True])
    for horizon in (0.5, 3.0, 3.02, 5.0, 7.0, 12.0, 15.0, np.inf):
        part, kept = begun(way, through, horizon)
        steps = np.linalg.norm(np.diff(part, axis=0), axis=1)
        assert steps.sum() == pytest.approx(min(horizon, 15.0), abs=0.05)
        assert (steps > 0.05).all()
        assert len(part) == len(kept)
        np.testing.assert_array_equal(part[:-1], way[: len(part) - 1])
    assert begun(way, through, np.inf)[1].tolist() == through.tolist()


def test_in_motion_it_keeps_off_a_wall_that_it_could_pass_closely() -> None:
    world = World((Box((4.0, 0.0, -1.0), (9.0, 5.0, 4.0)),), bounds=BOUNDS)
    start, goal = np.array([1.0, 4.5, 1.5]), np.array([10.5, 5.3, 1.5])
    motion = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    inner = np.array([4.5, 8.5])
    rooms = []
    for asked in (task(world, start, goal), task(world, start, goal, motion)):
        curve = planned(asked)
        points = curve(np.linspace(0.0, curve.duration, 500))
        beside = points[(points[:, 0] > inner[0]) & (points[:, 0] < inner[1])]
        rooms.append(float(world.distance(beside).min()))
    assert rooms[0] < 0.4
    assert rooms[1] > 0.45
