"""When a course is planned again in flight, and from where."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from flights import plan_for

from crosstrack.errors import Infeasible, Problem, Unreachable
from crosstrack.flight.loop import fly
from crosstrack.flight.navigation import Navigator
from crosstrack.flight.plan import Plan, Replanning
from crosstrack.follow.guidance import GuidanceMemory
from crosstrack.path.pace import course_of
from crosstrack.protocols import PlanningTask, Surroundings, Trajectory
from crosstrack.sense.lidar import Lidar
from crosstrack.track.feed_forward import FeedForward
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.types import Array, Outcome, Scan, State
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

START, GOAL = np.array([0.0, 0, 5]), np.array([20.0, 0, 5])
WALL = World((Box((10, -3, 0), (10.2, 3, 9)),))
LEVEL, REST = np.array([0, 0, 0, 1.0]), np.zeros(3)


@dataclass
class Detours:
    """A planner that goes round the wall by a point north of it, and remembers what it was asked."""

    replans: bool = True
    names: tuple[str, ...] = ()
    asked: list[PlanningTask] = field(default_factory=list)
    refusal: Exception | None = None

    def allowed(self, tolerance: float) -> None:
        return None

    def plan(self, task: PlanningTask) -> Trajectory:
        self.asked.append(task)
        if self.refusal is not None:
            raise self.refusal
        points = [task.waypoints[0], np.array([10.0, 5, 5]), *task.waypoints[1:]]
        gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return minimum(points, np.concatenate([[0], np.cumsum(gaps / 2.4)]), 3, start=task.motion)


def straight_plan(planner: Any, **options: Any) -> Plan:
    """A plan straight through the wall, that the vehicle is not told of."""
    plan = plan_for([START, GOAL], tracker=FeedForward(), world=WALL)
    envelope = Quadrotor().envelope(plan.scenario)
    course = replace(course_of(minimum([START, GOAL], [0, 10], 4), envelope), corners=plan.route.points)
    task = PlanningTask(plan.route.points, 4.0, 0.3, envelope, World(), 0.2)
    scenario = replace(plan.scenario, sensors=(Lidar(range=8.0),))
    return replace(
        plan,
        course=course,
        scenario=scenario,
        told=World(),
        replanning=Replanning(planner, task, blocked=True),
        **options,
    )


def navigating(planner: Any, waypoints: Sequence[Array] = (START, GOAL)) -> Navigator:
    navigator = Navigator(straight_plan(planner))
    navigator.take(navigator.plan.course, np.array(waypoints), 0.0)
    return navigator


def at(time: float, position: Array, velocity: Array = REST) -> State:
    return State(time, position, velocity, LEVEL, np.zeros(3))


def remembering(progress: float) -> GuidanceMemory:
    return GuidanceMemory(progress, GOAL, 0.0)


SEEING = Surroundings(WALL, scans=[Scan(0.0, np.zeros(3), np.eye(3), np.ones(3), 8.0)])


def test_a_blocked_course_is_planned_again_from_the_trajectory() -> None:
    planner = Detours()
    navigator = navigating(planner)
    old = navigator.course.trajectory
    assert old is not None
    state = at(3.0, old(3.0) + [0, 0.05, 0], old(3.0, 1))
    course = navigator.again(state, SEEING, remembering(2.0), held=False)
    assert course is navigator.course
    np.testing.assert_array_equal(planner.asked[0].waypoints, [old(3.0), GOAL])
    np.testing.assert_array_equal(planner.asked[0].motion, [old(3.0, 1), old(3.0, 2)])
    assert planner.asked[0].world is WALL
    assert navigator.again(replace(state, time=3.1), SEEING, remembering(0.1), held=False) is None


def test_what_is_free_or_not_seen_yet_is_not_planned_again() -> None:
    navigator = navigating(Detours())
    trajectory = navigator.course.trajectory
    assert trajectory is not None
    state = at(3.0, trajectory(3.0))
    assert navigator.again(state, Surroundings(World(), scans=SEEING.scans), remembering(2.0), held=False) is None
    assert navigator.again(state, Surroundings(WALL), remembering(2.0), held=False) is None


def test_far_from_the_trajectory_the_plan_begins_where_the_vehicle_is() -> None:
    planner = Detours()
    state = at(3.0, np.array([1.0, 2.0, 5.0]), np.array([0.5, 0, 0]))
    assert navigating(planner).again(state, Surroundings(World()), remembering(1.0), held=False) is not None
    np.testing.assert_array_equal(planner.asked[0].waypoints[0], state.position)
    np.testing.assert_array_equal(planner.asked[0].motion, [state.velocity, np.zeros(3)])


def test_held_without_progress_is_trapped_after_a_while() -> None:
    planner = Detours()
    navigator = navigating(planner)
    trajectory = navigator.course.trajectory
    assert trajectory is not None
    free, asked = Surroundings(World()), []
    for step in range(40):
        now = 0.1 * step
        navigator.again(at(now, trajectory(now)), free, remembering(1.0), held=True)
        asked.append(len(planner.asked))
    first = asked.index(1) * 0.1
    assert 2.0 <= first <= 2.3


def test_waypoints_passed_are_left_out() -> None:
    navigator = navigating(Detours(), [START, np.array([5.0, 0, 5]), np.array([15.0, 0, 5]), GOAL])
    assert navigator.remaining(0.5)[:, 0].tolist() == [5, 15, 20]
    assert navigator.remaining(5.1)[:, 0].tolist() == [15, 20]
    assert navigator.remaining(19.99)[:, 0].tolist() == [20]


def test_where_it_starts_is_no_waypoint_ahead() -> None:
    navigator = navigating(Detours(), [START + np.array([1e-12, 0, 0]), GOAL])
    assert navigator.course.path.project(navigator.waypoints[0], 0.0, 1.0) > 0
    assert navigator.remaining(0.0)[:, 0].tolist() == [20]


def test_off_the_trajectory_the_plan_begins_with_the_motion_of_the_vehicle() -> None:
    planner = Detours()
    navigator = navigating(planner)
    trajectory = navigator.course.trajectory
    assert trajectory is not None
    state = at(3.0, trajectory(3.0) + [0, 0.3, 0], np.array([0.5, 0.2, 0]))
    assert navigator.again(state, SEEING, remembering(2.0), held=False) is not None
    np.testing.assert_array_equal(planner.asked[0].waypoints[0], state.position)
    np.testing.assert_array_equal(planner.asked[0].motion[0], state.velocity)


def test_what_cannot_be_planned_is_tried_again_and_no_way_ends_it() -> None:
    planner = Detours(refusal=Infeasible("plan", [Problem("", "too fast")]))
    navigator = navigating(planner)
    before = navigator.course
    state = at(3.0, START)
    assert navigator.again(state, SEEING, remembering(2.0), held=False) is None
    assert navigator.course is before
    assert navigator.planning_time > 0
    planner.refusal = Unreachable("plan", [Problem("", "enclosed")])
    with pytest.raises(Unreachable):
        navigator.again(state, SEEING, remembering(2.0), held=False)


def test_a_wall_that_is_on_no_map_is_flown_round() -> None:
    planner = Detours()
    flight = fly(straight_plan(planner))
    assert flight.outcome is Outcome.ARRIVED
    assert len(flight.replans) == len(planner.asked) == flight.metrics.replans == 1
    assert flight.metrics.min_clearance_m is not None
    assert flight.metrics.min_clearance_m > 1.0
    wall = flight.seen[np.abs(flight.seen[:, 1]) < 3.1]
    assert len(wall) > 100
    assert WALL.distance(wall[wall[:, 2] > 0.1]).max() < 0.05


def test_no_way_at_all_ends_the_flight_with_that_sentence() -> None:
    planner = Detours(refusal=Unreachable("plan", [Problem("", "enclosed")]))
    flight = fly(straight_plan(planner))
    assert flight.outcome is Outcome.UNREACHABLE
    assert flight.metrics.flight_time_s < 3.0
