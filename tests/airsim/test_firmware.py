"""The firmware of AirSim's quadrotor: loops, mixer, remote control, and what it sees to by itself."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.airsim.firmware.cascade import RATE_LIMIT, SPEED_LIMIT, THROTTLE_MIN, TILT_LIMIT, control
from crosstrack.airsim.firmware.kernel import fly
from crosstrack.airsim.firmware.mixer import mix
from crosstrack.airsim.firmware.quadrotor import Quadrotor
from crosstrack.airsim.firmware.rows import (
    ANGLE,
    ARMED,
    DIRECT,
    DISARMED,
    HOLD_MODE,
    INACTIVE,
    POSITION,
    POSITION_LOOP,
    RATE,
    RATE_LOOP,
    RATE_MODE,
    VELOCITY,
    VELOCITY_LOOP,
    blank,
)

TICK = 3_000_000
STILL = (0.0, 0.0, 0.0)
Four = tuple[float, float, float, float]


def controlled(goal: Four, mode: tuple[int, int, int, int]) -> Any:
    """Return one vehicle that the API has given goals."""
    rows = blank(1)
    rows["controlled"], rows["altitude"] = True, 122.0
    rows["goal"], rows["mode"] = goal, mode
    return rows


def outputs(rows: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the outputs of the axes at the first update."""
    control(rows[0], 0)
    found: np.ndarray[Any, np.dtype[np.float64]] = rows["control"][0]
    return found


def go(rows: Any, seconds: float, start: float = 0.0) -> None:
    fly(rows, round(start * 1e9), TICK, round(seconds * 1e9 / TICK), STILL, STILL)


@given(st.floats(-6, 6), st.floats(-3, 3), st.floats(-5, 5))
@settings(deadline=None, max_examples=40)
def test_an_angle_goal_is_two_loops_in_a_row(goal: float, angle: float, rate: float) -> None:
    rows = controlled((0.0, 0.0, goal, 0.5), (ANGLE, ANGLE, ANGLE, DIRECT))
    rows["attitude"], rows["rate"] = Rotation.from_euler("z", angle).as_quat(), (0.0, 0.0, rate)
    short = math.remainder(goal - angle, 2 * math.pi)
    if math.pi - abs(short) < 1e-6:
        return
    asked = RATE_LIMIT * np.clip(2.5 * short, -1, 1)
    assert outputs(rows)[2] == pytest.approx(np.clip(0.25 * (asked - rate), -1, 1), abs=1e-9)


@given(st.tuples(*[st.floats(-8, 8)] * 3), st.tuples(*[st.floats(-8, 8)] * 3), st.tuples(*[st.floats(-0.5, 0.5)] * 3))
@settings(deadline=None, max_examples=40)
def test_velocities_are_compared_in_the_body_frame(
    goal: tuple[float, float, float], velocity: tuple[float, float, float], angles: tuple[float, float, float]
) -> None:
    rows = controlled((goal[1], goal[0], 0.0, goal[2]), (VELOCITY, VELOCITY, RATE, VELOCITY))
    turn = Rotation.from_euler("ZYX", angles)
    rows["attitude"], rows["velocity"] = turn.as_quat(), velocity
    error = turn.inv().apply(np.subtract(goal, velocity))
    _, pitch, roll = angles
    tilt = TILT_LIMIT * np.clip(0.2 * error, -1, 1)
    rate = RATE_LIMIT * np.clip(2.5 * np.array([tilt[1] - roll, -tilt[0] - pitch]), -1, 1)
    found = outputs(rows)
    assert found[:2] == pytest.approx(np.clip(0.25 * rate, -1, 1), abs=1e-9)
    assert found[3] == pytest.approx(max(0.5 * (1 - np.clip(2 * error[2], -1, 1)), THROTTLE_MIN))


@pytest.mark.parametrize("ideal", [False, True])
def test_a_height_goal_leaks_into_the_forward_loop_unless_ideal(ideal: bool) -> None:
    pitch = -0.2
    found = []
    for z in (-2.0, -4.0):
        rows = controlled((0.0, 5.0, 0.0, z), (VELOCITY, VELOCITY, RATE, POSITION))
        rows["ideal"], rows["position"] = ideal, (0.0, 0.0, z)
        rows["attitude"], rows["velocity"] = Rotation.from_euler("y", pitch).as_quat(), (4.0, 0.0, 0.0)
        found.append(outputs(rows)[1])
    # Nose down, the height of the goal looks like a velocity backwards.
    assert bool(found[0] == pytest.approx(found[1])) is ideal


