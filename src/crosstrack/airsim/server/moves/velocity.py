"""Moves by velocity: the goal is the same at every look; the nose is turned once, at the start."""

import math

from crosstrack.airsim.firmware.rows import POSITION, VELOCITY
from crosstrack.airsim.server.moves import yaw
from crosstrack.airsim.server.moves.polling import Flown, Move, command, keep
from crosstrack.airsim.structs import YawMode


def heading(vehicle: Flown) -> float:
    """Return the yaw of a vehicle, rad clockwise from north."""
    x, y, z, w = vehicle.quadrotor.attitude.tolist()
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def steer(vehicle: Flown, vx: float, vy: float, vz: float, mode: YawMode) -> None:
    """Ask for a velocity (m/s, NED)."""
    turn, meaning = yaw.goal(mode)
    command(vehicle, (vy, vx, turn, vz), (VELOCITY, VELOCITY, meaning, VELOCITY))


def steer_at(vehicle: Flown, vx: float, vy: float, z: float, mode: YawMode) -> None:
    """Ask for a velocity north and east (m/s) at a height z (m, down)."""
    turn, meaning = yaw.goal(mode)
    command(vehicle, (vy, vx, turn, z), (VELOCITY, VELOCITY, meaning, POSITION))


def move_by_velocity(
    vehicle: Flown, vx: float, vy: float, vz: float, duration: float, drivetrain: int, mode: YawMode
) -> Move:
    """Fly a velocity (m/s, NED) for a duration (s)."""
    if duration <= 0:
        return True
    turned = yaw.along(vx, vy, 0.0, drivetrain, mode)
    return (yield from keep(vehicle, lambda: steer(vehicle, vx, vy, vz, turned), duration))


def move_by_velocity_z(
    vehicle: Flown, vx: float, vy: float, z: float, duration: float, drivetrain: int, mode: YawMode
) -> Move:
    """Fly a velocity north and east (m/s) at a height z (m, down) for a duration (s).

    Unlike the other moves it answers false for a duration that is not positive.
    """
    if duration <= 0:
        return False
    turned = yaw.along(vx, vy, 0.0, drivetrain, mode)
    return (yield from keep(vehicle, lambda: steer_at(vehicle, vx, vy, z, turned), duration))


def from_body(vehicle: Flown, vx: float, vy: float) -> tuple[float, float]:
    """Turn a velocity forward and right to north and east, by the heading now."""
    angle = heading(vehicle)
    return vx * math.cos(angle) - vy * math.sin(angle), vx * math.sin(angle) + vy * math.cos(angle)


def move_by_velocity_body_frame(
    vehicle: Flown, vx: float, vy: float, vz: float, duration: float, drivetrain: int, mode: YawMode
) -> Move:
    """Fly a velocity forward, right and down (m/s), by the heading at the start, for a duration (s)."""
    north, east = from_body(vehicle, vx, vy)
    return (yield from move_by_velocity(vehicle, north, east, vz, duration, drivetrain, mode))


def move_by_velocity_z_body_frame(
    vehicle: Flown, vx: float, vy: float, z: float, duration: float, drivetrain: int, mode: YawMode
) -> Move:
    """Fly a velocity forward and right (m/s), by the heading at the start, at a height z (m, down), for so long (s)."""
    if duration <= 0:
        return True
    north, east = from_body(vehicle, vx, vy)
    return (yield from move_by_velocity_z(vehicle, north, east, z, duration, drivetrain, mode))
