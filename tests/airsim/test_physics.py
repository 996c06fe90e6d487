"""The rigid body of AirSim's quadrotor against closed forms, conservation laws and an independent integrator."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from crosstrack.airsim.firmware import air, airframe
from crosstrack.airsim.firmware.kernel import fly
from crosstrack.airsim.firmware.rows import DIRECT, blank
from crosstrack.types import GRAVITY, Array

TICK = 3_000_000
STILL = (0.0, 0.0, 0.0)
HIGH = 122.0


def vehicle(signals: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)) -> Any:
    """Return one vehicle in the air whose motors have been at given signals for long."""
    rows = blank(1)
    rows["altitude"] = HIGH
    rows["controlled"], rows["timed_out"] = True, True  # no hold for want of commands
    rows["goal"], rows["mode"] = signals, DIRECT
    rows["signal"] = rows["filtered"] = rows["output"] = signals
    return rows


def go(
    rows: Any, seconds: float, wind: tuple[float, float, float] = STILL, push: tuple[float, float, float] = STILL
) -> None:
    fly(rows, 0, TICK, round(seconds * 1e9 / TICK), wind, push)


def hover_signal() -> float:
    """Return the signal at which the rotors carry the weight, at the height where the vehicle is."""
    ratio = air.density(HIGH) / air.SEA_LEVEL_DENSITY
    return airframe.MASS * GRAVITY / (4 * airframe.THRUST_MAX * ratio)


@pytest.mark.parametrize(
    ("altitude", "kelvin", "pascal", "density"),
    [
        (0.0, 288.15, 101325.0, 1.2250),
        (1000.0, 281.65, 89876.0, 1.1117),
        (5000.0, 255.68, 54048.0, 0.7364),
        (15000.0, 216.65, 12111.0, 0.1948),
    ],
)
def test_air_is_the_standard_atmosphere(altitude: float, kelvin: float, pascal: float, density: float) -> None:
    assert air.temperature(altitude) == pytest.approx(kelvin, rel=2e-4)
    assert air.pressure(altitude) == pytest.approx(pascal, rel=2e-3)
    assert air.density(altitude) == pytest.approx(density, rel=2e-3)


def test_airframe_is_that_of_the_generic_quadrotor() -> None:
    assert pytest.approx(4.179446268, rel=1e-6) == airframe.THRUST_MAX
    assert pytest.approx(0.055562, rel=1e-4) == airframe.TORQUE_MAX
    assert pytest.approx(669.9, abs=0.1) == airframe.ROTOR_SPEED_MAX
    assert pytest.approx((0.00672, 0.00804, 0.01428), abs=1e-5) == airframe.INERTIA
    assert pytest.approx((0.00538, 0.00584, 0.1099), rel=2e-3) == airframe.DRAG


def test_rotors_carry_the_weight_at_the_signal_of_hover() -> None:
    assert hover_signal() == pytest.approx(0.594, abs=0.001)
    rows = vehicle((hover_signal(),) * 4)
    go(rows, 1.5)
    assert rows["position"][0] == pytest.approx(np.zeros(3), abs=1e-4)


def test_free_fall_ends_at_terminal_velocity() -> None:
    rows = vehicle()
    go(rows, 30.0)
    density = air.density(HIGH - rows["position"][0, 2])
    assert rows["velocity"][0, 2] == pytest.approx(math.sqrt(GRAVITY / (airframe.DRAG[2] * density)), rel=1e-3)


def test_free_fall_from_rest_is_that_of_quadratic_drag() -> None:
    rows = vehicle()
    go(rows, 0.6)
    terminal = math.sqrt(GRAVITY / (airframe.DRAG[2] * air.density(HIGH)))
    exact = terminal**2 / GRAVITY * math.log(math.cosh(GRAVITY * 0.6 / terminal))
    assert rows["position"][0, 2] == pytest.approx(exact, rel=5e-3)


def test_wind_is_felt_as_airspeed() -> None:
    wind = (3.0, -2.0, 0.0)
    at_rest, drifting = vehicle((hover_signal(),) * 4), vehicle((hover_signal(),) * 4)
    drifting["velocity"] = wind
    go(at_rest, 1.0, wind)
    go(drifting, 1.0, wind)
    assert drifting["velocity"][0, :2] == pytest.approx(wind[:2], abs=1e-9)
    push = at_rest["velocity"][0, :2]
    density = air.density(HIGH)
    expected = [airframe.DRAG[0] * density * 9.0, -airframe.DRAG[1] * density * 4.0]
    assert push == pytest.approx(expected, rel=0.05)


def test_a_push_accelerates_as_newton_says() -> None:
    rows = vehicle((hover_signal(),) * 4)
    go(rows, 0.3, STILL, (0.2, -0.1, 0.0))
    # The first step still uses the acceleration before it.
    assert rows["velocity"][0, :2] == pytest.approx([0.06, -0.03], rel=0.01)


@settings(deadline=None, max_examples=20)
@given(st.tuples(*[st.floats(-4, 4)] * 3))
def test_free_rotation_keeps_momentum_and_energy(rate: tuple[float, float, float]) -> None:
    rows = vehicle()
    rows["rate"] = rate
    inertia = np.array(airframe.INERTIA)

    def momentum() -> Array:
        turned: Array = Rotation.from_quat(rows["attitude"][0]).apply(inertia * rows["rate"][0])
        return turned

    before, energy = momentum(), inertia @ np.square(rate)
    go(rows, 1.0)
    assert momentum() == pytest.approx(before, rel=4e-2, abs=4e-4)
    assert inertia @ rows["rate"][0] ** 2 == pytest.approx(energy, rel=4e-2, abs=1e-6)
    assert np.linalg.norm(rows["attitude"][0]) == pytest.approx(1.0, abs=1e-12)


def derivative(_: float, y: Array, signals: Array, wind: Array) -> Array:
    """Return the rates of position, velocity, attitude xyzw and body rate, written from the laws."""
    turn, w = Rotation.from_quat(y[6:10] / np.linalg.norm(y[6:10])), y[10:13]
    density = air.density(HIGH - y[2])
    thrusts = airframe.THRUST_MAX * density / air.SEA_LEVEL_DENSITY * signals
    arms = np.stack([airframe.ROTOR_X, airframe.ROTOR_Y, [airframe.ROTOR_Z] * 4], axis=1)
    forces = np.stack([np.zeros(4), np.zeros(4), -thrusts], axis=1)
    torque = np.cross(arms, forces).sum(axis=0)
    torque[2] -= airframe.TORQUE_MAX / airframe.THRUST_MAX * (thrusts @ np.array(airframe.SPIN))
    u = turn.inv().apply(y[3:6] - wind)
    drag = -np.array(airframe.DRAG) * density * np.abs(u) * u * (np.abs(u) > airframe.DRAG_SPEED_MIN)
    acceleration = turn.apply(forces.sum(axis=0) + drag) / airframe.MASS + [0, 0, GRAVITY]
    inertia = np.array(airframe.INERTIA)
    spin = (torque - np.cross(w, inertia * w)) / inertia
    x, q = y[6:9], y[9]
    return np.concatenate([y[3:6], acceleration, 0.5 * (q * w + np.cross(x, w)), [-0.5 * x @ w], spin])


@settings(deadline=None, max_examples=15)
@given(st.tuples(*[st.floats(0.58, 0.61)] * 4), st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-5, 5)] * 3))
def test_open_loop_flight_agrees_with_another_integrator(
    signals: tuple[float, float, float, float], velocity: tuple[float, float, float], wind: tuple[float, float, float]
) -> None:
    rows = vehicle(signals)
    rows["velocity"] = velocity
    go(rows, 0.3)  # so that the accelerations kept between steps are there
    state = np.concatenate([rows[name][0] for name in ("position", "velocity", "attitude", "rate")])
    go(rows, 0.6, wind)
    found = solve_ivp(
        derivative, (0, 0.6), state, args=(np.array(signals), np.array(wind)), rtol=1e-8, atol=1e-10, max_step=0.01
    ).y[:, -1]
    assert rows["position"][0] == pytest.approx(found[:3], abs=0.02)
    assert rows["velocity"][0] == pytest.approx(found[3:6], abs=0.06)
    assert rows["rate"][0] == pytest.approx(found[10:13], abs=0.06)
    assert abs(rows["attitude"][0] @ found[6:10]) == pytest.approx(1.0, abs=2e-4)


def test_rotors_lag_by_their_time_constant() -> None:
    rows = vehicle()
    rows["goal"] = 0.5
    level = []
    for _ in range(8):
        go(rows, 0.003)
        level.append(float(rows["output"][0, 0]))
    keep = math.exp(-0.003 / airframe.ROTOR_LAG)
    # The signal of a step reaches the lag in the next, and thrust in the one after.
    assert level == pytest.approx([0.0, 0.0] + [0.5 * (1 - keep**k) for k in range(1, 7)], abs=1e-12)


def touching(
    velocity: tuple[float, float, float], normal: tuple[float, float, float], arm: tuple[float, float, float] = STILL
) -> Any:
    """Return a vehicle that has touched something, after the contact."""
    rows = vehicle()
    rows["velocity"] = velocity
    rows["contact_normal"], rows["contact_point"], rows["touched"] = normal, arm, True
    go(rows, 0.003)
    return rows


def test_a_wall_is_bounced_off() -> None:
    rows = touching((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert rows["velocity"][0, 0] == pytest.approx(-airframe.RESTITUTION * 4.0)
    assert not rows["grounded"][0]


def test_friction_takes_its_share_along_a_wall() -> None:
    rows = touching((4.0, 2.0, 0.0), (-1.0, 0.0, 0.0))
    assert rows["velocity"][0, :2] == pytest.approx([-airframe.RESTITUTION * 4.0, (1 - airframe.FRICTION) * 2.0])


def test_moving_away_from_what_was_touched_changes_nothing() -> None:
    free, rows = vehicle(), touching((-4.0, 1.0, 0.0), (-1.0, 0.0, 0.0))
    free["velocity"] = (-4.0, 1.0, 0.0)
    go(free, 0.003)
    assert rows["velocity"][0] == pytest.approx(free["velocity"][0])


def test_the_ground_holds_a_landing_vehicle_level_until_its_rotors_carry_it() -> None:
    rows = vehicle()
    rows["velocity"], rows["attitude"] = (0.1, 0.0, 1.0), Rotation.from_euler("ZYX", [1.0, 0.1, -0.1]).as_quat()
    rows["contact_normal"], rows["contact_position"], rows["touched"] = (0.0, 0.0, -1.0), (3.0, 2.0, 0.0), True
    go(rows, 0.003)
    assert rows["grounded"][0]
    assert rows["position"][0] == pytest.approx([3.0, 2.0, 0.0])
    yaw, pitch, roll = Rotation.from_quat(rows["attitude"][0]).as_euler("ZYX")
    assert (yaw, pitch, roll) == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    rows["goal"] = 0.98 * hover_signal()
    go(rows, 0.3)
    assert rows["grounded"][0]
    assert not rows["velocity"].any()
    rows["goal"] = 1.02 * hover_signal()
    go(rows, 0.3)
    assert not rows["grounded"][0]
    assert rows["velocity"][0, 2] < 0


def test_a_tilted_or_sideways_touch_of_the_ground_is_no_landing() -> None:
    rows = vehicle()
    rows["velocity"] = (2.0, 0.0, 1.0)
    rows["contact_normal"], rows["touched"] = (0.0, 0.0, -1.0), True
    go(rows, 0.003)
    assert not rows["grounded"][0]
    assert rows["velocity"][0, 2] < 0


def test_a_row_alone_flies_as_it_does_among_others() -> None:
    alone, several = (
        vehicle((0.6, 0.59, 0.6, 0.6)),
        np.concatenate([vehicle(), vehicle((0.6, 0.59, 0.6, 0.6)), vehicle()]),
    )
    go(alone, 1.0)
    go(several, 1.0)
    assert several[1].tobytes() == alone[0].tobytes()


def test_contact_is_responded_to_once() -> None:
    rows = touching((4.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert not rows["touched"][0]
    before = float(rows["velocity"][0, 0])
    go(rows, 0.003)
    assert rows["velocity"][0, 0] == pytest.approx(before, abs=0.01)
