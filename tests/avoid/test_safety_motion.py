"""The motion that the safety layer expects of a vehicle, against integration in another way and the simulator."""

import math
from typing import Any

import numpy as np
import pytest
from flights import EXACT
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosstrack.avoid.safety_command import asked_by, keeps_upright
from crosstrack.avoid.safety_motion import ability, bound_for, moderate, move, started, strength
from crosstrack.avoid.safety_stopping import Escape, way_to_rest
from crosstrack.protocols import Scenario
from crosstrack.types import (
    GRAVITY,
    Air,
    Array,
    AttitudeSetpoint,
    Envelope,
    Limits,
    Noise,
    RateSetpoint,
    Setpoint,
    State,
    Wind,
)
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.world import World

UNKNOWN = np.full(3, np.nan)
BRAKE = Escape(np.zeros(3), 0.0)


def envelope(airframe: Any = "racer", noise: Noise = EXACT) -> Envelope:
    scenario = Scenario(np.zeros(3), 0.0, World(), 5.0, Limits(), Wind(), Air(), noise, 0.02, 1)
    return Quadrotor(airframe=airframe).envelope(scenario)


@given(st.integers(0, 2**32 - 1))
def test_what_it_is_bound_for_is_a_double_integrator(seed: int) -> None:
    random = np.random.default_rng(seed)
    able = ability(envelope(), 1.0)._replace(turn_rate=math.inf)
    motion = random.normal(size=(5, 3)) * np.array([[1.0], [1.0], [1.0], [5.0], [20.0]])
    motion[2:, 2] = 0.0
    u, h = random.normal(size=3) * (3, 3, 0), 1e-4
    q, w, later_q, later_w = (np.empty(3) for _ in range(4))
    bound_for(motion, able, q, w)
    for _ in range(1000):
        move(motion, u, h, able)
    bound_for(motion, able, later_q, later_w)
    assert later_w[:2] == pytest.approx((w + 0.1 * u)[:2], abs=5e-3)
    assert later_q[:2] == pytest.approx((q + 0.1 * w + 0.005 * u)[:2], abs=5e-3)


def test_three_lags_are_integrated_as_another_method_does() -> None:
    able = ability(envelope(), 1.0)._replace(turn_rate=math.inf)
    first, second, third = able.tilt_time, able.turn_time, able.spin_time

    def slope(_: float, y: Array) -> list[float]:
        _, v, a, j, s = y
        return [v, a, j, s, (((4.0 - a) / first - j) / second - s) / third]

    oracle = solve_ivp(slope, (0, 0.5), [0, 2.0, -3.0, 10.0, 0], rtol=1e-9, atol=1e-9).y[:, -1]
    motion = np.zeros((5, 3))
    motion[:4, 0] = 0, 2.0, -3.0, 10.0
    for _ in range(50):
        move(motion, np.array([4.0, 0, 0]), 0.01, able)
    assert motion[0, 0] == pytest.approx(oracle[0], abs=0.02)
    assert motion[1, 0] == pytest.approx(oracle[1], abs=0.1)


@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
@pytest.mark.parametrize("speed", [2.0, 5.0, 9.0])
def test_the_simulated_quadrotor_stops_where_it_is_expected_to(airframe: Any, speed: float) -> None:
    """Braked as the layer would, it comes to rest near the predicted point, and not beyond the reserve."""
    vehicle = Quadrotor(airframe=airframe)
    limits = Limits()
    scenario = Scenario(np.array([0.0, 0, 50]), 0.0, World(), 5.0, limits, Wind(), Air(), Noise(), 0.02, 1)
    able = ability(vehicle.envelope(scenario), 0.75)
    session: Any = vehicle.launch(scenario)
    for _ in range(150):
        session.advance(Setpoint(velocity=np.array([speed, 0, 0])), 0.02)
    begun, before, jerk = session.truth(), UNKNOWN, np.zeros(3)
    predicted = None
    for _ in range(250):
        state = session.truth()
        motion = started(state.position, state.velocity, state.acceleration, jerk, before, UNKNOWN, 0.02, able)
        way = way_to_rest(motion, UNKNOWN, 0.02, BRAKE, able)
        predicted = predicted or way
        session.advance(Setpoint(velocity=way.velocity, acceleration=way.asked), 0.02)
    assert predicted is not None
    assert predicted.rests
    gone = float(np.linalg.norm(session.truth().position[:2] - begun.position[:2]))
    assert float(np.linalg.norm(session.truth().velocity)) < 0.05
    assert gone == pytest.approx(predicted.length, rel=0.06, abs=0.06)


