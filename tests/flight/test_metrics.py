import json
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import tilt
from crosstrack.flight.summary import summary
from crosstrack.types import Array, Outcome

Fly = Callable[..., Flight]
LINE = np.array([[0.0, 0.0, 5.0], [100.0, 0.0, 5.0]])
CONTRACT = {
    "outcome", "outcome_text", "arrived", "collided", "flight_time_s", "cross_track_rms_m", "cross_track_max_m",
    "cross_track_rms_captured_m", "cross_track_max_captured_m", "final_error_m", "final_speed_mps",
    "min_clearance_m", "path_length_m", "flown_length_m", "max_speed_mps", "mean_speed_mps", "min_separation_m",
    "replans", "safety_interventions", "planning_time_s", "decision_time_s", "decision_time_p99_s", "wall_time_s",
}  # fmt: skip


def along_line(fly: Fly, time: Array, y: Array, z: Array | float = 0.0) -> Flight:
    """Fly the line at 5 m/s with given offsets."""
    x = 5.0 * time
    return fly(LINE, time, np.column_stack([x, y, 5.0 + z + 0.0 * x]), x)


def test_helix_around_a_line(fly_along: Fly) -> None:
    time = np.arange(0, 20.001, 0.02)
    metrics = along_line(fly_along, time, 0.7 * np.cos(2 * time), 0.7 * np.sin(2 * time)).metrics
    assert metrics.cross_track_rms_m == pytest.approx(0.7, abs=1e-9)
    assert metrics.cross_track_max_m == pytest.approx(0.7, abs=1e-9)
    assert metrics.cross_track_rms_captured_m is None
    assert metrics.captured_time_s is None
    assert metrics.flown_length_m == pytest.approx(20 * math.hypot(5, 1.4), rel=1e-4)
    assert metrics.path_length_m == pytest.approx(100)
    assert metrics.mean_speed_mps == pytest.approx(math.hypot(5, 1.4), rel=1e-3)
    assert metrics.max_acceleration_mps2 == pytest.approx(0.7 * 4, rel=0.01)


def test_swing_about_a_line(fly_along: Fly) -> None:
    time = np.linspace(0, 4 * np.pi, 2001)
    metrics = along_line(fly_along, time, 0.3 * np.sin(time)).metrics
    assert metrics.cross_track_rms_m == pytest.approx(0.3 / math.sqrt(2), rel=1e-5)
    assert metrics.cross_track_max_m == pytest.approx(0.3, rel=1e-5)


def test_circle_flown_beside_a_circle(fly_along: Fly) -> None:
    turn = np.linspace(0, 2 * np.pi, 3601)
    route = np.column_stack([10 * np.cos(turn), 10 * np.sin(turn), 0 * turn])
    flight = fly_along(route, 3 * turn, 1.05 * route, 10 * turn)
    metrics = flight.metrics
    assert metrics.cross_track_rms_m == pytest.approx(0.5, abs=1e-4)
    assert metrics.path_length_m == pytest.approx(20 * np.pi, rel=1e-5)
    assert metrics.flown_length_m == pytest.approx(21 * np.pi, rel=1e-5)


def test_means_weigh_time_and_not_samples(fly_along: Fly) -> None:
    time = np.concatenate([np.linspace(0, 10, 5001), np.linspace(10, 20, 101)[1:]])
    offset = np.where(time <= 10, 0.0, 0.4)
    metrics = along_line(fly_along, time, offset).metrics
    assert metrics.cross_track_rms_m == pytest.approx(0.4 / math.sqrt(2), rel=0.01)


def test_captured_from_the_first_time_under_five_centimetres(fly_along: Fly) -> None:
    time, decay = np.arange(0, 20.0005, 0.001), 2.0
    metrics = along_line(fly_along, time, 3.0 * np.exp(-time / decay)).metrics
    captured = decay * math.log(3.0 / 0.05)
    assert metrics.captured_time_s == pytest.approx(captured, abs=0.002)
    rest = 20.0 - captured
    rms = 0.05 * math.sqrt(decay / 2 * (1 - math.exp(-2 * rest / decay)) / rest)
    assert metrics.cross_track_rms_captured_m == pytest.approx(rms, rel=1e-3)
    assert metrics.cross_track_max_captured_m == pytest.approx(0.05, rel=1e-3)
    assert metrics.cross_track_max_m == pytest.approx(3.0)


@pytest.mark.parametrize(
    "route",
    [
        [[0, 0, 5], [20, 0, 5], [0, 0, 5], [0, 20, 5]],
        [[0, 0, 5], [20, 20, 9], [20, 0, 5], [0, 20, 5]],
        [[0, 0, 5], [20, 0, 5], [20, 20, 5], [0, 20, 5], [0, 0, 5], [20, 0, 5]],
    ],
    ids=["reversing", "crossing", "around again"],
)
def test_error_is_to_the_part_of_the_route_being_flown(fly_along: Fly, route: Any) -> None:
    knots = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(route, axis=0), axis=1))])
    time = np.linspace(0, knots[-1] / 4, 3000)
    position = np.column_stack([np.interp(4 * time, knots, np.array(route, float)[:, axis]) for axis in range(3)])
    flight = fly_along(route, time, position + [0, 0, 0.25], 4 * time)
    level = np.ptp(np.array(route)[:, 2]) == 0
    error = flight.cross_track
    if level:
        np.testing.assert_allclose(error, 0.25, atol=1e-9)
    assert error.max() < 0.25 + 1e-9
    assert error.min() > 0.2


