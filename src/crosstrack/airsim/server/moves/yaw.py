"""What moves do about yaw."""

import math

from crosstrack.airsim.firmware.rows import ANGLE, RATE
from crosstrack.airsim.structs import YawMode

FORWARD_ONLY = 1
"""drivetrain that keeps the nose in the direction of flight"""
SLOW = 0.5
"""m or m/s, of the way ahead, up to which the nose is left alone"""


def wrapped(degrees: float) -> float:
    """Return an angle within ±180°."""
    rest = math.fmod(degrees, 360)
    if rest > 180:
        return rest - 360
    return rest + 360 if rest < -180 else rest


def along(x: float, y: float, z: float, drivetrain: int, mode: YawMode) -> YawMode:
    """Turn an angle of yaw to be relative to the way ahead, where the vehicle flies nose first."""
    if drivetrain != FORWARD_ONLY or mode.is_rate:
        return mode
    if math.hypot(x, y, z) <= SLOW:
        return YawMode(True, 0.0)
    return YawMode(False, wrapped(mode.yaw_or_rate + math.degrees(math.atan2(y, x))))


def goal(mode: YawMode) -> tuple[float, int]:
    """Return the goal of the yaw axis (rad or rad/s), and what it means."""
    return math.radians(mode.yaw_or_rate), RATE if mode.is_rate else ANGLE
