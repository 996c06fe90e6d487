"""The moves of the AirSim server: what they do, what they answer, and what an ideal vehicle does instead."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from aloft import AS_IT_IS, NEVER, Aloft, P, T, V, hovering, on_ground
from scipy.spatial.transform import Rotation

from crosstrack.airsim.firmware import airframe
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.moves import attitude, manual, path, rotate, velocity, vertical, yaw
from crosstrack.airsim.server.moves.path import Legs
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import RCData, YawMode

FORWARD, TO_ANGLE = 1, YawMode(False, 0.0)


def angles(aloft: Aloft) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (rad)."""
    z, y, x = Rotation.from_quat(aloft.vehicle.quadrotor.attitude).as_euler("ZYX")
    return float(x), float(y), float(z)


def test_velocity_is_flown_for_the_duration() -> None:
    aloft = hovering()
    log, took, answer = aloft.logged(lambda v: velocity.move_by_velocity(v, 2, -1, 0, 8, 0, AS_IT_IS))
    assert answer
    assert took == pytest.approx(8.0, abs=0.022)
    assert log[-1, V] == pytest.approx([2, -1, 0], abs=0.06)


def test_a_body_velocity_is_turned_by_the_heading_at_the_start() -> None:
    aloft = hovering()
    aloft.fly(rotate.rotate_to_yaw(aloft.vehicle, 60, NEVER, 2))
    heading = angles(aloft)[2]
    aloft.fly(velocity.move_by_velocity_body_frame(aloft.vehicle, 2, 0, 0, 6, 0, YawMode(True, 20)))
    found = aloft.vehicle.quadrotor.velocity
    assert math.atan2(found[1], found[0]) == pytest.approx(heading, abs=0.1)
    assert abs(angles(aloft)[2] - heading) > 0.5


def test_a_body_velocity_at_a_height_is_turned_likewise() -> None:
    aloft = hovering()
    aloft.fly(rotate.rotate_to_yaw(aloft.vehicle, 60, NEVER, 2))
    heading = angles(aloft)[2]
    assert aloft.fly(velocity.move_by_velocity_z_body_frame(aloft.vehicle, 2, 0, -11, 10, 0, AS_IT_IS))
    found = aloft.vehicle.quadrotor
    assert math.atan2(found.velocity[1], found.velocity[0]) == pytest.approx(heading, abs=0.1)
    assert found.position[2] == pytest.approx(-11, abs=0.3)


@pytest.mark.parametrize("nose", [30.0, -120.0])
def test_nose_first_is_relative_to_the_way_ahead(nose: float) -> None:
    aloft = hovering()
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 2, 2, 0, 8, FORWARD, YawMode(False, nose)))
    assert math.degrees(angles(aloft)[2]) == pytest.approx(45 + nose, abs=2)


def test_nose_first_and_slow_leaves_the_nose_alone() -> None:
    found = yaw.along(0.3, 0.3, 0.0, FORWARD, YawMode(False, 30.0))
    assert (found.is_rate, found.yaw_or_rate) == (True, 0.0)


@pytest.mark.parametrize("angle", [-720.0, -181.0, -180.0, 0.0, 179.0, 181.0, 540.0])
def test_angles_are_wrapped(angle: float) -> None:
    found = yaw.wrapped(angle)
    assert -180 <= found <= 180
    assert math.remainder(found - angle, 360) == pytest.approx(0, abs=1e-9)


def test_a_yaw_rate_is_turned_with_while_moving() -> None:
    aloft = hovering()
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 0, 0, 0, 3, 0, YawMode(True, 20)))
    assert aloft.vehicle.quadrotor.rate[2] == pytest.approx(math.radians(20), rel=0.02)


def test_attitudes_are_held_at_a_height() -> None:
    aloft = hovering()
    aloft.fly(attitude.move_by_roll_pitch_yaw_z(aloft.vehicle, 0.1, -0.05, 0.3, -10.0, 4))
    assert angles(aloft) == pytest.approx((0.1, -0.05, 0.3), abs=0.01)
    assert aloft.vehicle.quadrotor.position[2] == pytest.approx(-10.0, abs=0.3)