@given(st.floats(-math.pi, math.pi), st.floats(0, math.pi), st.floats(-math.pi, math.pi))
def test_tilt_does_not_depend_on_yaw(heading: float, lean: float, yaw: float) -> None:
    axis = np.array([math.cos(heading), math.sin(heading), 0.0])
    attitude = Rotation.from_rotvec(lean * axis) * Rotation.from_euler("z", yaw)
    assert tilt(attitude.as_quat()[None])[0] == pytest.approx(lean, abs=2e-7)


def test_acceleration_and_jerk_of_a_cubic(fly_along: Fly) -> None:
    time = np.arange(0, 4.001, 0.02)
    flight = fly_along(LINE, time, np.column_stack([0.5 * time**3, 0 * time, 0 * time + 5]), 0.5 * time**3)
    velocity = np.column_stack([1.5 * time**2, 0 * time, 0 * time])
    metrics = replace(flight, record=replace(flight.record, velocity=velocity)).metrics
    assert metrics.rms_jerk_mps3 == pytest.approx(3.0, rel=1e-6)
    assert metrics.max_acceleration_mps2 == pytest.approx(3.0 * 3.99, rel=1e-6)
    assert metrics.max_speed_mps == pytest.approx(24.0)
    assert metrics.final_speed_mps == pytest.approx(24.0)


def test_effort_airspeed_and_clearance(fly_along: Fly) -> None:
    time = np.linspace(0, 2 * np.pi, 2001)
    flight = along_line(fly_along, time, 0 * time)
    rotor = 500 + np.outer(30 * np.sin(time), [1, -1, 1, -1])
    record = replace(flight.record, rotor_speeds=rotor, clearance=3 - np.sin(time))
    metrics = replace(flight, record=record).metrics
    assert metrics.control_effort_radps == pytest.approx(30 / math.sqrt(2), rel=1e-5)
    assert metrics.max_airspeed_mps == pytest.approx(math.hypot(4.0, 0.5))
    assert metrics.min_clearance_m == pytest.approx(2.0, abs=1e-5)
    assert metrics.final_error_m == pytest.approx(100 - 10 * np.pi)


def test_what_is_not_there_is_null(fly_along: Fly) -> None:
    time = np.linspace(0, 1, 51)
    position = np.column_stack([time, 0 * time, 0 * time + 9])
    flight = fly_along(LINE, time, position, time, rotors=0, clearance=np.inf)
    unknown = replace(flight.record, wind=np.full((51, 3), np.nan))
    found = summary(replace(flight, record=unknown, outcome=Outcome.TIMED_OUT))
    absent = {name for name, value in found.items() if value is None}
    assert absent == {
        "min_clearance_m", "control_effort_radps", "max_airspeed_mps", "time_ratio", "captured_time_s",
        "cross_track_rms_captured_m", "cross_track_max_captured_m", "tracking_rms_m", "tracking_max_m",
        "min_separation_m",
    }  # fmt: skip


def test_summary_keeps_the_contract_and_is_json(flight: Flight) -> None:
    found = json.loads(json.dumps(summary(flight), allow_nan=False))
    assert found.keys() >= CONTRACT
    assert (found["outcome"], found["arrived"], found["collided"]) == ("arrived", True, False)
    assert found["outcome_text"] == "Arrived at the last waypoint."


def test_a_flight_that_is_lost_is_measured_up_to_there(fly_along: Fly) -> None:
    time = np.linspace(0, 4, 201)
    flight = along_line(fly_along, time, 0 * time + 0.2)
    position, velocity = flight.record.position.copy(), flight.record.velocity.copy()
    position[-1], velocity[-1] = np.nan, np.nan
    found = summary(replace(flight, record=replace(flight.record, position=position, velocity=velocity)))
    assert found["cross_track_rms_m"] == pytest.approx(0.2)
    assert found["final_error_m"] == pytest.approx(math.hypot(100 - 5 * time[-2], 0.2))
    json.dumps(found, allow_nan=False)


def test_one_sample_is_a_flight(fly_along: Fly) -> None:
    flight = fly_along(LINE, np.arange(2.0), np.array([[0, 0.3, 5], [1, 0, 5]]), np.arange(2.0))
    first = replace(flight.record, **{name: column[:1] for name, column in vars(flight.record).items()})
    found = summary(replace(flight, record=first))
    assert found["flight_time_s"] == 0
    assert found["cross_track_rms_m"] == pytest.approx(0.3)
    assert found["max_acceleration_mps2"] is None
