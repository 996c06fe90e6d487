"""The cascade: its loops against closed forms, what it asks for, and flights."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import lag, plan_along, rms, tour
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from crosstrack.flight.loop import fly
from crosstrack.protocols import Course
from crosstrack.track.attitude import axes_of
from crosstrack.track.cascaded_pid import CascadedPid, PidMemory, quaternion_into
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import GRAVITY, Array, Mismatch, Noise, Outcome, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor

CURVE = tour(5.0)
STILL = np.zeros(3)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
REST = PiecewisePolynomial(np.array([60.0]), np.array([[[0.0, 0.0, 9.0]] + [[0.0] * 3] * 7]))


def course_of_rest(drag: bool = False, trajectory: Any = REST, airframe: Any = "racer") -> Course:
    """Return a course whose trajectory is another, for a vehicle whose drag is not known."""
    course = plan_along(CURVE, CascadedPid(), vehicle=Quadrotor(airframe=airframe)).course
    model = course.envelope.model
    assert model is not None
    model = model if drag else replace(model, drag=STILL, drag_quadratic=STILL)
    return replace(course, trajectory=trajectory, envelope=replace(course.envelope, model=model))


def gains(law: CascadedPid, course: Course, period: float) -> tuple[float, float, float]:
    damp = law.velocity_gain / (course.envelope.response_time + 0.5 * period)
    stiff = law.position_gain * damp
    return stiff, damp, law.integral_gain * stiff * damp


def begun(law: CascadedPid, course: Course) -> PidMemory:
    assert course.trajectory is not None
    return law.start(course, State(0.0, course.trajectory(0.0), STILL, LEVEL, STILL))


@given(st.integers(0, 2**32 - 1))
def test_axes_become_the_quaternion_they_came_from(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=rng) if seed % 3 else Rotation.from_rotvec([0, 0, math.pi * (seed % 2)])
    out = np.empty(4)
    quaternion_into(axes_of(turn.as_quat()), out)
    assert np.linalg.norm(out) == pytest.approx(1, abs=1e-12)
    assert (Rotation.from_quat(out) * turn.inv()).magnitude() < 1e-7


@pytest.mark.parametrize("integral", [0.0, 0.4])
def test_the_step_response_of_a_double_integrator(integral: float) -> None:
    """A vehicle that flies what it is asked at once, a little off: x'' = k_v e + k_i ∫ e, e = -k_p x - x'."""
    law, period = CascadedPid(integral_gain=integral), 0.001
    course = course_of_rest()
    stiff, damp, gather = gains(law, course, period)
    position, velocity, memory = np.array([0.05, -0.08, 9.02]), np.zeros(3), begun(law, course)
    start, attitude = position - [0, 0, 9.0], LEVEL
    a = np.array([[0.0, 1, 0], [-damp * stiff, -damp, gather], [-stiff, -1, 0]])
    for k in range(3001):
        if k % 500 == 0 and k:
            wanted = expm(a * k * period) @ np.stack([start, STILL, STILL])
            np.testing.assert_allclose(position - [0, 0, 9.0], wanted[0], atol=4e-4)
        state = State(k * period, position, velocity, attitude, STILL)
        for _ in range(2):  # the thrust is for the attitude flown, so ask again in the attitude asked for
            command, after = law.step(memory, course, replace(state, attitude=attitude), period)
            attitude = command.attitude
        memory = after
        pull = Rotation.from_quat(attitude).apply([0, 0, command.thrust]) - [0, 0, GRAVITY]
        position = position + period * velocity + 0.5 * period**2 * pull
        velocity = velocity + period * pull


@given(st.integers(0, 2**32 - 1))
def test_z_points_along_the_force_that_is_needed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    law, course, period = CascadedPid(), COURSE, 0.02
    stiff, damp, _ = gains(law, course, period)
    off, velocity = rng.normal(size=3) * 0.1, rng.normal(size=3) * 0.2
    turn = Rotation.from_rotvec(rng.normal(size=3) * 0.2)
    state = State(1.0, np.array([0.0, 0, 9.0]) + off, velocity, turn.as_quat(), STILL)
    command, _ = law.step(begun(law, course), course, state, period)
    force = damp * (-stiff * off - velocity) + [0, 0, GRAVITY]
    asked = Rotation.from_quat(command.attitude)
    np.testing.assert_allclose(asked.apply([0, 0, 1]), force / np.linalg.norm(force), atol=1e-9)
    x = asked.apply([1, 0, 0])
    assert abs(x[1]) < 1e-9  # the yaw at the start, east, is held
    assert x[0] > 0
    assert command.thrust == pytest.approx(force @ turn.apply([0, 0, 1]), rel=1e-9)


