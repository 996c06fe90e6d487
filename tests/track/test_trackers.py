"""What every tracker of trajectories must do, whatever its law; over all that are registered."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from flights import plan_for, rms

from crosstrack import registry
from crosstrack.errors import InputError
from crosstrack.flight.flight import Flight
from crosstrack.flight.loop import fly
from crosstrack.flight.metrics import tilt
from crosstrack.flight.plan import Plan
from crosstrack.mission.load import loads
from crosstrack.path.pace import course_of
from crosstrack.protocols import Scenario
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import (
    Array,
    AttitudeSetpoint,
    Command,
    Limits,
    Mismatch,
    Noise,
    Outcome,
    RateSetpoint,
    Setpoint,
    State,
    Wind,
)
from crosstrack.vehicles.quadrotor import Quadrotor

LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
GUSTS = Wind(mean=(2.0, 3.0, 0.0), gusts="moderate")
POOR = Noise(position=0.02, velocity=0.05, delay=0.02)


def trackers() -> Iterator[str]:
    """Return the names of those that follow trajectories."""
    for name in registry.names("tracker"):
        if "trajectory" in getattr(registry.find("tracker", name), "needs", ()):
            yield name


every_tracker = pytest.mark.parametrize("name", list(trackers()))


def calm(name: str) -> float:
    """Return the RMS error (m) allowed at 5 m/s in calm air; a vehicle asked for motions answers in its own time."""
    return 0.01 if "attitude" in registry.find("tracker", name).needs else 0.05


@dataclass(frozen=True)
class Turned:
    """A trajectory turned about the vertical through the origin."""

    curve: PiecewisePolynomial
    matrix: Array

    @property
    def duration(self) -> float:
        return self.curve.duration

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        return np.asarray(self.curve(t, order) @ self.matrix.T)


@cache
def bend(speed: float = 5.0) -> PiecewisePolynomial:
    """Up, round a bend and down again in 27 m, from rest to rest, with a top speed (m/s)."""
    points = np.array([[0.0, 0, 10], [8, 2, 11], [13, 8, 11], [8, 14, 10]])
    knots = np.array([0.0, 2.2, 3.6, 5.8])
    curve = minimum(points, knots, 4)
    top = float(np.linalg.norm(curve(np.linspace(0, curve.duration, 1000), 1), axis=1).max())
    return minimum(points, knots * top / speed, 4)


def plan_along(curve: Any, name: str, *, airframe: Any = "generic", **changes: Any) -> Plan:
    """Plan to fly a trajectory with a tracker; `changes` are of the scenario."""
    plan = plan_for(curve(np.linspace(0, curve.duration, 100)), vehicle=Quadrotor(airframe=airframe))
    scenario: Scenario = replace(plan.scenario, position=curve(0.0), **changes)
    course = course_of(curve, plan.vehicle.envelope(scenario))
    tracker = registry.find("tracker", name)()
    return replace(plan, scenario=scenario, course=course, tracker=tracker, timeout=curve.duration + 15)


def errors(flight: Flight) -> Array:
    """Return the distance to where the trajectory is, at every sample."""
    record, trajectory = flight.record, flight.plan.course.trajectory
    assert trajectory is not None
    return np.asarray(np.linalg.norm(record.position - trajectory(record.time - record.time[0]), axis=1))


def numbers(command: Command) -> Array:
    """Return a command as numbers."""
    if isinstance(command, RateSetpoint):
        return np.append(command.rate, command.thrust)
    if isinstance(command, AttitudeSetpoint):
        return np.append(command.attitude, command.thrust)
    assert isinstance(command, Setpoint)
    return np.concatenate([command.position, command.velocity, command.acceleration])


def hovering(plan: Plan) -> State:
    """Return the state of the vehicle at the start."""
    return plan.vehicle.launch(plan.scenario).sense()


@every_tracker
@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_tracks_at_5_metres_a_second_holds_the_end_and_arrives(name: str, airframe: str) -> None:
    curve = bend()
    flight = fly(plan_along(curve, name, airframe=airframe))
    assert flight.outcome is Outcome.ARRIVED
    assert rms(errors(flight)) < calm(name)
    assert flight.record.time[-1] == pytest.approx(curve.duration, abs=0.7)
    np.testing.assert_allclose(flight.record.position[-1], curve(curve.duration), atol=0.2)


@every_tracker
@pytest.mark.parametrize("rate", [100.0, 200.0])
def test_tracks_as_well_when_asked_more_often(name: str, rate: float) -> None:
    flight = fly(plan_along(bend(), name, airframe="racer", period=1 / rate))
    assert flight.outcome is Outcome.ARRIVED
    assert rms(errors(flight)) < calm(name)


@every_tracker
@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_gusts_noise_delay_and_a_wrong_model_are_borne(name: str, airframe: str) -> None:
    wrong = Mismatch(mass=1.1, drag=1.2)
    flight = fly(plan_along(bend(), name, airframe=airframe, wind=GUSTS, noise=POOR, mismatch=wrong))
    assert flight.outcome is Outcome.ARRIVED
    assert errors(flight).max() < 0.6
    assert tilt(flight.record.attitude).max() < math.radians(45 + 3)


@every_tracker
def test_takes_off_from_the_ground(name: str) -> None:
    mission = loads(
        f"{{start: {{position: [0, 0, 2], takeoff: true}}, route: [[0, 0, 3], [8, 0, 3], [12, 5, 4]], speed: 3,"
        f" tolerance: 1, planner: {{kind: minimum_snap}}, tracker: {{kind: {name}}}}}"
    )
    flight = fly(mission.build())
    assert flight.record.position[0, 2] < 0.15
    assert flight.outcome is Outcome.ARRIVED
    assert errors(flight).max() < 0.15


@every_tracker
def test_the_same_seed_flies_the_same(name: str) -> None:
    first, second = (fly(plan_along(bend(), name, wind=GUSTS, noise=POOR)) for _ in range(2))
    np.testing.assert_array_equal(first.record.position, second.record.position)


@every_tracker
def test_memory_is_passed(name: str) -> None:
    """A step depends on what it is given alone, not on steps in between."""
    plan = plan_along(bend(), name)
    state = replace(hovering(plan), position=plan.scenario.position + [0.4, -0.8, 0.3])
    memory = plan.tracker.start(plan.course, state)
    first, after = plan.tracker.step(memory, plan.course, state, 0.02)
    later = replace(state, time=1.0, velocity=np.array([1.0, 2.0, -0.5]))
    for _ in range(3):
        _, after = plan.tracker.step(after, plan.course, later, 0.02)
    again, _ = plan.tracker.step(memory, plan.course, state, 0.02)
    np.testing.assert_array_equal(numbers(first), numbers(again))


@every_tracker
def test_east_is_a_name_only(name: str) -> None:
    """The same flight turned about the vertical, wind and all, is the same flight turned."""
    angle = 1.234
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    blow = np.array([2.0, -1.0, 0.0])
    one = fly(plan_along(bend(), name, wind=Wind(mean=tuple(blow)))).record
    other = fly(plan_along(Turned(bend(), turn), name, wind=Wind(mean=tuple(turn @ blow)), yaw=angle)).record
    np.testing.assert_allclose(other.position, one.position @ turn.T, atol=1e-6)


@every_tracker
def test_tilts_no_further_than_the_mission_allows(name: str) -> None:
    """On a trajectory that asks for more than the limit."""
    curve, limits = bend(7.0), Limits(tilt_deg=25.0)
    asked = curve(np.linspace(0, curve.duration, 500), 2) + [0, 0, 9.80665]
    assert np.hypot(asked[:, 0], asked[:, 1]).max() > math.tan(math.radians(30)) * 9.80665
    flight = fly(plan_along(curve, name, limits=limits))
    assert tilt(flight.record.attitude).max() < math.radians(25 + 4)
    assert errors(flight).max() < 5.0


@every_tracker
@pytest.mark.parametrize(
    "odd",
    [
        {"position": np.array([300.0, -200.0, 50.0])},
        {"velocity": np.array([30.0, 20.0, -20.0])},
        {"attitude": np.array([1.0, 0.0, 0.0, 0.0])},
        {"attitude": np.array([math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)])},
        {"rate": np.array([20.0, -20.0, 10.0])},
        {"time": 500.0},
        {"time": -5.0},
        {"rotor_speeds": np.zeros(4)},
    ],
    ids=["far", "fast", "upside_down", "on_its_side", "spinning", "long_after", "before", "rotors_stopped"],
)
def test_commands_stay_finite_in_odd_states(name: str, odd: dict[str, Any]) -> None:
    plan = plan_along(bend(), name, airframe="racer")
    state = hovering(plan)
    memory = plan.tracker.start(plan.course, state)
    for _ in range(3):
        command, memory = plan.tracker.step(memory, plan.course, replace(state, **odd), 0.02)
        assert np.isfinite(numbers(command)).all()
        assert math.isfinite(memory.progress)
        assert np.isfinite(memory.aim).all()
        if isinstance(command, RateSetpoint | AttitudeSetpoint):
            assert command.thrust >= 0
        if isinstance(command, AttitudeSetpoint):
            assert np.linalg.norm(command.attitude) == pytest.approx(1.0)


@every_tracker
def test_comes_back_from_far_off(name: str) -> None:
    plan = plan_along(bend(), name)
    aside = replace(plan.scenario, position=plan.scenario.position + [-4.0, 6.0, 2.0])
    flight = fly(replace(plan, scenario=aside))
    assert flight.outcome is Outcome.ARRIVED


@every_tracker
def test_progress_never_runs_ahead_of_the_path(name: str) -> None:
    flight = fly(plan_along(bend(), name))
    length = flight.plan.course.path.length
    assert (np.diff(flight.record.progress) > -0.05).all()
    assert flight.record.progress[-1] == pytest.approx(length, abs=0.2)


@every_tracker
def test_without_a_trajectory_it_says_what_to_add(name: str) -> None:
    plan = replace(plan_for([[0, 0, 5], [9, 0, 5]]), tracker=registry.find("tracker", name)())
    with pytest.raises(InputError, match="add a `planner`"):
        fly(plan)
    with pytest.raises(InputError, match=f"{name} follows a trajectory: add a planner"):
        loads(f"{{start: {{position: [0, 0, 5]}}, route: [[9, 0, 5]], tracker: {{kind: {name}}}}}").build()


@every_tracker
def test_a_vehicle_without_attitudes_is_refused_where_they_are_needed(name: str) -> None:
    text = (
        "{start: {position: [0, 0, 5]}, route: [[9, 0, 5]], planner: {kind: minimum_snap}, vehicle: {kind: point},"
        f" tracker: {{kind: {name}}}}}"
    )
    with pytest.raises(InputError) as refused:
        loads(text).build()
    message = f"{name} commands attitudes or rates, which the vehicle point does not take"
    assert (message in str(refused.value)) == ("attitude" in registry.find("tracker", name).needs)
