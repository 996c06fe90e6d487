"""The regulator: Riccati equations against independent answers, the linear model against the nonlinear one, flights."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import lag, plan_along, rms, tour
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_lyapunov
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError
from crosstrack.flight.loop import fly
from crosstrack.sim.airframe import AIRFRAMES, SEA_LEVEL_DENSITY
from crosstrack.track.linear import INPUTS, STATES, dynamics
from crosstrack.track.lqr import Lqr
from crosstrack.track.reference import reference
from crosstrack.track.riccati import backwards, discretised, stationary
from crosstrack.track.schedule import at_thrust, by_thrust, by_time, hovering, staged
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import GRAVITY, Array, Limits, Mismatch, Model, Noise, Outcome, RateSetpoint, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor, model_of

CURVE = tour(5.0)
STILL = np.zeros(3)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
Q = np.array([0.2, 0.2, 0.2, 1.5, 1.5, 1.5, 0.4, 0.4, 1.0, np.inf, np.inf, np.inf, 0.25, 0.25, 0.25]) ** -2
R = np.array([1.2, 1.2, 1.0, 5.0]) ** -2


def known(airframe: str) -> Model:
    return model_of(AIRFRAMES[airframe], SEA_LEVEL_DENSITY, Limits(tilt_deg=70))


def linear(model: Model, thrust: float, rate: Any = STILL, air: Any = STILL) -> tuple[Array, Array]:
    a, b = np.empty((STATES, STATES)), np.empty((STATES, INPUTS))
    dynamics(thrust, tuple(rate), tuple(air), model.rate_time, model.drag, model.drag_quadratic, a, b)
    return a, b


@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
@pytest.mark.parametrize("period", [0.0025, 0.01, 0.02])
def test_the_infinite_horizon_is_stable_and_costs_what_it_says(airframe: str, period: float) -> None:
    a, b = discretised(*linear(known(airframe), GRAVITY), period)
    gain, cost = stationary(a, b, np.diag(Q), np.diag(R))
    closed = a - b @ gain
    assert np.abs(np.linalg.eigvals(closed)).max() < 1
    flown = solve_discrete_lyapunov(closed.T, np.diag(Q) + gain.T @ np.diag(R) @ gain)
    np.testing.assert_allclose(cost, flown, rtol=1e-6, atol=1e-6 * np.abs(cost).max())
    x = np.random.default_rng(4).normal(size=STATES)
    total, start = 0.0, x
    for _ in range(round(30 / period)):
        u = -gain @ x
        total += float(Q @ x**2 + R @ u**2)
        x = a @ x + b @ u
    assert total == pytest.approx(start @ cost @ start, rel=1e-6)


def test_a_long_finite_horizon_begins_with_the_infinite_one() -> None:
    a, b = discretised(*linear(known("racer"), GRAVITY), 0.02)
    gain, cost = stationary(a, b, np.diag(Q), np.diag(R))
    steps = 1500
    repeated = [np.repeat(value[None], steps, axis=0) for value in (a, b, Q, R)]
    gains, before = backwards(repeated[0], repeated[1], repeated[2], repeated[3], np.zeros_like(cost))
    np.testing.assert_allclose(gains[0], gain, atol=1e-6)
    np.testing.assert_allclose(before, cost, rtol=1e-6, atol=1e-6 * np.abs(cost).max())
    assert np.abs(gains[-1] - gain).max() > 0.1


@given(st.integers(0, 2**32 - 1))
def test_the_linear_model_is_the_slope_of_the_nonlinear_one(seed: int) -> None:
    """Errors from a turning reference in the air, by Newton's law with rotation matrices and central differences."""
    rng, model = np.random.default_rng(seed), known("racer")
    thrust, rate, air = rng.uniform(5, 30), rng.normal(size=3), rng.normal(size=3) * 5
    lagged = model.rate_time

    def force(c: float, turn: Rotation, v: Array) -> Array:
        u = turn.inv().apply(v)
        effort = math.sqrt(thrust / GRAVITY)  # the drag is that at the thrust of the reference
        return np.asarray(turn.apply([0, 0, c] - (effort * model.drag + model.drag_quadratic * np.abs(u)) * u))

    def change(x: Array, u: Array) -> Array:
        turn = Rotation.from_rotvec(x[6:9])  # the reference is at the identity at this instant
        pull = force(thrust + u[3], turn, air + x[3:6]) - force(thrust, Rotation.identity(), air)
        body = turn.inv().apply(rate) + x[9:12]
        # The reference's axes turn with `rate`, so what is seen in them turns the other way.
        p = x[3:6] - np.cross(rate, x[:3])
        a = pull - np.cross(rate, x[3:6])
        # R_e' = R_e (ω - R_eᵀ ω_r)^, differentiated through the logarithm.
        h = 1e-6
        ahead = turn * Rotation.from_rotvec(h * x[9:12])
        behind = turn * Rotation.from_rotvec(-h * x[9:12])
        angle = (ahead.as_rotvec() - behind.as_rotvec()) / (2 * h)
        slip = (turn.inv().apply(rate) + u[:3] - body) / lagged
        # d/dt R_eᵀ ω_r of a steady ω_r.
        slip = slip - (-np.cross(x[9:12], turn.inv().apply(rate)))
        return np.concatenate([p, a, angle, slip, x[:3] - np.cross(rate, x[12:15])])

    a, b = linear(model, thrust, rate, air)
    step = 1e-5
    for k in range(STATES):
        e = step * np.eye(STATES)[k]
        slope = (change(e, np.zeros(4)) - change(-e, np.zeros(4))) / (2 * step)
        np.testing.assert_allclose(a[:, k], slope, atol=2e-4)
    for k in range(INPUTS):
        e = step * np.eye(INPUTS)[k]
        slope = (change(np.zeros(STATES), e) - change(np.zeros(STATES), -e)) / (2 * step)
        np.testing.assert_allclose(b[:, k], slope, atol=2e-4)