COURSE = course_of_rest()


def test_attitude_and_thrust_are_those_of_the_time_they_are_flown() -> None:
    """On a fast curve without errors or drag, attitude leads by its own time, thrust by its own."""
    curve, law, period, t = tour(10.0), CascadedPid(), 0.02, 3.0
    course = course_of_rest(trajectory=curve)
    model = course.envelope.model
    assert model is not None
    later = curve(t + 0.5 * period + model.attitude_time, 2) + [0, 0, GRAVITY]
    soon = curve(t + 0.5 * period + model.thrust_time, 2) + [0, 0, GRAVITY]
    turn = Rotation.from_rotvec([0.1, -0.2, 0.3])
    state = State(t, curve(t), curve(t, 1), turn.as_quat(), STILL)
    command, _ = law.step(begun(law, course), course, state, period)
    z = Rotation.from_quat(command.attitude).apply([0, 0, 1])
    np.testing.assert_allclose(z, later / np.linalg.norm(later), atol=1e-6)
    assert command.thrust == pytest.approx(soon @ turn.apply([0, 0, 1]), abs=1e-5)


def test_the_derivative_is_the_slope_of_the_velocity_error() -> None:
    """Under a steady acceleration of the error the filtered slope becomes it, and the force gives way by k_d of it."""
    period, slope = 0.01, np.array([0.3, -0.2, 0.1])
    forces = []
    for share in (0.0, 0.5):
        law = CascadedPid(derivative_gain=share, integral_gain=0.0)
        memory = begun(law, COURSE)
        for k in range(300):
            # A velocity error that grows steadily, with the position error that would hide it left out.
            state = State(k * period, np.array([0.0, 0, 9.0]), slope * (k * period - 3.0), LEVEL, STILL)
            command, memory = law.step(memory, COURSE, state, period)
        z = Rotation.from_quat(command.attitude).apply([0, 0, 1])
        forces.append(z * command.thrust / z[2])
    np.testing.assert_allclose(forces[1] - forces[0], -0.5 * slope, atol=1e-6)


def test_held_back_it_does_not_wind_up() -> None:
    """A vehicle that cannot move for 20 s, 50 m off: along what limits refuse nothing is gathered."""
    law = CascadedPid()
    memory = begun(law, COURSE)
    for k in range(1000):
        state = State(k * 0.02, np.array([-50.0, 0.0, 9.0]), STILL, LEVEL, STILL)
        command, memory = law.step(memory, COURSE, state, 0.02)
    assert abs(memory.held[0]) < 1e-6
    tilt = Rotation.from_quat(command.attitude).apply([0, 0, 1])
    model = COURSE.envelope.model
    assert model is not None
    assert math.acos(tilt[2]) == pytest.approx(model.tilt_max, abs=1e-6)
    # A little off it gathers.
    state = State(20.0, np.array([-0.1, 0.0, 9.0]), STILL, LEVEL, STILL)
    _, memory = law.step(memory, COURSE, state, 0.02)
    assert memory.held[0] > 1e-3


@given(st.integers(0, 2**32 - 1), st.floats(0, 4))
def test_commands_are_within_limits_from_anywhere(seed: int, decade: float) -> None:
    rng = np.random.default_rng(seed)
    attitude = Rotation.random(random_state=rng).as_quat()
    offset, velocity = (rng.normal(size=3) * 10**decade for _ in range(2))
    state = State(rng.uniform(0, 80), offset, velocity, attitude, rng.normal(size=3) * 10)
    law, model = CascadedPid(derivative_gain=0.2), DRAGGED.envelope.model
    assert model is not None
    command, _ = law.step(begun(law, DRAGGED), DRAGGED, state, 0.02)
    z = Rotation.from_quat(command.attitude).apply([0, 0, 1])
    assert math.acos(z[2]) <= model.tilt_max + 1e-6
    assert model.thrust_min <= command.thrust <= model.thrust_max