def test_attitudes_are_held_with_a_yaw_rate() -> None:
    aloft = hovering()
    aloft.fly(attitude.move_by_roll_pitch_yawrate_z(aloft.vehicle, 0.1, 0.0, 0.4, -10.0, 4))
    assert angles(aloft)[0] == pytest.approx(0.1, abs=0.01)
    assert aloft.vehicle.quadrotor.rate[2] == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize(
    "move",
    [
        lambda v: attitude.move_by_roll_pitch_yaw_throttle(v, 0.0, 0.0, 0.0, 0.65, 1),
        lambda v: attitude.move_by_roll_pitch_yawrate_throttle(v, 0.0, 0.0, 0.0, 0.65, 1),
        lambda v: attitude.move_by_angle_rates_throttle(v, 0.0, 0.0, 0.0, 0.65, 1),
        lambda v: attitude.move_by_motor_pwms(v, 0.65, 0.65, 0.65, 0.65, 1),
    ],
)
def test_throttle_drives_the_rotors(move: Callable[[ServedVehicle], Move]) -> None:
    aloft = hovering()
    log, _, answer = aloft.logged(move)
    assert answer
    # At 0.594 it hovers; 0.65 of four times 4.18 N in this air climbs by 0.92 m/s², less drag.
    assert -log[-1, 6] == pytest.approx(0.92, abs=0.08)


def test_rates_are_held_at_a_height() -> None:
    aloft = hovering()
    aloft.fly(attitude.move_by_angle_rates_z(aloft.vehicle, 0.0, 0.0, 0.5, -10.0, 3))
    assert aloft.vehicle.quadrotor.rate == pytest.approx([0, 0, 0.5], abs=0.01)


def test_turning_at_a_rate_holds_the_position_but_for_the_nose() -> None:
    aloft = hovering()
    start = aloft.vehicle.quadrotor.position.copy()
    _, took, answer = aloft.logged(lambda v: rotate.rotate_by_yaw_rate(v, -30, 3))
    assert answer
    assert took == pytest.approx(3.0, abs=0.022)
    lag = airframe.INERTIA[2] / (4 * airframe.TORQUE_MAX * 0.25)  # of the rate loop, s
    assert math.degrees(angles(aloft)[2]) == pytest.approx(-30 * (3 - lag), abs=1.5)
    assert aloft.vehicle.quadrotor.position == pytest.approx(start, abs=0.02)


@pytest.mark.parametrize("target", [90.0, -135.0, 200.0])
def test_turning_to_an_angle_ends_within_the_margin(target: float) -> None:
    aloft = hovering()
    assert aloft.fly(rotate.rotate_to_yaw(aloft.vehicle, target, NEVER, 3))
    assert abs(math.remainder(math.degrees(angles(aloft)[2]) - target, 360)) <= 3.1
    assert not aloft.fly(rotate.rotate_to_yaw(aloft.vehicle, target + 150, 0.5, 3))


def test_paths_are_flown_through_their_points() -> None:
    aloft = hovering()
    points = [(15.0, 0.0, -10.0), (15.0, 12.0, -13.0)]
    log, _, answer = aloft.logged(lambda v: path.move_on_path(v, points, 3, NEVER, 0, AS_IT_IS, -1, 1))
    assert answer
    for point in points:
        assert np.linalg.norm(log[:, P] - point, axis=1).min() < 1.0
    assert np.linalg.norm(log[:, V], axis=1).max() == pytest.approx(3.0, abs=0.4)


def test_a_path_is_flown_nose_first() -> None:
    aloft = hovering()
    points = [(0.0, 30.0, -10.0)]
    aloft.fly(path.move_on_path(aloft.vehicle, points, 3, 8.0, FORWARD, TO_ANGLE, -1, 1))
    assert math.degrees(angles(aloft)[2]) == pytest.approx(90, abs=3)


