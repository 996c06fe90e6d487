"""Moves that turn on the spot, holding the position where they began."""

import math

from crosstrack.airsim.firmware.rows import POSITION
from crosstrack.airsim.server.moves.polling import Flown, Move, command, keep, until
from crosstrack.airsim.server.moves.velocity import heading
from crosstrack.airsim.server.moves.yaw import goal, wrapped
from crosstrack.airsim.structs import YawMode

STILL = 0.01
"""rad/s, of yaw, at which it has stopped turning"""


def hold(vehicle: Flown, position: list[float], mode: YawMode) -> None:
    """Ask for a position (m, NED)."""
    turn, meaning = goal(mode)
    x, y, z = position
    command(vehicle, (y, x, turn, z), (POSITION, POSITION, meaning, POSITION))


def rotate_to_yaw(vehicle: Flown, yaw: float, timeout: float, margin: float) -> Move:
    """Turn to a yaw (deg), to within a margin (deg); the difference is not taken the short way round, as in AirSim."""
    if timeout <= 0:
        return True
    start, target = vehicle.quadrotor.position.tolist(), wrapped(yaw)

    def turned() -> bool:
        near = abs(math.degrees(heading(vehicle)) - target) <= margin
        hold(vehicle, start, YawMode(True, 0.0) if near else YawMode(False, target))
        return near and abs(float(vehicle.quadrotor.rate[2])) <= STILL

    return (yield from until(vehicle, turned, timeout))


def rotate_by_yaw_rate(vehicle: Flown, yaw_rate: float, duration: float) -> Move:
    """Turn at a rate (deg/s) for a duration (s)."""
    if duration <= 0:
        return True
    start, mode = vehicle.quadrotor.position.tolist(), YawMode(True, yaw_rate)
    return (yield from keep(vehicle, lambda: hold(vehicle, start, mode), duration))