DRAGGED = course_of_rest(drag=True)


def test_commands_turn_with_the_world() -> None:
    swing, law = Rotation.from_euler("z", 2.1), CascadedPid()

    def asked(curve: Any, turn: Rotation) -> tuple[Rotation, float]:
        course, tilted = course_of_rest(drag=True, trajectory=curve), turn * Rotation.from_rotvec([0.3, -0.2, 0.1])
        first = State(0.0, curve(0.0), STILL, turn.as_quat(), STILL)
        at = State(2.0, turn.apply(CURVE(2.0) + [0.3, -0.2, 0.1]), turn.apply([3.0, 1.0, 0.2]), tilted.as_quat(), STILL)
        memory = law.start(course, first)
        for k in range(3):
            command, memory = law.step(memory, course, replace(at, time=2 + 0.02 * k), 0.02)
        return Rotation.from_quat(command.attitude), command.thrust

    turned = replace(CURVE, coefficients=CURVE.coefficients @ swing.as_matrix().T)
    (here, lift), (there, same) = asked(CURVE, Rotation.identity()), asked(turned, swing)
    assert ((swing * here).inv() * there).magnitude() < 1e-6
    assert lift == pytest.approx(same, abs=1e-6)


def test_memory_is_passed() -> None:
    law, state = CascadedPid(), State(1.0, np.array([0.2, 0.1, 9.0]), STILL, LEVEL, STILL)
    _, memory = law.step(begun(law, COURSE), COURSE, state, 0.02)
    kept = memory.held.copy()
    first, after = law.step(memory, COURSE, replace(state, time=1.1), 0.02)
    again, _ = law.step(memory, COURSE, replace(state, time=1.1), 0.02)
    np.testing.assert_array_equal(first.attitude, again.attitude)
    np.testing.assert_array_equal(memory.held, kept)
    assert np.abs(after.held - kept).max() > 0


def test_far_off_it_flies_back_without_tumbling() -> None:
    plan = plan_along(CURVE, CascadedPid(), vehicle=Quadrotor(airframe="generic"))
    off = replace(plan.scenario, position=plan.scenario.position + np.array([-20, 20, 8]))
    flight = fly(replace(plan, scenario=off))
    assert flight.outcome is Outcome.ARRIVED
    up = 1 - 2 * (flight.record.attitude[:, 0] ** 2 + flight.record.attitude[:, 1] ** 2)
    assert np.degrees(np.arccos(up.min())) < 65 + 8
    assert lag(flight, CURVE)[flight.record.time > 7].max() < 0.1


def flown(law: CascadedPid, curve: Any, airframe: Any, mismatch: Any = None, **options: Any) -> tuple[Any, Array]:
    plan = plan_along(curve, law, vehicle=Quadrotor(airframe=airframe), rate=100, **options)
    plan = replace(plan, scenario=replace(plan.scenario, mismatch=mismatch or Mismatch()))
    flight = fly(plan)
    assert flight.outcome is Outcome.ARRIVED
    return flight, lag(flight, curve)


@pytest.mark.parametrize(
    ("airframe", "speed", "bound"), [("generic", 5, 0.01), ("crazyflie", 4, 0.01), ("racer", 12, 0.04)]
)
def test_calm_flights(airframe: str, speed: float, bound: float) -> None:
    _, error = flown(CascadedPid(), tour(speed), airframe)
    assert rms(error) < bound


@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_wind_noise_delay_and_a_wrong_model(airframe: str) -> None:
    noise = Noise(position=0.02, velocity=0.05, delay=0.02)
    wind = Wind(mean=(3.0, 4.0, 0.0), gusts="moderate")
    _, error = flown(CascadedPid(), CURVE, airframe, Mismatch(mass=1.1, drag=1.2), wind=wind, noise=noise)
    assert rms(error) < 0.3


def test_the_integral_meets_a_steady_wind() -> None:
    wind = Wind(mean=(3.0, 4.0, 0.0))
    (flight, held), (_, left) = (
        flown(CascadedPid(integral_gain=gain), CURVE, "racer", wind=wind) for gain in (0.4, 0.0)
    )
    late = flight.record.time > 4
    assert rms(held[late]) < 0.25 * rms(left[: len(held)][late[: len(left)]])