def test_a_path_that_takes_too_long_is_given_up() -> None:
    aloft = hovering()
    _, took, answer = aloft.logged(lambda v: path.move_to_position(v, 50, 0, -10, 2, 3.0, 0, AS_IT_IS, -1, 1))
    assert not answer
    assert took == pytest.approx(3.0, abs=0.022)


def test_a_fixed_lookahead_needs_no_adaption() -> None:
    aloft = hovering()
    assert aloft.fly(path.move_to_position(aloft.vehicle, 20, 0, -10, 3, NEVER, 0, AS_IT_IS, 4.0, 0.0)) in (True, False)
    assert aloft.vehicle.quadrotor.position[0] > 19


@pytest.mark.parametrize(
    ("drivetrain", "mode", "speed", "lookahead", "words"),
    [
        (0, AS_IT_IS, 5.0, 0.0, "lookahead distance cannot be 0"),
        (
            0,
            AS_IT_IS,
            60.0,
            1.0,
            "lookahead value 1.000000 is too small for velocity 60.000000. It must be at least 1.200000",
        ),
        (0, AS_IT_IS, 1.0, 0.3, "lookahead value 0.300000 is smaller than drone's distance accuracy 0.500000."),
        (FORWARD, AS_IT_IS, 5.0, -1.0, "Yaw cannot be specified as rate if drivetrain is ForwardOnly"),
    ],
)
def test_paths_that_cannot_be_flown_are_refused(
    drivetrain: int, mode: YawMode, speed: float, lookahead: float, words: str
) -> None:
    aloft = on_ground()
    with pytest.raises(Refused, match=f"^{words}$"):
        aloft.fly(path.move_to_position(aloft.vehicle, 9, 0, -9, speed, NEVER, drivetrain, mode, lookahead, 1))


def test_an_empty_path_is_flown_at_once() -> None:
    aloft = on_ground()
    assert aloft.fly(path.move_on_path(aloft.vehicle, [], 3, NEVER, 0, AS_IT_IS, -1, 1))


def test_legs_of_no_length_are_passed() -> None:
    legs = Legs([(0, 0, 0), (1, 0, 0), (1, 0, 0), (1, 2, 0)])
    place = legs.ahead(legs.start(), 1.5)
    assert place.leg == 2
    assert place.point == pytest.approx((1, 0.5, 0))
    assert legs.left(place) == pytest.approx(1.5)
    assert legs.ended(legs.ahead(place, 5.0))
    assert legs.ahead(place, 5.0).point == (1, 2, 0)


@pytest.mark.parametrize(
    "move",
    [
        lambda v: velocity.move_by_velocity(v, 1, 0, 0, 0, 0, AS_IT_IS),
        lambda v: velocity.move_by_velocity_body_frame(v, 1, 0, 0, -1, 0, AS_IT_IS),
        lambda v: velocity.move_by_velocity_z_body_frame(v, 1, 0, -5, 0, 0, AS_IT_IS),
        lambda v: attitude.move_by_motor_pwms(v, 1, 1, 1, 1, 0),
        lambda v: rotate.rotate_by_yaw_rate(v, 10, 0),
        lambda v: rotate.rotate_to_yaw(v, 10, 0, 5),
        lambda v: manual.move_by_manual(v, 1, 1, 1, 0, 0, AS_IT_IS),
    ],
)
def test_moves_of_no_duration_answer_true_at_once(move: Callable[[ServedVehicle], Move]) -> None:
    _, took, answer = on_ground().logged(move)
    assert (took, answer) == (0.0, True)


def test_a_velocity_at_a_height_of_no_duration_answers_false() -> None:
    _, took, answer = on_ground().logged(lambda v: velocity.move_by_velocity_z(v, 1, 0, -5, 0, 0, AS_IT_IS))
    assert (took, answer) == (0.0, False)


