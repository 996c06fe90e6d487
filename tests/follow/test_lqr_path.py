"""LQR path following: gains against the Riccati equation, and the law in closed loop."""

import math

import numpy as np
import pytest
from conftest import Steady
from flights import flown
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_continuous_are

from crosstrack.follow.lqr_path import LqrPath
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.types import Envelope, Setpoint, State, Wind
from crosstrack.vehicles.point import Point

ABLE = Envelope(20.0, 20.0, 200.0, 200.0, 0.01)


@given(st.floats(0, 0.7), st.floats(0.5, 8), st.floats(0, 4))
def test_the_gains_are_those_of_the_riccati_equation(error: float, frequency: float, weight: float) -> None:
    """Of the double integrator, with the error weighed by ω⁴ d_b / (d_b - d) and its rate by q2."""
    law = LqrPath(rate_weight=weight, error_bound=1.0, stiffening=4.0)
    a, b = np.array([[0.0, 1], [0, 0]]), np.array([[0.0], [1]])
    q = np.diag([frequency**4 / (1 - error), weight * frequency**2])
    expected = b.T @ solve_continuous_are(a, b, q, np.eye(1))
    np.testing.assert_allclose(law.gains(error, frequency), expected[0], rtol=1e-6)


def test_stiffness_grows_towards_the_bound_and_no_further() -> None:
    law = LqrPath(error_bound=2.0, stiffening=9.0)
    gains = [law.gains(error, 2.0)[0] for error in np.linspace(0, 5, 60)]
    assert gains == sorted(gains)
    assert gains[0] == pytest.approx(4.0)
    assert gains[-1] == pytest.approx(4.0 * 3.0)


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(2, 9), st.floats(-1e-3, 1e-3))
def test_the_command_is_the_regulators(y: float, z: float, v: float, slope: float) -> None:
    """u = -(k1 d + k2 ḋ) with d in space; along the course flown in full, for small slopes."""
    path = Polyline([[0, 0, 10], [100, 0, 10]])
    course = Course(path, Steady(v, path.length), ABLE, corners=path.points)
    velocity = v * np.array([math.cos(slope), math.sin(slope), 0])
    here = State(0.0, np.array([20.0, y, 10 + z]), velocity, np.array([0.0, 0, 0, 1]), np.zeros(3))
    law = LqrPath(bandwidth=2.0, reaction=100.0)
    command, _ = law.step(law.start(course, here), course, here, 0.02)
    assert isinstance(command, Setpoint)
    stiffness, damping = law.gains(math.hypot(y, z), 2.0)
    expected = [-stiffness * y - damping * v * math.sin(slope), -stiffness * z]
    np.testing.assert_allclose(command.acceleration[1:], expected, atol=0.02)


def test_a_vehicle_that_starts_backwards_turns_round() -> None:
    report = flown([[0, 0, 10], [60, 0, 10]], vehicle=Point(), speed=3.0, yaw=math.pi, tracker=LqrPath())
    assert report.arrived
    assert report.error.max() < 4


def test_it_keeps_within_its_bound_in_wind_and_gusts() -> None:
    """The error stays within the bound from the first time that it is inside."""
    law = LqrPath(error_bound=0.3)
    report = flown(
        [[0, 0, 20], [80, 0, 20]], wind=Wind((0.0, 2.5, 0.0), "moderate"), start=(0.0, 1.0, 20.0), tracker=law
    )
    inside = np.flatnonzero(report.error < 0.3)[0]
    assert report.arrived
    assert report.error[inside:].max() < 0.3


def test_far_off_it_comes_in_at_45_degrees_and_brakes_in_time() -> None:
    report = flown([[0, 0, 30], [150, 0, 30]], speed=8.0, start=(5.0, 30.0, 30.0), tracker=LqrPath())
    velocity = report.flight.record.velocity
    far = (report.position[:, 1] > 12) & (report.speed > 7)
    assert far.any()
    np.testing.assert_allclose(-velocity[far, 1] / velocity[far, 0], 1.0, atol=0.2)
    assert report.position[:, 1].min() > -0.3