@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_the_true_rate_loop_and_motors_late_by_40_ms_stay_stable(airframe: str) -> None:
    """The model has one lag for the rate loop; the vehicle has a rate loop around motors, and its estimate is late."""
    frame, model, period, dt, late = AIRFRAMES[airframe], known(airframe), 0.01, 0.0025, 16
    rate = 0.25 * 0.4 / model.rate_time
    gain, _ = hovering(model, GRAVITY, Q, np.array([rate, rate, 1, 5.0]) ** -2, period)
    # Sideways: position, velocity, tilt, rate, angular acceleration; and what is seen of them `late` steps ago.
    a = np.diag([1.0, GRAVITY, 1.0, frame.gains.rate], 1)
    a[4, 3] = a[4, 4] = -1 / frame.motor_time
    plant_a, plant_b = discretised(a, np.array([[0.0, 0, 0, 0, 1 / frame.motor_time]]).T, dt)
    k = gain[1, [0, 3, 7, 10]]
    x, total, asked = np.array([1.0, 0, 0, 0, 0]), 0.0, 0.0
    seen = [np.zeros(4)] * late
    largest = []
    for n in range(round(12 / dt)):
        if n % round(period / dt) == 0:
            asked = -float(k @ seen[0]) - float(gain[1, 12]) * total
            total += period * seen[0][0]
        x = plant_a @ x + plant_b[:, 0] * asked
        seen = [*seen[1:], x[:4].copy()]
        largest.append(abs(x[0]))
    assert max(largest[-800:]) < 0.1


def test_gains_by_thrust_go_with_it() -> None:
    """As much sideways acceleration and jerk is allowed at any thrust: gains of position go with 1/c, of tilt not."""
    model = replace(known("racer"), drag=STILL, drag_quadratic=STILL)
    low, high = (hovering(model, thrust, Q, R, 0.01)[0] for thrust in (6.0, 24.0))
    np.testing.assert_allclose(low[:2, [0, 1, 3, 4, 12, 13]], 4 * high[:2, [0, 1, 3, 4, 12, 13]], atol=1e-8)
    np.testing.assert_allclose(low[:2, 6:12], high[:2, 6:12], atol=1e-8)
    np.testing.assert_allclose(low[2:], high[2:], atol=1e-8)
    table = by_thrust(model, Q, R, 0.01)
    row = (12.0 - table.begin) / table.spacing
    k, share = int(row), row % 1
    between = (1 - share) * table.gains[k] + share * table.gains[k + 1]
    exact = staged(hovering(model, 12.0, Q, R, 0.01)[0][None], np.array([12.0]))[0]
    np.testing.assert_allclose(between, exact, atol=1e-8)


