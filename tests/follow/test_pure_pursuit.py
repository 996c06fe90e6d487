"""Pure pursuit: the circle of the paper, circles held, and the second-order equation on a straight path."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.guidance import Foot
from crosstrack.follow.pure_pursuit import PurePursuit, point_ahead
from crosstrack.follow.speed import SpeedProfile
from crosstrack.path.pieces import Pieces
from crosstrack.path.polyline import Polyline
from crosstrack.types import State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor

LEG = [[0, 0, 10], [60, 0, 10]]


def at(position: Any, velocity: Any) -> State:
    return State(0.0, np.array(position, float), np.array(velocity, float), np.array([0.0, 0, 0, 1]), np.zeros(3))


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-0.3, 0.3), st.floats(3.0, 6.0))
def test_the_acceleration_bends_the_flight_through_the_aim(y: float, z: float, yaw: float, speed: float) -> None:
    """The circle through the vehicle, tangent to its velocity, of the curvature commanded, passes through the aim."""
    plan = plan_for(LEG, speed=5.0)
    law = PurePursuit(lookahead=6.0)
    velocity = speed * np.array([math.cos(yaw), math.sin(yaw), 0])
    here = at([20, y, 10 + z], velocity)
    command, memory = law.step(law.start(plan.course, here), plan.course, here, 0.02)
    push = np.array(command.acceleration)
    assert push @ velocity == pytest.approx(0, abs=1e-6)
    curvature = np.linalg.norm(push) / speed**2
    if curvature < 1e-6:
        return
    centre = here.position + push / np.linalg.norm(push) / curvature
    assert np.linalg.norm(memory.aim - centre) == pytest.approx(1 / curvature, rel=1e-6)


@given(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4))
def test_in_the_plane_it_is_the_curvature_of_the_paper(y: float, yaw: float) -> None:
    """κ = 2 x / L² with x sideways in the frame of the vehicle."""
    plan = plan_for(LEG, speed=5.0)
    law = PurePursuit(lookahead=6.0)
    velocity = 5 * np.array([math.cos(yaw), math.sin(yaw), 0])
    here = at([20, y, 10], velocity)
    command, memory = law.step(law.start(plan.course, here), plan.course, here, 0.02)
    way = memory.aim - here.position
    sideways = -math.sin(yaw) * way[0] + math.cos(yaw) * way[1]
    left = -math.sin(yaw) * command.acceleration[0] + math.cos(yaw) * command.acceleration[1]
    assert left == pytest.approx(25 * 2 * sideways / (way @ way), abs=1e-6)


@pytest.mark.parametrize("radius", [5.0, 12.0])
def test_on_a_circle_it_asks_for_the_centripetal_acceleration(radius: float) -> None:
    circle = Pieces(
        np.array([[radius, 0, 10.0]]),
        np.array([[0, 1.0, 0]]),
        np.array([[-1.0, 0, 0]]),
        np.array([1 / radius]),
        np.array([2 * math.pi * radius]),
    )
    plan = plan_for(LEG, speed=4.0)
    course = replace(plan.course, path=circle, speed=SpeedProfile(np.array([0.0, circle.length]), np.array([4.0, 4.0])))
    here = at([radius, 0, 10], [0, 4, 0])
    law = PurePursuit(lookahead=3.0)
    command, _ = law.step(law.start(course, here), course, here, 0.02)
    assert command.acceleration[0] == pytest.approx(-16 / radius, rel=1e-6)


def test_on_a_straight_path_it_is_of_second_order() -> None:
    """With δ long beside the error, e'' + 2 V/δ e' + 2 V²/δ² e = 0."""
    lookahead, speed = 4.0, 4.0
    law = PurePursuit(lookahead=lookahead)
    leg = [[0, 0, 10], [60, 0, 10]]
    report = flown(leg, vehicle=Point(), speed=speed, start=(0.0, 0.5, 10.0), tracker=law, rate=200)
    rate = speed / lookahead
    expected = 0.5 * np.exp(-rate * report.time) * (np.cos(rate * report.time) + np.sin(rate * report.time))
    half = len(report.time) // 2
    np.testing.assert_allclose(report.position[:half, 1], expected[:half], atol=0.02)


def test_the_aim_stays_on_this_side_of_a_turn_back() -> None:
    path = Polyline([[0, 0, 10], [10, 0, 10], [0, 0, 10]])
    foot = Foot(9.0, path(9.0), path(9.0, 1), 5.0, np.zeros(3), 0.0, False)
    np.testing.assert_allclose(point_ahead(path, foot, 4.0), [13, 0, 10], atol=0.3)
    corner = Polyline([[0, 0, 10], [10, 0, 10], [10, 10, 10]])
    foot = Foot(9.0, corner(9.0), corner(9.0, 1), 5.0, np.zeros(3), 0.0, False)
    np.testing.assert_allclose(point_ahead(corner, foot, 4.0), [10, 3, 10], atol=1e-9)
    foot = Foot(18.0, corner(18.0), corner(18.0, 1), 5.0, np.zeros(3), 0.0, False)
    np.testing.assert_allclose(point_ahead(corner, foot, 4.0), [10, 12, 10], atol=1e-9)


@pytest.mark.parametrize("vehicle", [Point(), Quadrotor()])
def test_a_crosswind_leaves_no_offset(vehicle: Any) -> None:
    report = flown([[0, 0, 10], [60, 0, 10]], vehicle=vehicle, speed=3.0, wind=Wind((0, 1.5, 0)), tracker=PurePursuit())
    assert report.arrived
    assert report.error[len(report.error) // 2 :].max() < 0.05
