"""Geometric and incremental tracking: what they ask for, and how closely quadrotors fly it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import NOMINAL, lag, plan_along, rms, tour
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError
from crosstrack.flight.loop import fly
from crosstrack.track.geometric import Geometric
from crosstrack.track.incremental import Incremental
from crosstrack.trajectory.flatness.flat import flatten
from crosstrack.trajectory.flatness.yaw import Fixed
from crosstrack.types import Array, Mismatch, Noise, Outcome, State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor

CURVE = tour(5.0)
WRONG = Mismatch(mass=1.1, drag=1.2)
HEAVY = Mismatch(mass=1.1)


def flown(tracker: Any, airframe: Any = "generic", mismatch: Mismatch = NOMINAL, **options: Any) -> tuple[Any, Array]:
    flight = fly(plan_along(CURVE, tracker, mismatch, vehicle=Quadrotor(airframe=airframe), **options))
    return flight, lag(flight, CURVE)


@pytest.mark.parametrize("law", [Geometric, Incremental])
@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_in_calm_air_a_known_vehicle_is_where_it_should_be(law: Any, airframe: str) -> None:
    flight, error = flown(law(), airframe)
    assert flight.outcome is Outcome.ARRIVED
    assert error.max() < 0.01


def test_what_is_asked_for_on_the_trajectory_is_its_flatness() -> None:
    """On the trajectory, without drag or periods, rates and thrust are those that flatness demands."""
    plan = plan_along(CURVE, Geometric(integral_gain=0.0))
    model = plan.course.envelope.model
    assert model is not None
    none = np.zeros(3)
    instant = replace(model, drag=none, drag_quadratic=none, rate_time=0.0, thrust_time=0.0)
    course = replace(plan.course, envelope=replace(plan.course.envelope, model=instant))
    law, level = Geometric(integral_gain=0.0), np.array([0.0, 0, 0, 1])
    memory = law.start(course, State(0.0, CURVE(0.0), none, level, none))
    for t in (0.8, 3.3, 6.1):
        flat = flatten(CURVE, np.array([t]), Fixed(0.0))
        state = State(t, CURVE(t), CURVE(t, 1), flat.attitude[0], flat.rate[0])
        command, _ = law.step(memory, course, state, 1e-9)
        np.testing.assert_allclose(command.rate, flat.rate[0], atol=1e-4)
        assert command.thrust == pytest.approx(flat.thrust[0], rel=1e-6)


@pytest.mark.parametrize("law", [Geometric, Incremental])
def test_commands_turn_with_the_world(law: Any) -> None:
    turn = Rotation.from_euler("z", 1.1)

    def asked(curve: Any, swing: Rotation) -> Any:
        plan = plan_along(curve, law())
        tilted = swing * Rotation.from_euler("xyz", [0.3, -0.2, 0.1])
        at = State(
            2.0,
            swing.apply(CURVE(2.0) + [0.3, -0.2, 0.1]),
            swing.apply(CURVE(2.0, 1) + [0.1, 0.4, 0.0]),
            tilted.as_quat(),
            np.array([0.1, 0.2, 0.3]),
            swing.apply([0.4, 0.1, -0.3]),
            np.full(4, 520.0),
        )
        first = replace(at, time=0.0, position=curve(0.0), attitude=swing.as_quat())
        memory = law().start(plan.course, first)
        for k in range(3):
            command, memory = law().step(memory, plan.course, replace(at, time=2.0 + 0.02 * k), 0.02)
        return command

    turned = replace(CURVE, coefficients=CURVE.coefficients @ turn.as_matrix().T)
    here, there = asked(CURVE, Rotation.identity()), asked(turned, turn)
    np.testing.assert_allclose(here.rate, there.rate, atol=1e-6)
    assert here.thrust == pytest.approx(there.thrust, abs=1e-6)


def test_outside_forces_are_met_by_what_is_measured() -> None:
    plain, _ = flown(Geometric(integral_gain=0.0), "racer", WRONG)
    _, integral = flown(Geometric(), "racer", WRONG)
    flight, incremental = flown(Incremental(), "racer", WRONG)
    assert flight.outcome is Outcome.ARRIVED
    assert rms(incremental) < 0.02
    assert rms(incremental) < 0.2 * rms(integral) < 0.2 * rms(lag(plain, CURVE))


def test_a_payload_leaves_an_offset_that_only_the_integral_takes_away() -> None:
    """Hovering with a tenth too much, thrust over mass is short by g/11: k_p holds it at g / 11 k_p below."""
    plan = plan_along(CURVE, Geometric(integral_gain=0.0, position_gain=4.0))
    plan = replace(plan, timeout=CURVE.duration + 6, scenario=replace(plan.scenario, mismatch=HEAVY))
    low = fly(plan).record.position[-1, 2] - CURVE(CURVE.duration)[2]
    assert low == pytest.approx(-9.80665 * 0.1 / 4.0, rel=0.02)
    flight, error = flown(Geometric(), mismatch=HEAVY)
    assert flight.outcome is Outcome.ARRIVED
    assert error[-1] < 0.05


def test_the_bound_of_the_integral_is_kept() -> None:
    plan = plan_along(CURVE, Geometric(integral_gain=50.0))
    law, none = Geometric(integral_gain=50.0), np.zeros(3)
    state = State(0.0, CURVE(0.0) + 4.0, none, np.array([0.0, 0, 0, 1]), none)
    memory = law.start(plan.course, state)
    for k in range(200):
        _, memory = law.step(memory, plan.course, replace(state, time=0.02 * k), 0.02)
    assert np.linalg.norm(memory.push) == pytest.approx(5.0)


@pytest.mark.parametrize("law", [Geometric, Incremental])
def test_wind_noise_and_delay_are_borne(law: Any) -> None:
    noise = Noise(position=0.02, velocity=0.05, acceleration=0.3, delay=0.02)
    flight, error = flown(law(), wind=Wind((3.0, 2.0, 0.0), "moderate"), noise=noise)
    assert flight.outcome is Outcome.ARRIVED
    assert rms(error) < 0.3


def test_what_is_needed_is_said() -> None:
    course = plan_along(CURVE, Geometric()).course
    none = np.zeros(3)
    blind = State(0.0, CURVE(0.0), none, np.array([0.0, 0, 0, 1]), none)
    with pytest.raises(InputError, match="does not measure acceleration and rotor speeds"):
        Incremental().start(course, blind)
    point = replace(course, envelope=replace(course.envelope, model=None))
    for law in (Geometric(), Incremental()):
        with pytest.raises(InputError, match="takes no attitudes or rates"):
            law.start(point, blind)
    assert Point().envelope(plan_along(CURVE).scenario).model is None