def test_stages_are_the_same_law() -> None:
    gain, _ = hovering(known("generic"), GRAVITY, Q, R, 0.01)
    stages = staged(gain[None], np.array([GRAVITY]))[0]
    x = np.random.default_rng(3).normal(size=STATES)
    outer = [*range(6), *range(12, 15)]
    force = -stages[:3, outer] @ x[outer]
    lean = np.array([-force[1] / GRAVITY, force[0] / GRAVITY, force[2]])
    rates = gain[:3, 6:9] @ (lean - x[6:9]) - gain[:3, 9:12] @ x[9:12]
    np.testing.assert_allclose(rates, -gain[:3] @ x, atol=1e-9)


def test_gains_by_time_are_those_of_the_infinite_horizon_at_rest() -> None:
    rest = PiecewisePolynomial(np.array([7.0]), np.array([[[1.0, 2.0, 9.0]] + [[0.0] * 3] * 7]))
    model = known("racer")
    table = by_time(reference(rest, 0.0), model, Q, R, 0.02)
    wanted = staged(hovering(model, GRAVITY, Q, R, 0.02)[0][None], np.array([GRAVITY]))[0]
    np.testing.assert_allclose(table.gains, np.broadcast_to(wanted, table.gains.shape), atol=1e-6)
    assert len(table.gains) == 351


def test_gains_by_time_know_where_the_trajectory_is_going() -> None:
    model = known("racer")
    table = by_time(reference(tour(12.0), 0.0), model, Q, R, 0.02)
    still = by_thrust(model, Q, R, 0.02)
    assert np.isfinite(table.gains).all()
    assert np.abs(table.gains[len(table.gains) // 2] - still.gains[2]).max() > 0.2
    assert table.gains.shape[1:] == (4, 15)


def deviated(law: Lqr, x: Array, period: float = 0.01) -> tuple[RateSetpoint, Model]:
    """Return what is asked of a racer off a hovering reference by errors x (12,)."""
    rest = PiecewisePolynomial(np.array([60.0]), np.array([[[1.0, 2.0, 9.0], [1e-9, 0, 0]] + [[0.0] * 3] * 6]))
    plan = plan_along(CURVE, law, vehicle=Quadrotor(airframe="racer"))
    course = replace(plan.course, trajectory=rest)
    model = course.envelope.model
    assert model is not None
    memory = law.start(course, State(0.0, rest(0.0), STILL, LEVEL, STILL))
    attitude = Rotation.from_rotvec(x[6:9]).as_quat()
    state = State(5.0, rest(5.0) + x[:3], x[3:6], attitude, x[9:12])
    command, _ = law.step(memory, course, state, period)
    return command, model


@pytest.mark.parametrize("horizon", ["infinite", "finite"])
def test_near_the_trajectory_the_law_is_the_gain_times_the_error(horizon: Any) -> None:
    rng = np.random.default_rng(7)
    law = Lqr(horizon=horizon, integral=False)
    for _ in range(5):
        x = 1e-4 * rng.normal(size=12)
        command, model = deviated(law, x)
        rate = law.rate_share * law.tilt_error / model.rate_time
        allowed = [0.2] * 3 + [1.5] * 3 + [0.4, 0.4, 1.0] + [np.inf] * 3
        q, r = np.array(allowed) ** -2, np.array([rate, rate, 1.0, 5.0]) ** -2
        gain, _ = hovering(model, GRAVITY, q, r, 0.01)
        u = -gain @ x
        np.testing.assert_allclose(command.rate, u[:3], atol=3e-5)
        assert command.thrust - GRAVITY == pytest.approx(u[3], abs=2e-5)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0, 3))
def test_commands_are_finite_and_within_limits_from_anywhere(seed: int, decade: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=12) * 10**decade
    command, model = deviated(ANY, x)
    assert np.hypot(*command.rate[:2]) <= model.rate_max * (1 + 1e-12)
    assert model.thrust_min <= command.thrust <= model.thrust_max