def test_braking_needs_the_closed_form_of_its_distance() -> None:
    """Without lag worth the name: v²/2b and the end in proportion, b/2k²."""
    able = ability(Envelope(20.0, 20.0, 8.0, 8.0, 0.02), 1.0)
    motion = np.zeros((5, 3))
    motion[1, 0] = 8.0
    way = way_to_rest(motion, UNKNOWN, 0.02, BRAKE, able)
    lag = 8.0 * 0.02
    assert way.length == pytest.approx(8.0**2 / 16 + lag + 8.0 / (2 * able.gain**2), abs=0.05)


def test_a_late_state_is_brought_forward() -> None:
    able = ability(envelope(noise=Noise(delay=0.1)), 1.0)
    still = np.zeros(3)
    motion = started(np.zeros(3), np.array([3.0, 0, 0]), still, still, UNKNOWN, still, 0.02, able)
    assert able.late == pytest.approx(0.1)
    assert motion[0] == pytest.approx([0.3, 0, 0])


def test_an_escape_turns_away_before_it_brakes() -> None:
    able = ability(envelope(), 0.75)
    motion = np.zeros((5, 3))
    motion[1] = 4.0, 2.0, 0.0
    way = way_to_rest(motion, UNKNOWN, 0.02, Escape(np.array([0.0, -1.0, 0.0]), 0.0), able)
    straight = way_to_rest(motion, UNKNOWN, 0.02, BRAKE, able)
    assert way.points[:, 1].max() < 0.8 * straight.points[:, 1].max()
    assert way.points[-1, 0] > straight.points[-1, 0]
    assert way.rests


def test_strength_is_that_of_an_ellipsoid() -> None:
    able = ability(envelope(), 1.0)
    assert strength(1.0, 0.0, 0.0, able) == pytest.approx(able.sideways)
    assert strength(0.0, 0.0, -1.0, able) == pytest.approx(able.vertical)
    assert able.vertical < strength(0.6, 0.0, 0.8, able) < able.sideways


@given(st.tuples(*[st.floats(-50.0, 50.0)] * 3))
def test_what_is_asked_for_beyond_the_ability_is_shortened_to_it(asked: tuple[float, float, float]) -> None:
    able = ability(envelope(), 1.0)
    wished = np.array(asked)
    flown = moderate(wished, able)
    size = np.linalg.norm(flown / (able.sideways, able.sideways, able.vertical))
    assert size <= 1.0 + 1e-9
    assert np.cross(flown, wished) == pytest.approx(np.zeros(3), abs=1e-6)
    if size < 1.0 - 1e-6:
        assert flown == pytest.approx(wished)


def level() -> State:
    return State(0.0, np.zeros(3), np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))


def test_commands_of_every_level_ask_for_an_acceleration() -> None:
    able = ability(envelope(), 1.0)
    hover = AttitudeSetpoint(np.array([0.0, 0, 0, 1]), GRAVITY)
    assert asked_by(hover, level(), able, 0.02) == pytest.approx(np.zeros(3))
    leant = AttitudeSetpoint(np.array([0.0, math.sin(0.1), 0, math.cos(0.1)]), GRAVITY / math.cos(0.2))
    assert asked_by(leant, level(), able, 0.02) == pytest.approx([GRAVITY * math.tan(0.2), 0, 0])
    pitching = RateSetpoint(np.array([0.0, 2.0, 0.0]), GRAVITY)
    assert asked_by(pitching, level(), able, 0.02)[0] > 0.5
    assert asked_by(Setpoint(acceleration=np.array([1.0, 2, 3])), level(), able, 0.02) == pytest.approx([1, 2, 3])
    assert asked_by(Setpoint(), level(), able, 0.02) == pytest.approx(np.zeros(3))


def test_height_comes_before_sideways_motion() -> None:
    able = ability(envelope("crazyflie"), 1.0)
    asked = asked_by(Setpoint(acceleration=np.array([9.0, 0, 8.6])), level(), able, 0.02)
    assert asked[0] < 1.0
    assert asked[2] == pytest.approx(able.thrust_max - GRAVITY, abs=0.3)


def test_a_vehicle_is_not_turned_over() -> None:
    assert keeps_upright(RateSetpoint(np.array([5.0, 0, 0]), GRAVITY), level(), 0.1)
    assert not keeps_upright(RateSetpoint(np.array([20.0, 0, 0]), GRAVITY), level(), 0.1)
    assert not keeps_upright(AttitudeSetpoint(np.array([1.0, 0, 0, 0]), GRAVITY), level(), 0.1)
