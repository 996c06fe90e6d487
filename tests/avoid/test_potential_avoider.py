"""The field in flight: it steers a quadrotor around what is in the way, and leaves commands alone where nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from crosstrack.avoid.potential import Potential
from crosstrack.follow.carrot import Carrot
from crosstrack.follow.course import plan_course
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course, Scenario, Surroundings
from crosstrack.types import Air, Array, AttitudeSetpoint, Limits, Noise, Others, Setpoint, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

PERIOD, RADIUS = 0.02, 0.2
START, GOAL = np.array([0.0, 0.0, 1.5]), np.array([14.0, 0.0, 1.5])
BOUNDS = np.array([[-2.0, -8.0, 0.0], [16.0, 8.0, 4.0]])


def course_in(world: World, cruise: float = 3.0) -> tuple[Scenario, Course]:
    scenario = Scenario(START.copy(), 0.0, world, cruise, Limits(), Wind(), Air(), Noise(), PERIOD, 0)
    envelope = replace(Quadrotor().envelope(scenario), radius=RADIUS)
    return scenario, plan_course(Polyline(np.array([START, GOAL])), 0.3, cruise, envelope)


def flown(world: World, avoider: Potential, seconds: float = 30.0, cruise: float = 3.0) -> tuple[Array, float, int]:
    """Return positions, least clearance (swept) and how many commands were changed of a flight with the field alone."""
    scenario, course = course_in(world, cruise)
    session, tracker, around = Quadrotor().launch(scenario), Carrot(), Surroundings(world)
    memory, deliberation = tracker.start(course, session.sense()), avoider.start(course, around, session.sense())
    path, clearance, changed = [session.truth().position], np.inf, 0
    for _ in range(round(seconds / PERIOD)):
        asked, memory = tracker.step(memory, course, session.sense(), PERIOD)
        command, deliberation = avoider.step(deliberation, asked, session.sense(), around, PERIOD)
        changed += deliberation.intervening
        session.advance(command, PERIOD)
        path.append(session.truth().position)
        clearance = min(clearance, world.swept(path[-2], path[-1]))
        if np.linalg.norm(path[-1] - GOAL) < 0.2 and np.linalg.norm(session.truth().velocity) < 0.3:
            break
    return np.array(path), clearance, changed


@pytest.mark.parametrize("offset", [0.0, 0.2, -0.3])
def test_trunk_on_the_route_is_passed_and_the_route_flown_again(offset: float) -> None:
    path, clearance, changed = flown(World((Cylinder((6.0, offset), 0.4, (0.0, 6.0)),), bounds=BOUNDS), Potential())
    assert clearance > RADIUS
    assert changed > 0
    assert np.linalg.norm(path[-1] - GOAL) < 0.2
    beyond = path[path[:, 0] > 10.5]
    assert np.abs(beyond[:, 1]).max() < 0.3
    assert np.abs(path[:, 2] - 1.5).max() < 0.6


def test_beam_across_the_route_is_passed_over_or_under() -> None:
    path, clearance, _ = flown(World((Box((6.0, -20.0, 1.3), (6.3, 20.0, 1.9)),), bounds=BOUNDS), Potential())
    assert clearance > RADIUS
    assert np.linalg.norm(path[-1] - GOAL) < 0.2
    assert path[:, 2].min() > RADIUS
    assert path[:, 2].max() < BOUNDS[1, 2]


def test_wall_without_a_way_is_neither_hit_nor_left_out_of_bounds() -> None:
    wall = World((Box((6.0, -50.0, -1.0), (6.01, 50.0, 50.0)),), bounds=BOUNDS)
    path, clearance, _ = flown(wall, Potential(), seconds=12.0, cruise=6.0)
    assert clearance > RADIUS
    assert path[:, 0].max() < 6.0
    assert ((path >= BOUNDS[0]) & (path <= BOUNDS[1])).all()


def test_empty_world_changes_nothing() -> None:
    path, _, changed = flown(World(bounds=BOUNDS), Potential())
    assert changed == 0
    assert np.linalg.norm(path[-1] - GOAL) < 0.2


def decide(world: World, command: Setpoint, state: State, others: Others | None = None) -> tuple[Setpoint, bool]:
    """Return the command after one decision, and whether it was changed."""
    _, course = course_in(world)
    around = Surroundings(world) if others is None else Surroundings(world, others)
    avoider = Potential()
    out, memory = avoider.step(avoider.start(course, around, state), command, state, around, PERIOD)
    assert isinstance(out, Setpoint)
    return out, memory.intervening


def at(position: list[float], velocity: list[float]) -> State:
    return State(0.0, np.array(position), np.array(velocity), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3))


def test_command_is_the_same_object_where_nothing_is_near() -> None:
    far = World((Cylinder((50.0, 50.0), 0.4, (0.0, 6.0)),))
    command = Setpoint(velocity=np.array([3.0, 0.0, 0.0]), acceleration=np.array([0.5, 0.0, 0.0]))
    out, intervening = decide(far, command, at([2, 0, 1.5], [3, 0, 0]))
    assert out is command
    assert not intervening


def test_vehicle_that_comes_head_on_is_given_way() -> None:
    others = Others(np.array([[4.0, 0.0, 1.5]]), np.array([[-3.0, 0.0, 0.0]]), np.array([0.2]), np.array([False]))
    out, intervening = decide(World(), Setpoint(velocity=np.array([3.0, 0.0, 0.0])), at([2, 0, 1.5], [3, 0, 0]), others)
    assert intervening
    assert out.velocity[0] < 0.0


def test_attitudes_are_passed_on() -> None:
    _, course = course_in(World())
    avoider, state = Potential(), at([0, 0, 1.5], [0, 0, 0])
    command = AttitudeSetpoint(np.array([0.0, 0.0, 0.0, 1.0]), 9.8)
    around = Surroundings(World())
    out, _ = avoider.step(avoider.start(course, around, state), command, state, around, PERIOD)
    assert out is command