@pytest.mark.parametrize("ideal", [False, True])
def test_nothing_brings_a_vehicle_back_with_its_nose_to_the_east_unless_ideal(ideal: bool) -> None:
    rows = controlled((0.0, 2.0, 0.0, 0.0), (POSITION, POSITION, RATE, POSITION))
    rows["ideal"], rows["attitude"] = ideal, Rotation.from_euler("z", math.pi / 2).as_quat()
    found = outputs(rows)
    speed = SPEED_LIMIT * 0.25 * 2.0
    # The goal is 2 m to the north, which is to the left: a roll to the left.
    roll = -TILT_LIMIT * 0.2 * speed if ideal else 0.0
    assert found[0] == pytest.approx(0.25 * RATE_LIMIT * 2.5 * roll, abs=1e-9)
    assert found[1] == pytest.approx(0.0, abs=1e-9)


def test_position_loops_ask_for_no_more_than_their_limit() -> None:
    near, far = (controlled((0.0, x, 0.0, 0.0), HOLD_MODE) for x in (4.0, 400.0))
    assert outputs(near)[1] == pytest.approx(outputs(far)[1])


def test_integral_of_the_vertical_velocity_grows_and_forgets() -> None:
    rows = controlled((0.0, 0.0, 0.0, 0.05), (VELOCITY, VELOCITY, RATE, VELOCITY))
    expected = 0.0
    for k in range(200):
        control(rows[0], 3 * k)
        if k:  # the first update has no time behind it
            expected = expected * 0.9999 + 0.003 * 0.05 * 2.0
    assert rows["integral"][0, VELOCITY_LOOP, 3] == pytest.approx(expected)
    assert rows["control"][0, 3] == pytest.approx(0.5 * (1 - (2.0 * 0.05 + expected)))


def test_a_new_meaning_of_a_goal_starts_its_loops_again() -> None:
    rows = controlled((0.0, 0.0, 0.0, 0.05), (VELOCITY, VELOCITY, RATE, VELOCITY))
    for k in range(50):
        control(rows[0], 3 * k)
    rows["mode"] = (VELOCITY, VELOCITY, RATE, POSITION)
    rows["goal"] = 0.0
    control(rows[0], 150)
    assert not rows["integral"].any()


def test_derivative_gain_counts_the_change_of_the_error() -> None:
    rows = controlled((0.0, 0.0, 0.2, 0.5), RATE_MODE)
    rows["gains"][0, 2, RATE_LOOP, 2] = 0.01
    control(rows[0], 0)
    control(rows[0], 3)
    rows["rate"] = (0.0, 0.0, 0.05)
    control(rows[0], 6)
    assert rows["control"][0, 2] == pytest.approx(0.25 * 0.15 + 0.01 * -0.05 / 0.003)


@given(st.tuples(*[st.floats(-1, 1)] * 3), st.floats(0.05, 1))
@settings(deadline=None, max_examples=100)
def test_mixed_signals_are_within_range_and_keep_the_torques_in_proportion(
    torques: tuple[float, float, float], throttle: float
) -> None:
    rows = blank(1)
    rows["control"] = (*torques, throttle)
    mix(rows[0])
    front_right, rear_left, front_left, rear_right = signals = rows["signal"][0]
    assert signals.min() >= -1e-7
    assert signals.max() <= 1 + 1e-7
    given_back = np.array(
        [
            rear_left + front_left - front_right - rear_right,
            front_right + front_left - rear_left - rear_right,
            front_right + rear_left - front_left - rear_right,
        ]
    )
    wanted = 4 * np.array(torques)
    size = float(wanted @ wanted)
    scale = float(given_back @ wanted) / size if size else 1.0
    if size > 1e-3:
        assert 0 < scale <= 1 + 1e-6
    assert given_back == pytest.approx(scale * wanted, abs=1e-6)


def test_low_throttle_drives_all_motors_alike() -> None:
    rows = blank(1)
    rows["control"] = (0.3, -0.2, 0.1, 0.04)
    mix(rows[0])
    assert rows["signal"][0] == pytest.approx([0.04] * 4)


def airborne() -> Any:
    """Return a vehicle that has been flying up at 1 m/s under the API."""
    rows = controlled((0.0, 0.0, 0.0, -1.0), (VELOCITY, VELOCITY, RATE, VELOCITY))
    rows["goal_time"], rows["timed_out"] = 900, False
    go(rows, 0.9)
    assert rows["flying"][0]
    return rows


def test_without_commands_for_60_ms_it_holds_its_position() -> None:
    rows = airborne()
    rows["goal_time"] = 900
    go(rows, 0.060, 0.9)
    assert rows["mode"][0].tolist() == [VELOCITY, VELOCITY, RATE, VELOCITY]
    go(rows, 0.003, 0.96)
    assert rows["mode"][0].tolist() == list(HOLD_MODE)
    assert rows["goal"][0, 3] == pytest.approx(rows["position"][0, 2])
    assert rows["timed_out"][0]


def test_a_command_ends_the_hold() -> None:
    rows = airborne()
    go(rows, 0.3, 0.9)
    quadrotor = Quadrotor(rows, 0)
    quadrotor.command((1.0, 2.0, 0.0, -3.0), (VELOCITY, VELOCITY, RATE, VELOCITY), 1200)
    go(rows, 0.03, 1.2)
    assert rows["goal"][0].tolist() == [1.0, 2.0, 0.0, -3.0]


