"""Moves by attitude or rates with a throttle or a height, and by the motors themselves.

Angles and rates are of FRD: roll right, pitch nose up, yaw clockwise are positive.
"""

from crosstrack.airsim.firmware.quadrotor import Four, Modes
from crosstrack.airsim.firmware.rows import ANGLE, DIRECT, POSITION, RATE
from crosstrack.airsim.server.moves.polling import Flown, Move, command, keep


def held(vehicle: Flown, goal: Four, mode: Modes, duration: float) -> Move:
    """Hold goals for a duration (s)."""
    if duration <= 0:
        return True
    return (yield from keep(vehicle, lambda: command(vehicle, goal, mode), duration))


def move_by_motor_pwms(
    vehicle: Flown, front_right: float, rear_left: float, front_left: float, rear_right: float, duration: float
) -> Move:
    """Drive the motors, each 0 to 1, for a duration (s)."""
    goal = (front_right, rear_left, front_left, rear_right)
    return held(vehicle, goal, (DIRECT, DIRECT, DIRECT, DIRECT), duration)


def move_by_roll_pitch_yaw_z(vehicle: Flown, roll: float, pitch: float, yaw: float, z: float, duration: float) -> Move:
    """Hold an attitude (rad) at a height z (m, down) for a duration (s)."""
    return held(vehicle, (roll, pitch, yaw, z), (ANGLE, ANGLE, ANGLE, POSITION), duration)


def move_by_roll_pitch_yaw_throttle(
    vehicle: Flown, roll: float, pitch: float, yaw: float, throttle: float, duration: float
) -> Move:
    """Hold an attitude (rad) with a throttle, 0 to 1, for a duration (s)."""
    return held(vehicle, (roll, pitch, yaw, throttle), (ANGLE, ANGLE, ANGLE, DIRECT), duration)


def move_by_roll_pitch_yawrate_throttle(
    vehicle: Flown, roll: float, pitch: float, yaw_rate: float, throttle: float, duration: float
) -> Move:
    """Hold roll and pitch (rad) and a yaw rate (rad/s) with a throttle, 0 to 1, for a duration (s)."""
    return held(vehicle, (roll, pitch, yaw_rate, throttle), (ANGLE, ANGLE, RATE, DIRECT), duration)


def move_by_roll_pitch_yawrate_z(
    vehicle: Flown, roll: float, pitch: float, yaw_rate: float, z: float, duration: float
) -> Move:
    """Hold roll and pitch (rad) and a yaw rate (rad/s) at a height z (m, down) for a duration (s)."""
    return held(vehicle, (roll, pitch, yaw_rate, z), (ANGLE, ANGLE, RATE, POSITION), duration)


def move_by_angle_rates_z(
    vehicle: Flown, roll_rate: float, pitch_rate: float, yaw_rate: float, z: float, duration: float
) -> Move:
    """Hold rates (rad/s) at a height z (m, down) for a duration (s)."""
    return held(vehicle, (roll_rate, pitch_rate, yaw_rate, z), (RATE, RATE, RATE, POSITION), duration)


def move_by_angle_rates_throttle(
    vehicle: Flown, roll_rate: float, pitch_rate: float, yaw_rate: float, throttle: float, duration: float
) -> Move:
    """Hold rates (rad/s) with a throttle, 0 to 1, for a duration (s)."""
    return held(vehicle, (roll_rate, pitch_rate, yaw_rate, throttle), (RATE, RATE, RATE, DIRECT), duration)