def test_taking_off_is_refused_in_motion() -> None:
    aloft = hovering()
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 2, 0, 0, 2, 0, AS_IT_IS))
    with pytest.raises(Refused, match="Cannot perform takeoff because vehicle is already moving with velocity"):
        aloft.fly(vertical.take_off(aloft.vehicle, 20))


def test_without_control_a_move_takes_its_time_and_moves_nothing() -> None:
    aloft = on_ground()
    aloft.vehicle.quadrotor.take_control(False)
    log, took, answer = aloft.logged(lambda v: velocity.move_by_velocity(v, 2, 0, -2, 1, 0, AS_IT_IS))
    assert answer
    assert took == pytest.approx(1.0, abs=0.022)
    assert not log[:, P].any()


def test_after_a_landing_the_vehicle_still_takes_itself_to_fly_unless_ideal() -> None:
    for ideal in (False, True):
        aloft = hovering(-3.0, ideal=ideal)
        assert aloft.fly(vertical.land(aloft.vehicle, 60))
        aloft.idle(1.0)
        assert bool(aloft.vehicle.quadrotor["flying"]) is not ideal
        assert aloft.vehicle.quadrotor["grounded"]


def test_sticks_are_flown_as_velocities_at_a_height() -> None:
    aloft = hovering()
    aloft.vehicle.rc_data = RCData(pitch=5000.0, roll=0.0, is_valid=True)
    aloft.fly(manual.move_by_manual(aloft.vehicle, 4, 4, 1, 8, 0, AS_IT_IS))
    assert aloft.vehicle.quadrotor.velocity[0] == pytest.approx(2.0, abs=0.15)
    aloft.vehicle.rc_data = RCData(timestamp=1, pitch=5000.0, is_valid=True)
    aloft.fly(manual.move_by_manual(aloft.vehicle, 4, 4, 1, 3, 0, AS_IT_IS))
    assert aloft.vehicle.quadrotor.velocity[0] == pytest.approx(0.0, abs=0.6)


def test_an_ideal_vehicle_takes_off_to_its_height() -> None:
    aloft = on_ground(ideal=True)
    assert aloft.fly(vertical.take_off(aloft.vehicle, 20))
    aloft.idle(2.0)
    assert aloft.vehicle.quadrotor.position == pytest.approx([0, 0, -2], abs=0.1)


@pytest.mark.parametrize("goal", [(0.4, 0.0, -10.0), (30.0, -8.0, -12.0), (0.0, 0.0, -10.3)])
def test_an_ideal_vehicle_arrives_where_it_is_sent(goal: tuple[float, float, float]) -> None:
    aloft = hovering(ideal=True)
    log, _, answer = aloft.logged(lambda v: path.move_to_position(v, *goal, 5, NEVER, 0, AS_IT_IS, -1, 1), after=3.0)
    assert answer
    assert aloft.vehicle.quadrotor.position == pytest.approx(goal, abs=0.1)
    far = np.linalg.norm(np.subtract(goal, log[0, P]))
    assert np.linalg.norm(log[:, P] - log[0, P], axis=1).max() < far + 0.3


def test_an_ideal_step_does_not_depend_on_the_height() -> None:
    logs = []
    for z in (-5.0, -40.0):
        step = partial(velocity.move_by_velocity_z, vx=5, vy=0, z=z, duration=5, drivetrain=0, mode=AS_IT_IS)
        log, _, _ = hovering(z, ideal=True).logged(step)
        logs.append(np.interp(np.arange(0, 5, 0.1), log[:, T], log[:, 4]))
    assert logs[0] == pytest.approx(logs[1], abs=0.05)


def test_an_ideal_landing_in_the_climb_goes_on_to_the_ground() -> None:
    aloft = hovering(-3.0, ideal=True)
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 0, 0, -2, 1, 0, AS_IT_IS))
    assert aloft.fly(vertical.land(aloft.vehicle, 60))
    assert aloft.vehicle.quadrotor.position[2] == pytest.approx(0, abs=0.01)
