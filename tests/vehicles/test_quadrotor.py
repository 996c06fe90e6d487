"""The embedded quadrotor in flight: levels of command, the ground, and the limits of tilt and thrust."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError
from crosstrack.flight.loop import fly
from crosstrack.sim.airframe import AIRFRAMES
from crosstrack.types import (
    GRAVITY,
    Air,
    AttitudeSetpoint,
    Limits,
    Mismatch,
    Outcome,
    RateSetpoint,
    Setpoint,
    Wind,
)
from crosstrack.vehicles.quadrotor import Quadrotor, QuadrotorSession
from crosstrack.world.world import World

HERE = [[0, 0, 10], [50, 0, 10]]


def launched(airframe: Any = "generic", height: float = 10.0, **options: Any) -> QuadrotorSession:
    vehicle = Quadrotor(airframe)
    return vehicle.launch(plan_for([[0, 0, height], [50, 0, height]], vehicle=vehicle, **options).scenario)


def tilt(session: QuadrotorSession) -> float:
    x, y = session.truth().attitude[:2]
    return math.acos(1 - 2 * (x * x + y * y))


@pytest.mark.parametrize("airframe", AIRFRAMES)
def test_a_position_is_held_in_wind(airframe: str) -> None:
    session = launched(airframe, wind=Wind((3.0, -2.0, 0.0)))
    for _ in range(500):
        session.advance(Setpoint(position=np.array([1.0, -1.0, 12.0])), 0.02)
    np.testing.assert_allclose(session.truth().position, [1, -1, 12], atol=0.03)


@pytest.mark.parametrize("airframe", AIRFRAMES)
def test_an_attitude_and_a_thrust_are_flown(airframe: str) -> None:
    session = launched(airframe)
    roll = 0.3
    attitude = np.array([math.sin(roll / 2), 0, 0, math.cos(roll / 2)])
    for _ in range(25):
        session.advance(AttitudeSetpoint(attitude, 9.80665 / math.cos(roll)), 0.02)
    np.testing.assert_allclose(session.truth().attitude, attitude, atol=0.01)
    before = session.truth().velocity.copy()
    session.advance(AttitudeSetpoint(attitude, 9.80665 / math.cos(roll)), 0.02)
    push = (session.truth().velocity - before) / 0.02
    assert push[1] == pytest.approx(-9.80665 * math.tan(roll), rel=0.15)


@pytest.mark.parametrize("airframe", AIRFRAMES)
def test_rates_and_a_thrust_are_flown(airframe: str) -> None:
    session = launched(airframe)
    for _ in range(20):
        session.advance(RateSetpoint(np.array([0.3, -0.2, 0.5]), 9.80665), 0.02)
    np.testing.assert_allclose(session.truth().rate, [0.3, -0.2, 0.5], atol=0.02)


def test_a_component_left_free_is_still_and_the_others_are_flown() -> None:
    session = launched()
    for _ in range(300):
        session.advance(Setpoint(velocity=np.array([2.0, math.nan, math.nan])), 0.02)
    np.testing.assert_allclose(session.truth().velocity, [2, 0, 0], atol=0.05)


@pytest.mark.parametrize(("start", "asked"), [(3.0, -3.0), (-3.0, 3.0), (0.0, 2.5)])
def test_yaw_turns_the_short_way_round(start: float, asked: float) -> None:
    session = launched(yaw=start)
    turned = 0.0
    for _ in range(300):
        session.advance(Setpoint(velocity=np.zeros(3), yaw=asked), 0.02)
        turned += session.truth().rate[2] * 0.02
    short = math.remainder(asked - start, 2 * math.pi)
    assert turned == pytest.approx(short, abs=0.05)


def test_a_yaw_rate_is_held() -> None:
    session = launched()
    for _ in range(200):
        session.advance(Setpoint(velocity=np.zeros(3), yaw_rate=0.4), 0.02)
    assert session.truth().rate[2] == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("limit", [15.0, 30.0, 45.0])
def test_the_tilt_limit_holds(limit: float) -> None:
    session = launched(limits=Limits(tilt_deg=limit))
    most = 0.0
    for _ in range(100):
        session.advance(Setpoint(velocity=np.array([12.0, 0, 0])), 0.02)
        most = max(most, tilt(session))
    assert math.degrees(most) == pytest.approx(limit, abs=3)


def test_thin_air_carries_less() -> None:
    plan = plan_for(HERE)
    thin = replace(plan.scenario, air=replace(plan.scenario.air, pressure=70000.0))
    vehicle = Quadrotor()
    assert vehicle.envelope(thin).acceleration_vertical < vehicle.envelope(plan.scenario).acceleration_vertical
    session = vehicle.launch(thin)
    hover = AIRFRAMES["generic"].rotor_speed_hover * math.sqrt(101325 / 70000)
    for _ in range(100):
        session.advance(Setpoint(position=np.array([0.0, 0, 10])), 0.02)
    np.testing.assert_allclose(session.truth().rotor_speeds, hover, rtol=0.01)


def test_air_too_thin_to_fly_in_is_refused() -> None:
    with pytest.raises(InputError, match=r"too thin for generic: thrust to weight 0\.84"):
        plan_for(HERE, air=Air(pressure=50000.0))


@pytest.mark.parametrize(
    ("airframe", "speed", "limits"),
    [
        ("racer", 30.0, Limits(speed=30.0, acceleration=20.0, tilt_deg=60.0)),
        ("crazyflie", 30.0, Limits(speed=30.0)),
        ("generic", 20.0, Limits(speed=30.0)),
    ],
)
def test_what_is_planned_against_drag_is_flown(airframe: Any, speed: float, limits: Limits) -> None:
    route = [[0, 0, 10], [200, 0, 10], [200, 200, 10]]
    report = flown(route, vehicle=Quadrotor(airframe), speed=speed, limits=limits)
    assert report.arrived
    assert report.error.max() < 0.35
    assert report.time[-1] < 1.05 * report.flight.plan.course.speed.duration


@pytest.mark.parametrize("rate", [20.0, 100.0, 330.0, 1000.0])
def test_the_rate_of_commands_hardly_matters(rate: float) -> None:
    route = [[0, 0, 10], [10, 0, 10], [10, 10, 12]]
    usual, other = flown(route), flown(route, rate=rate)
    assert other.time[-1] == pytest.approx(usual.time[-1], abs=0.15)
    assert other.rms == pytest.approx(usual.rms, abs=0.01)


def test_it_takes_off_from_the_ground_and_lands_on_it() -> None:
    route = [[0, 0, 0], [0, 0, 5], [5, 0, 5], [5, 0, 0.15]]
    flight = fly(plan_for(route, speed=2.0))
    assert flight.outcome is Outcome.ARRIVED
    assert flight.record.position[0, 2] == pytest.approx(AIRFRAMES["generic"].gear)
    session = launched(height=2.0)
    for _ in range(250):
        session.advance(Setpoint(velocity=np.array([0.0, 0, -0.7])), 0.02)
    assert session.truth().position[2] == pytest.approx(AIRFRAMES["generic"].gear, abs=0.01)
    assert np.linalg.norm(session.truth().velocity) < 0.01
    assert not session.touched()


def test_a_fall_is_a_crash() -> None:
    session = launched(height=5.0)
    for _ in range(100):
        session.advance(RateSetpoint(np.zeros(3), 0.0), 0.02)
    assert session.touched()


def test_the_ground_may_be_anywhere() -> None:
    flight = fly(plan_for([[0, 0, 52], [5, 0, 52]], world=World(ground=50.0), speed=2.0))
    assert flight.outcome is Outcome.ARRIVED


def test_a_payload_is_carried_at_the_thrust_it_weighs() -> None:
    """Thrust asked for per nominal mass: with a fifth more, the same thrust accelerates 1/1.2 as much."""
    plan = plan_for([[0, 0, 10], [9, 0, 10]])
    session = plan.vehicle.launch(replace(plan.scenario, mismatch=Mismatch(mass=1.2)))
    level = session.truth().attitude
    for _ in range(10):
        session.advance(AttitudeSetpoint(level, 1.2 * GRAVITY), 0.02)
    assert session.truth().velocity[2] == pytest.approx(0, abs=0.02)
    for _ in range(10):
        session.advance(AttitudeSetpoint(level, 1.5 * GRAVITY), 0.02)
    before = session.truth().velocity[2]
    session.advance(AttitudeSetpoint(level, 1.5 * GRAVITY), 0.02)
    gained = (session.truth().velocity[2] - before) / 0.02
    drag = 0.1099301 * 1.225 * before**2 / 1.2
    assert gained == pytest.approx((1.5 / 1.2 - 1) * GRAVITY - drag, rel=0.02)


def test_drag_grows_by_the_mismatch() -> None:
    """At a steady speed on a level the tangent of the tilt is the drag over the weight."""
    slow = {}
    for factor in (1.0, 1.5):
        plan = plan_for([[0, 0, 50], [9, 0, 50]], vehicle=Quadrotor(airframe="racer"), limits=Limits(tilt_deg=60.0))
        session = plan.vehicle.launch(replace(plan.scenario, mismatch=Mismatch(drag=factor)))
        for _ in range(400):
            session.advance(Setpoint(velocity=np.array([6.0, 0, 0]), yaw=0.0), 0.02)
        tilt = Rotation.from_quat(session.truth().attitude).as_euler("ZYX")[1]
        slow[factor] = GRAVITY * math.tan(tilt)
    assert slow[1.5] / slow[1.0] == pytest.approx(1.5, rel=0.03)


def test_slow_motors_answer_later() -> None:
    speeds = {}
    for factor in (1.0, 3.0):
        plan = plan_for([[0, 0, 10], [9, 0, 10]], vehicle=Quadrotor(airframe="crazyflie"))
        session = plan.vehicle.launch(replace(plan.scenario, mismatch=Mismatch(motor_time=factor)))
        hover = session.truth().rotor_speeds.mean()
        session.advance(RateSetpoint(np.zeros(3), 1.4 * GRAVITY), 0.05)
        speeds[factor] = session.truth().rotor_speeds.mean() - hover
    end = hover * (math.sqrt(1.4) - 1)
    assert speeds[1.0] == pytest.approx(end * (1 - math.exp(-1)), rel=0.01)
    assert speeds[3.0] == pytest.approx(end * (1 - math.exp(-1 / 3)), rel=0.01)


def test_what_a_tracker_may_know_is_what_the_vehicle_does() -> None:
    """Thrust and drag of the model against flights in which nothing is mismatched."""
    plan = plan_for([[0, 0, 50], [9, 0, 50]], vehicle=Quadrotor(airframe="racer"), limits=Limits(tilt_deg=60.0))
    model = plan.course.envelope.model
    assert model is not None
    session = plan.vehicle.launch(plan.scenario)
    hover = session.truth().rotor_speeds
    assert model.thrust_factor * (hover @ hover) == pytest.approx(GRAVITY)
    for _ in range(400):
        session.advance(Setpoint(velocity=np.array([8.0, 0, 0]), yaw=0.0), 0.02)
    state = session.truth()
    turn = Rotation.from_quat(state.attitude)
    thrust = model.thrust_factor * (state.rotor_speeds @ state.rotor_speeds)
    air = turn.inv().apply(state.velocity)
    drag = -(model.drag * math.sqrt(thrust / GRAVITY) + model.drag_quadratic * np.abs(air)) * air
    total = turn.apply(drag + [0, 0, thrust]) - [0, 0, GRAVITY]
    np.testing.assert_allclose(total, 0, atol=0.03)
