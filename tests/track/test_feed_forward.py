"""The feed-forward tracker: what it asks for, and how closely the embedded quadrotor flies it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from flights import lag, plan_along, plan_for, rms, tour

from crosstrack.errors import InputError
from crosstrack.flight.flight import Flight
from crosstrack.flight.loop import fly
from crosstrack.follow.carrot import Carrot
from crosstrack.track.feed_forward import FeedForward
from crosstrack.trajectory.flatness.yaw import Faced, Fixed, along_velocity
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Outcome, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor


def beside(flight: Flight) -> Array:
    """Return the distances (n,) m of every 20th position to the path."""
    fine = flight.plan.course.path(np.linspace(0, flight.plan.course.path.length, 20_000))
    return np.array([np.linalg.norm(fine - p, axis=1).min() for p in flight.record.position[::20]])


@pytest.mark.parametrize(("speed", "worst"), [(2.0, 0.01), (5.0, 0.02), (10.0, 0.04)])
def test_it_flies_the_trajectory_on_time(speed: float, worst: float) -> None:
    curve = tour(speed)
    flight = fly(plan_along(curve))
    assert flight.outcome is Outcome.ARRIVED
    assert lag(flight, curve).max() < worst
    assert flight.record.time[-1] <= curve.duration + 0.1


def test_looking_ahead_halves_the_error_at_speed() -> None:
    curve = tour(10.0)
    ahead, late = (rms(lag(fly(plan_along(curve, FeedForward(lead=lead))), curve)) for lead in (1.0, 0.0))
    assert ahead < 0.5 * late


def test_wind_and_every_airframe() -> None:
    curve = tour(5.0)
    for airframe in ("generic", "crazyflie", "racer"):
        flight = fly(plan_along(curve, vehicle=Quadrotor(airframe=airframe), wind=Wind(mean=(2.0, 3.0, 0.0))))
        assert flight.outcome is Outcome.ARRIVED
        error = lag(flight, curve)
        assert error.max() < 0.15  # the wind is there at once, and the autopilot has yet to learn it
        assert error[flight.record.time > 2.0].max() < 0.025


def test_the_setpoint_is_the_trajectory_ahead() -> None:
    curve = tour(5.0)
    plan = plan_along(curve)
    law, envelope = FeedForward(), plan.course.envelope
    state = State(3.0, curve(0.0), np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))
    memory = law.start(plan.course, state)
    later = replace(state, time=7.0, position=curve(3.9), velocity=curve(3.9, 1))
    for _ in range(99):  # progress catches up where the vehicle really is
        command, memory = law.step(memory, plan.course, later, 0.1)
    np.testing.assert_allclose(command.position, curve(4.05))
    np.testing.assert_allclose(command.velocity, curve(4.05, 1))
    np.testing.assert_allclose(command.acceleration, curve(4.05 + envelope.response_time, 2))
    assert math.isnan(command.yaw)
    assert math.isnan(command.yaw_rate)
    np.testing.assert_allclose(memory.aim, curve(4.0))
    np.testing.assert_allclose(plan.course.path(memory.progress), curve(3.9), atol=1e-6)


def test_after_the_end_the_last_point_is_held() -> None:
    speeding = PiecewisePolynomial(np.array([1.0]), np.array([[[0.0, 0, 5], [4.0, 0, 0], [1.0, 0, 0]]]))
    plan = plan_along(speeding)
    state = State(0.0, np.array([0.0, 0, 5]), np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))
    law = FeedForward()
    command, _ = law.step(law.start(plan.course, state), plan.course, replace(state, time=3.0), 0.02)
    np.testing.assert_allclose(command.position, [5, 0, 5])
    np.testing.assert_array_equal(command.velocity, 0)
    np.testing.assert_array_equal(command.acceleration, 0)


def test_yaw_is_flown_where_the_trajectory_has_one() -> None:
    curve = tour(5.0)
    for yaw, bound in ((Fixed(1.2), 0.03), (along_velocity(curve), 0.12)):
        plan = plan_along(Faced(curve, yaw), yaw=float(yaw(0.0)))
        record = fly(plan).record
        x, y, z, w = record.attitude.T
        heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        off = np.angle(np.exp(1j * (heading - yaw(record.time - record.time[0]))))
        assert np.abs(off).max() < bound


def test_without_a_trajectory_it_says_what_to_add() -> None:
    plan = plan_for([[0, 0, 5], [9, 0, 5]], tracker=FeedForward())
    with pytest.raises(InputError, match="add a `planner`"):
        fly(plan)


@pytest.mark.parametrize("speed", [2.0, 10.0])
def test_a_path_follower_flies_the_same_course(speed: float) -> None:
    curve = tour(speed)
    flight = fly(plan_along(curve, Carrot()))
    assert flight.outcome is Outcome.ARRIVED
    assert beside(flight).max() < 0.05
    assert flight.record.time[-1] == pytest.approx(curve.duration, rel=0.1)


def test_a_path_follower_gets_past_stops_and_turns_on_the_spot() -> None:
    there = minimum(np.array([[0.0, 0, 9], [12, 0, 9]]), np.array([0.0, 5.0]), 4)
    back = minimum(np.array([[12.0, 0, 9], [0, 0, 9]]), np.array([0.0, 5.0]), 4)
    aside = minimum(np.array([[0.0, 0, 9], [0, 8, 11]]), np.array([0.0, 5.0]), 4)
    curve = PiecewisePolynomial(
        np.concatenate([leg.durations for leg in (there, back, aside)]),
        np.concatenate([leg.coefficients for leg in (there, back, aside)]),
    )
    for tracker in (Carrot(), FeedForward()):
        flight = fly(plan_along(curve, tracker))
        assert flight.outcome is Outcome.ARRIVED
        assert flight.record.position[:, 0].max() > 11.9
        assert flight.record.progress[-1] == pytest.approx(flight.plan.course.path.length, abs=0.2)
        assert beside(flight).max() < 0.1
