"""Pursuit with line of sight guidance: the rate of turn of the paper, and its equation on a straight path."""

import math
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosstrack.follow.proportional_los import ProportionalLos
from crosstrack.types import State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor

LEG = [[0, 0, 10], [60, 0, 10]]


def at(position: Any, velocity: Any) -> State:
    return State(0.0, np.array(position, float), np.array(velocity, float), np.array([0.0, 0, 0, 1]), np.zeros(3))


@given(st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(0.5, 4.0), st.floats(0.0, 2.0))
def test_the_rate_of_turn_is_that_of_the_paper(y: float, yaw: float, pursuit: float, line: float) -> None:
    """u = k1 (θ - ψ) + k2 d for small angles, with the aim at the angle θ and the path d to the left."""
    plan = plan_for(LEG, speed=5.0)
    distance = 6.0
    law = ProportionalLos(lookahead=distance, pursuit_gain=pursuit, line_gain=line)
    here = at([20, y, 10], 5 * np.array([math.cos(yaw), math.sin(yaw), 0]))
    command, _ = law.step(law.start(plan.course, here), plan.course, here, 0.02)
    left = -math.sin(yaw) * command.acceleration[0] + math.cos(yaw) * command.acceleration[1]
    k1, k2 = pursuit * 5 / distance, line * 5 / distance**2
    rate = k1 * (math.atan2(-y, distance) - yaw) + k2 * -y
    assert left / 5 == pytest.approx(rate, rel=0.02, abs=2e-3)


@pytest.mark.parametrize(("pursuit", "line"), [(2.5, 0.6), (2.0, 0.0), (3.0, 3.0)])
def test_on_a_straight_path_it_obeys_its_equation(pursuit: float, line: float) -> None:
    """Without dynamics, e'' + c1 V/L e' + (c1 + c2) V²/L² e = 0, in any plane through the path."""
    speed, distance = 4.0, 4.0
    law = ProportionalLos(lookahead=distance, pursuit_gain=pursuit, line_gain=line)
    report = flown(LEG, vehicle=Point(), speed=speed, start=(0.0, 0.3, 10.4), tracker=law, rate=200)
    w = speed / distance
    times = report.time[: len(report.time) // 2]
    solved = solve_ivp(
        lambda _, x: [x[1], -pursuit * w * x[1] - (pursuit + line) * w**2 * x[0]],
        (0, times[-1]),
        [0.5, 0.0],
        t_eval=times,
        rtol=1e-8,
    ).y[0]
    side = (report.position[: len(times), 1:] - [0, 10]) @ [0.6, 0.8]
    np.testing.assert_allclose(side, solved, atol=0.02)


@pytest.mark.parametrize("line", [0.6, 5.0])
@pytest.mark.parametrize("y", [3.0, 15.0, -40.0])
def test_far_off_it_flies_to_the_path_and_does_not_circle(y: float, line: float) -> None:
    law = ProportionalLos(line_gain=line)
    report = flown([[0, 0, 10], [120, 0, 10]], speed=5.0, start=(0.0, y, 10.0), tracker=law)
    assert report.arrived
    assert (np.diff(report.error[: int(np.argmin(report.error > 0.5))]) <= 1e-3).all()


def test_more_weight_on_the_line_comes_to_it_sooner() -> None:
    """The second gain is of use: it stiffens the law at the same angle gain."""
    errors = [
        flown(LEG, vehicle=Point(), speed=4.0, start=(0.0, 2.0, 10.0), tracker=ProportionalLos(5.0, 4.0, 4.0, c)).error
        for c in (0.0, 4.0)
    ]
    first = [int(np.argmax(error < 0.5)) for error in errors]
    assert first[1] < first[0]


@pytest.mark.parametrize("vehicle", [Point(), Quadrotor()])
def test_a_crosswind_leaves_no_offset(vehicle: Any) -> None:
    report = flown(
        [[0, 0, 10], [60, 0, 10]], vehicle=vehicle, speed=3.0, wind=Wind((0, 1.5, 0)), tracker=ProportionalLos()
    )
    assert report.arrived
    assert report.error[len(report.error) // 2 :].max() < 0.05