def test_commands_count_only_while_the_api_is_in_control() -> None:
    rows = blank(1)
    quadrotor = Quadrotor(rows, 0)
    quadrotor.command((1.0, 2.0, 0.0, -3.0), (VELOCITY, VELOCITY, RATE, VELOCITY), 0)
    assert not rows["goal"].any()
    quadrotor.take_control(True)
    quadrotor.command((1.0, 2.0, 0.0, -3.0), (VELOCITY, VELOCITY, RATE, VELOCITY), 0)
    assert rows["goal"][0].tolist() == [1.0, 2.0, 0.0, -3.0]


def test_disarming_stops_the_motors_and_arming_idles_them() -> None:
    rows = airborne()
    quadrotor = Quadrotor(rows, 0)
    go(rows, 0.3, 0.9)  # the hold has begun: it would replace the goals of disarming otherwise
    assert quadrotor.arm(False)
    go(rows, 0.003, 1.2)
    assert rows["signal"][0] == pytest.approx([0.0] * 4)
    assert rows["armed"][0] in (DISARMED, INACTIVE)
    assert not quadrotor.arm(False)
    assert quadrotor.arm(True)
    assert quadrotor.arm(True)
    go(rows, 0.003, 1.203)
    assert rows["signal"][0] == pytest.approx([0.1 / 1.5] * 4)


def test_arming_needs_the_api_in_control() -> None:
    quadrotor = Quadrotor(blank(1), 0)
    assert not quadrotor.arm(False)
    assert not quadrotor.arm(True)


def test_sticks_fly_an_armed_vehicle() -> None:
    rows = blank(1)
    rows["altitude"] = 122.0
    Quadrotor(rows, 0).sticks([0.5, 0.0, 0.0, 0.62, 0, 0], True)
    go(rows, 1.0)
    roll = Rotation.from_quat(rows["attitude"][0]).as_euler("ZYX")[2]
    assert roll == pytest.approx(0.5 * TILT_LIMIT, rel=0.1)
    assert rows["velocity"][0, 1] > 0.5
    Quadrotor(rows, 0).sticks([], False)
    go(rows, 0.1, 1.0)
    assert rows["goal"][0, :3].tolist() == [0.0, 0.0, 0.0]


def test_sticks_mean_rates_by_their_switch() -> None:
    rows = blank(1)
    Quadrotor(rows, 0).sticks([0.1, 0.0, 0.0, 0.62, 1, 0], True)
    go(rows, 0.03)
    assert rows["mode"][0].tolist() == list(RATE_MODE)


def test_sticks_arm_and_disarm_by_gestures() -> None:
    rows = blank(1)
    rows["armed"] = INACTIVE
    quadrotor = Quadrotor(rows, 0)
    clock = 0.0
    for channels, expected in (
        ([-1.0, 1.0, 1.0, 0.0, 0, 0], None),
        ([0.0, 0.0, 0.0, 0.5, 0, 0], ARMED),
        ([1.0, 1.0, -1.0, 0.0, 0, 0], INACTIVE),
    ):
        quadrotor.sticks(channels, True)
        go(rows, 0.3, clock)
        clock += 0.3
        assert expected is None or rows["armed"][0] == expected


def test_resting_with_idle_motors_is_landed() -> None:
    rows = airborne()
    rows["timed_out"] = True
    rows["goal"], rows["mode"] = (0.0, 0.0, 0.0, 0.06), RATE_MODE
    rows["velocity"] = 0.0
    rows["grounded"] = True
    go(rows, 0.3, 0.9)
    assert not rows["flying"][0]


def test_gains_are_set_by_loop_and_start_all_loops_again() -> None:
    rows = controlled((0.0, 0.0, 0.0, 0.05), (VELOCITY, VELOCITY, RATE, VELOCITY))
    for k in range(50):
        control(rows[0], 3 * k)
    quadrotor = Quadrotor(rows, 0)
    gains = np.arange(12, dtype=float).reshape(3, 4)
    quadrotor.set_gains(POSITION_LOOP, gains)
    assert rows["gains"][0, :, POSITION_LOOP] == pytest.approx(gains)
    control(rows[0], 150)
    assert not rows["integral"].any()


def test_a_reset_keeps_gains_and_forgets_the_rest() -> None:
    rows = airborne()
    rows["gains"][0, 0, RATE_LOOP] = 0.1
    Quadrotor(rows, 0).reset(5000, ARMED)
    fresh = blank(1)
    fresh["gains"][0, 0, RATE_LOOP] = 0.1
    fresh["altitude"], fresh["time"], fresh["goal_time"] = 122.0, 5000, 5000
    assert rows.tobytes() == fresh.tobytes()