ANY = Lqr()


@pytest.mark.parametrize("offset", [(30.0, 0, 0), (-20, 20, 8), (0, 0, -8)])
def test_far_off_it_flies_back_without_tumbling(offset: Any) -> None:
    plan = plan_along(CURVE, Lqr(), vehicle=Quadrotor(airframe="generic"))
    off = replace(plan.scenario, position=plan.scenario.position + np.array(offset))
    flight = fly(replace(plan, scenario=off))
    assert flight.outcome is Outcome.ARRIVED
    up = 1 - 2 * (flight.record.attitude[:, 0] ** 2 + flight.record.attitude[:, 1] ** 2)
    assert np.degrees(np.arccos(up.min())) < 65 + 8
    assert lag(flight, CURVE)[flight.record.time > 7].max() < 0.1


def test_the_cost_of_tilt_is_of_sideways_acceleration() -> None:
    q, r = at_thrust(Q, R, np.array([GRAVITY, 2 * GRAVITY]))
    np.testing.assert_allclose(q[0], Q)
    np.testing.assert_allclose(q[1, 6:9], [4 * Q[6], 4 * Q[7], Q[8]])
    np.testing.assert_allclose(r[1], [4 * R[0], 4 * R[1], R[2], R[3]])


@pytest.mark.parametrize("horizon", ["infinite", "finite"])
def test_fast_flight_of_a_known_racer(horizon: Any) -> None:
    curve = tour(12.0)
    flight = fly(plan_along(curve, Lqr(horizon=horizon), vehicle=Quadrotor(airframe="racer"), rate=100))
    assert flight.outcome is Outcome.ARRIVED
    assert rms(lag(flight, curve)) < 0.05


@pytest.mark.parametrize("airframe", ["generic", "crazyflie", "racer"])
def test_wind_noise_delay_and_a_wrong_model(airframe: Any) -> None:
    noise = Noise(position=0.02, velocity=0.05, delay=0.02)
    wind = Wind(mean=(3.0, 4.0, 0.0), gusts="moderate")
    plan = plan_along(CURVE, Lqr(), vehicle=Quadrotor(airframe=airframe), wind=wind, noise=noise, rate=100)
    wrong = replace(plan, scenario=replace(plan.scenario, mismatch=Mismatch(mass=1.1, drag=1.2)))
    flight = fly(wrong)
    assert flight.outcome is Outcome.ARRIVED
    assert rms(lag(flight, CURVE)) < 0.25


def test_the_integral_meets_a_steady_wind() -> None:
    wind = Wind(mean=(3.0, 4.0, 0.0))
    errors = []
    for integral in (True, False):
        flight = fly(plan_along(CURVE, Lqr(integral=integral), vehicle=Quadrotor(airframe="racer"), wind=wind))
        errors.append(rms(lag(flight, CURVE)[flight.record.time > 3]))
    assert errors[0] < 0.25 * errors[1]


def test_memory_is_passed() -> None:
    law = Lqr()
    plan = plan_along(CURVE, law)
    state = State(0.0, CURVE(0.0) + [0.1, 0, 0], STILL, LEVEL, STILL)
    _, memory = law.step(law.start(plan.course, state), plan.course, state, 0.02)
    kept = memory.gathered.copy()
    late = replace(state, time=1.0)
    first, after = law.step(memory, plan.course, late, 0.02)
    again, _ = law.step(memory, plan.course, late, 0.02)
    np.testing.assert_array_equal(first.rate, again.rate)
    np.testing.assert_array_equal(memory.gathered, kept)
    assert np.abs(after.gathered - kept).max() > 0
    assert after.schedule is memory.schedule
    _, other = law.step(memory, plan.course, late, 0.01)
    assert other.schedule is not None
    assert other.schedule.period == 0.01


def test_weights_without_an_answer_are_said() -> None:
    law = Lqr(position_error=1e-30)
    plan = plan_along(CURVE, law)
    state = State(0.0, CURVE(0.0), STILL, LEVEL, STILL)
    with pytest.raises(InputError, match="too far apart"):
        law.step(law.start(plan.course, state), plan.course, state, 0.02)
