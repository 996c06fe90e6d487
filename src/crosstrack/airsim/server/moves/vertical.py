"""Take-off, landing, the way home, and hovering.

**Mistakes of the original, kept** unless the vehicle is `ideal`: take-off ends some half metre short of its two metres
and answers false, as does the way home, which ends half a metre above the start and does not land; a landing is over
as soon as the vehicle does not sink for a fifth of a second, even in mid-air; afterwards the firmware still takes it to
be flying.

An ideal vehicle has landed when the ground holds it, and idles its rotors then.
"""

import math

from crosstrack.airsim.firmware.rows import DIRECT, RATE
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.moves.path import move_to_position, move_to_z
from crosstrack.airsim.server.moves.polling import Flown, Move, command, until
from crosstrack.airsim.server.moves.velocity import steer
from crosstrack.airsim.structs import YawMode

TAKEOFF_HEIGHT = 2.0
"""m"""
CALM = 0.5
"""m/s, of take-off and the way home"""
LANDING_SPEED = 0.2
"""m/s"""
STILL = 0.05
"""m/s, that is taken for standing"""
LOOKS = 10
"""in a row without sinking, after which it has landed"""
KEEP = YawMode(True, 0.0)
"""the heading as it is"""


def take_off(vehicle: Flown, timeout: float) -> Move:
    """Climb from rest.

    Raises:
        Refused: it moves already.
    """
    speed = math.hypot(*vehicle.quadrotor.velocity.tolist())
    if speed > STILL:
        raise Refused(f"Cannot perform takeoff because vehicle is already moving with velocity {speed:f} m/s")
    x, y, z = vehicle.quadrotor.position.tolist()
    target = z - TAKEOFF_HEIGHT
    return (yield from move_to_position(vehicle, x, y, target, CALM, timeout, 0, KEEP, -1, 1))


def land(vehicle: Flown, timeout: float) -> Move:
    """Sink until the ground stops it."""
    looks = 0

    def landed() -> bool:
        nonlocal looks
        looks = 0 if float(vehicle.quadrotor.velocity[2]) > STILL else looks + 1
        steer(vehicle, 0.0, 0.0, LANDING_SPEED, KEEP)
        return bool(vehicle.quadrotor["grounded"]) if vehicle.ideal else looks > LOOKS

    done = yield from until(vehicle, landed, timeout)
    if done and vehicle.ideal:
        command(vehicle, (0.0, 0.0, 0.0, 0.0), (RATE, RATE, RATE, DIRECT))
    return done


def go_home(vehicle: Flown, timeout: float) -> Move:
    """Fly straight to where it started."""
    return move_to_position(vehicle, 0.0, 0.0, 0.0, CALM, timeout, 0, KEEP, -1, 1)


def hover(vehicle: Flown) -> Move:
    """Stay here; the firmware holds the position where it is when commands stop."""
    z = float(vehicle.quadrotor.position[2])
    return move_to_z(vehicle, z, CALM, math.inf, YawMode(True, 0.0), 1.0, 0.0)
