"""The autopilot in flight: hover, steps, wind, every level of command, every airframe."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.sim.airframe import AIRFRAMES, GENERIC, RACER, Airframe
from crosstrack.sim.autopilot import attitude_wanted, thrust_vector
from crosstrack.sim.fleet import ATTITUDE, MOTION, RATE, fleet, place
from crosstrack.sim.kernel import STEP, fly
from crosstrack.types import GRAVITY, Air, Array, Limits

every = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
START = np.array([0.0, 0.0, 50.0])
PERIOD = 0.02
TILT = 45.0


class Pilot:
    """One vehicle at hover, flown command by command."""

    def __init__(self, airframe: Airframe, yaw: float = 0.0, wind: tuple[float, ...] = (0.0, 0.0, 0.0)) -> None:
        self.rows: Any = fleet(airframe, Air(), Limits(speed=20.0, tilt_deg=TILT), ground=0.0)
        place(self.rows, START, yaw)
        self.rows["wind"] = wind

    def fly(self, duration: float, level: int = MOTION, **fields: Any) -> Array:
        """Hold a command for a time; return the states (n, 17) every 20 ms."""
        command = np.full(11, np.nan)
        slots: dict[int, dict[str, slice]] = {
            MOTION: {
                "position": slice(0, 3),
                "velocity": slice(3, 6),
                "acceleration": slice(6, 9),
                "yaw": slice(9, 10),
                "yaw_rate": slice(10, 11),
            },
            ATTITUDE: {"attitude": slice(0, 4), "thrust": slice(4, 5)},
            RATE: {"rate": slice(0, 3), "thrust": slice(3, 4)},
        }
        for name, value in fields.items():
            command[slots[level][name]] = value
        self.rows["level"], self.rows["command"] = level, command
        found = []
        for _ in range(round(duration / PERIOD)):
            fly(self.rows, STEP, round(PERIOD / STEP))
            found.append(self.rows["state"][0].copy())
        return np.array(found)


def tilt(states: Array) -> Array:
    """Return the angle (degrees) between body z and up."""
    lean = 1 - 2 * (states[..., 6] ** 2 + states[..., 7] ** 2)
    return np.degrees(np.arccos(np.clip(lean, -1, 1)))


def heading(states: Array) -> Array:
    """Return the yaw (rad) of states."""
    return np.asarray(Rotation.from_quat(states[..., 6:10]).as_euler("ZYX")[..., 0])


@every
def test_hover_stays_where_it_is(airframe: Airframe) -> None:
    states = Pilot(airframe, yaw=1.0).fly(5.0, position=START, yaw=1.0)
    np.testing.assert_allclose(states[:, :3], np.broadcast_to(START, states[:, :3].shape), atol=1e-3)
    np.testing.assert_allclose(heading(states), 1.0, atol=1e-6)
    assert tilt(states).max() < 0.01


@every
@pytest.mark.parametrize("velocity", [(4.0, 0.0, 0.0), (0.0, -3.0, 1.0), (0.0, 0.0, -2.0)])
def test_velocity_step_settles_without_steady_error(airframe: Airframe, velocity: tuple[float, ...]) -> None:
    states = Pilot(airframe).fly(12.0, velocity=velocity, yaw=0.0)
    found = states[:, 3:6]
    speed = float(np.linalg.norm(velocity))
    along = found @ np.array(velocity) / speed
    assert along.max() < 1.15 * speed
    rise = PERIOD * (np.argmax(along > 0.9 * speed) + 1)
    assert rise < 1.5
    np.testing.assert_allclose(found[-50:], np.broadcast_to(velocity, (50, 3)), atol=0.02 * speed)


@every
def test_position_step_arrives_and_stays(airframe: Airframe) -> None:
    goal = START + np.array([3.0, -2.0, 1.0])
    states = Pilot(airframe).fly(10.0, position=goal, yaw=0.0)
    along = (states[:, :3] - START) @ (goal - START) / np.linalg.norm(goal - START) ** 2
    assert along.max() < 1.15
    np.testing.assert_allclose(states[-50:, :3], np.broadcast_to(goal, (50, 3)), atol=0.03)


@every
@pytest.mark.parametrize("wind", [(4.0, 0.0, 0.0), (0.0, -3.0, 1.0)])
def test_position_is_held_in_wind(airframe: Airframe, wind: tuple[float, ...]) -> None:
    states = Pilot(airframe, wind=wind).fly(20.0, position=START, yaw=0.0)
    np.testing.assert_allclose(states[-50:, :3], np.broadcast_to(START, (50, 3)), atol=0.02)


@every
def test_acceleration_alone_is_flown_open_loop(airframe: Airframe) -> None:
    states = Pilot(airframe).fly(1.0, acceleration=(2.0, 0.0, 0.0), velocity=(np.nan, 0.0, 0.0), yaw=0.0)
    # Drag may slow it a little.
    assert 1.4 < np.diff(states[25:, 3]).mean() / PERIOD < 2.05
    np.testing.assert_allclose(states[:, 4:6], 0, atol=0.05)


@every
def test_attitude_setpoint_is_held(airframe: Airframe) -> None:
    wanted = Rotation.from_euler("ZYX", [0.5, 0.2, -0.1])
    states = Pilot(airframe).fly(2.0, ATTITUDE, attitude=wanted.as_quat(), thrust=GRAVITY)
    error = (wanted.inv() * Rotation.from_quat(states[-1, 6:10])).magnitude()
    assert error < math.radians(1.0)
    push = np.linalg.norm(np.diff(states[:10, 3:6], axis=0).mean(axis=0) / PERIOD + [0, 0, GRAVITY])
    assert push == pytest.approx(GRAVITY, rel=0.05)


@every
def test_rate_setpoint_is_held(airframe: Airframe) -> None:
    rate = np.array([0.8, -0.5, 0.3])
    states = Pilot(airframe).fly(0.6, RATE, rate=rate, thrust=GRAVITY)
    np.testing.assert_allclose(states[-1, 10:13], rate, atol=0.03)


@every
@pytest.mark.parametrize(("start", "end"), [(3.0, -3.0), (-3.0, 3.0), (0.0, 2.5), (1.0, -2.0)])
def test_yaw_turns_the_short_way(airframe: Airframe, start: float, end: float) -> None:
    states = Pilot(airframe, yaw=start).fly(6.0, position=START, yaw=end)
    way = np.unwrap(np.concatenate([[start], heading(states)]))
    shortest = math.remainder(end - start, 2 * math.pi)
    assert way[-1] - start == pytest.approx(shortest, abs=0.02)
    assert np.ptp(way) < 1.15 * abs(shortest)
    assert np.abs(states[:, :3] - START).max() < 0.05


@every
def test_yaw_rate_alone_turns_at_that_rate(airframe: Airframe) -> None:
    states = Pilot(airframe).fly(4.0, position=START, yaw_rate=0.5)
    way = np.unwrap(heading(states))
    assert (way[-1] - way[99]) / (PERIOD * (len(way) - 100)) == pytest.approx(0.5, rel=0.01)
    later = Pilot(airframe, yaw=0.7).fly(1.0, position=START)
    np.testing.assert_allclose(heading(later), 0.7, atol=1e-6)


@every
def test_hard_commands_keep_it_upright(airframe: Airframe) -> None:
    pilot = Pilot(airframe)
    rng = np.random.default_rng(6)
    for _ in range(12):
        states = pilot.fly(0.7, velocity=rng.uniform(-15, 15, 3), yaw=rng.uniform(-3, 3))
        assert np.all(np.isfinite(states))
        assert tilt(states).max() < TILT + 15
    still = pilot.fly(16.0, velocity=(0, 0, 0), yaw=0.0)
    np.testing.assert_allclose(still[-1, 3:6], 0, atol=0.05)


@every
def test_sideways_push_does_not_cost_height(airframe: Airframe) -> None:
    states = Pilot(airframe).fly(1.5, position=(np.nan, np.nan, START[2]), velocity=(15.0, 0.0, np.nan), yaw=0.0)
    assert np.abs(states[:, 2] - START[2]).max() < 0.35


@every
def test_takes_off_after_waiting_on_the_ground_and_lands_again(airframe: Airframe) -> None:
    pilot = Pilot(airframe)
    place(pilot.rows, np.array([0.0, 0.0, airframe.gear]), 0.0, spinning=False)
    waiting = pilot.fly(5.0, velocity=(0, 0, 0), yaw=0.0)
    assert np.abs(waiting[:, 2] - airframe.gear).max() < 0.01
    climb = pilot.fly(8.0, position=(0, 0, 3.0), yaw=0.0)
    assert climb[:, 2].max() < 3.4
    np.testing.assert_allclose(climb[-25:, :3], np.broadcast_to([0, 0, 3.0], (25, 3)), atol=0.05)
    landing = pilot.fly(9.0, velocity=(0, 0, -0.5), yaw=0.0)
    assert landing[-1, 2] == pytest.approx(airframe.gear, abs=0.01)
    np.testing.assert_allclose(landing[-1, 3:6], 0, atol=0.01)
    assert pilot.rows["impact"][0] < 0.7


@every
def test_braking_hard_costs_no_height(airframe: Airframe) -> None:
    """The discs of a vehicle that leans back are a sail: a drag that the autopilot must expect, not find out."""
    pilot = Pilot(airframe)
    pilot.fly(8.0, position=(np.nan, np.nan, START[2]), velocity=(8.0, 0.0, np.nan), yaw=0.0)
    states = pilot.fly(2.0, position=(np.nan, np.nan, START[2]), velocity=(0.0, 0.0, np.nan), yaw=0.0)
    assert np.abs(states[:, 2] - START[2]).max() < 0.2


demands = st.tuples(st.floats(-60, 60), st.floats(-60, 60), st.floats(-60, 60))


@given(airframe=st.sampled_from(list(AIRFRAMES.values())), demand=demands)
def test_thrust_asked_for_respects_tilt_and_strength(airframe: Airframe, demand: tuple[float, float, float]) -> None:
    row = fleet(airframe, Air(), Limits(tilt_deg=TILT), ground=0.0)[0]
    x, y, z = thrust_vector(*demand, row)
    assert z > 0
    assert math.degrees(math.atan2(math.hypot(x, y), z)) <= TILT + 1e-9
    strength = 4 * float(row["thrust_max"]) / airframe.mass
    assert math.sqrt(x * x + y * y + z * z) <= strength
    # Sideways it keeps its direction and is never more than asked for.
    assert x * demand[1] == pytest.approx(y * demand[0], abs=1e-9)
    assert abs(x) <= abs(demand[0]) + 1e-12


@given(demand=st.tuples(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3)))
def test_moderate_acceleration_is_asked_for_as_it_is(demand: tuple[float, float, float]) -> None:
    row = fleet(RACER, Air(), Limits(tilt_deg=TILT), ground=0.0)[0]
    np.testing.assert_allclose(thrust_vector(*demand, row), np.array(demand) + np.array([0, 0, GRAVITY]), rtol=1e-12)


@given(force=st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(3, 20)), yaw=st.floats(-3.1, 3.1))
def test_attitude_points_the_thrust_and_keeps_the_yaw(force: tuple[float, float, float], yaw: float) -> None:
    quaternion = attitude_wanted(*force, math.sin(yaw / 2), math.cos(yaw / 2))
    attitude = Rotation.from_quat(quaternion)
    assert np.linalg.norm(quaternion) == pytest.approx(1, abs=1e-12)
    up = np.array(force) / np.linalg.norm(force)
    np.testing.assert_allclose(attitude.apply([0, 0, 1]), up, atol=1e-12)
    # What is left after the yaw is a tilt about a level axis.
    lean = (attitude * Rotation.from_rotvec([0, 0, -yaw])).as_rotvec()
    assert lean[2] == pytest.approx(0, abs=1e-9)


def test_estimate_errors_move_the_vehicle_by_as_much() -> None:
    pilot = Pilot(GENERIC)
    pilot.rows["error"][0, :3] = 0.4, -0.3, 0.2
    states = pilot.fly(12.0, position=START, yaw=0.0)
    np.testing.assert_allclose(states[-1, :3], START - [0.4, -0.3, 0.2], atol=5e-3)
