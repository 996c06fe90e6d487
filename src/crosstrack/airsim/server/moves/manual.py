"""Flight by the sticks of a remote control, as velocities at a height."""

from typing import Protocol

from crosstrack.airsim.firmware.body import to_body
from crosstrack.airsim.server.moves import yaw
from crosstrack.airsim.server.moves.polling import Flown, Move, keep
from crosstrack.airsim.server.moves.velocity import steer_at
from crosstrack.airsim.structs import RCData, YawMode

FULL = 10_000.0
"""what a stick says at full travel, and a stick of moveByRC never does: these say 1"""
YAW_FULL = 100.0
"""deg or deg/s, of the yaw stick at full travel"""
FRESH = 0.1
"""s, of age, up to which what the sticks say is flown; a time of 0 is always fresh"""


class Sticked(Flown, Protocol):
    """A vehicle with a remote control."""

    @property
    def rc_data(self) -> RCData:
        """What its remote control said last."""


def move_by_manual(
    vehicle: Sticked, vx_max: float, vy_max: float, z_min: float, duration: float, drivetrain: int, mode: YawMode
) -> Move:
    """Fly by the sticks for a duration (s), in the heading at the start, with speeds (m/s) at full travel."""
    if duration <= 0:
        return True
    x, y, z, w = vehicle.quadrotor.attitude.tolist()

    def follow() -> None:
        sticks = vehicle.rc_data
        if not sticks.is_valid or (sticks.timestamp and vehicle.now - sticks.timestamp > FRESH * 1e9):
            return
        world = (sticks.pitch * vy_max / FULL, sticks.roll * vx_max / FULL, 0.0)
        vx, vy, vz = to_body(world, (x, y, z, w))
        turned = YawMode(mode.is_rate, mode.yaw_or_rate + sticks.yaw * YAW_FULL / FULL)
        height = sticks.throttle / FULL * z_min + float(vehicle.quadrotor.position[2])
        steer_at(vehicle, vx, vy, height, yaw.along(vx, vy, vz, drivetrain, turned))

    return (yield from keep(vehicle, follow, duration))
