"""Calls that fly a vehicle, and those that say who may."""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from crosstrack import frames
from crosstrack.airsim.firmware.rows import ANGLE_LOOP, POSITION_LOOP, RATE_LOOP, VELOCITY_LOOP
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.moves import attitude, manual, path, rotate, velocity, vertical
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import RCData, YawMode
from crosstrack.types import Array

LARGEST = float(np.finfo(np.float32).max)
"""of the numbers on AirSim's wire"""


def move_to_gps(
    vehicle: ServedVehicle, latitude: float, longitude: float, altitude: float, speed: float, *how: Any
) -> Move:
    """Fly straight to a point of the earth (deg, deg, m).

    As in AirSim everything is of single precision, even coordinates from the centre of the earth: the vehicle flies
    to a point of a grid of half a metre or so.
    """
    point = [float(np.float32(latitude)), float(np.float32(longitude)), altitude]
    home = [vehicle.home.latitude, vehicle.home.longitude, vehicle.home.altitude]
    there, here = (frames.ecef_from_geodetic(place).astype(np.float32).astype(float) for place in (point, home))
    exact_here = frames.ecef_from_geodetic(home)
    enu = frames.local_from_geodetic(frames.geodetic_from_ecef(exact_here + there - here), vehicle.origin)
    x, y, z = frames.ned_from_enu(enu).tolist()
    return path.move_to_position(vehicle, x, y, z, speed, *how)


MOVES: dict[str, tuple[Callable[..., Move], int | None]] = {
    "takeoff": (vertical.take_off, 0),
    "land": (vertical.land, 0),
    "goHome": (vertical.go_home, 0),
    "hover": (vertical.hover, None),
    "moveByVelocityBodyFrame": (velocity.move_by_velocity_body_frame, 3),
    "moveByVelocityZBodyFrame": (velocity.move_by_velocity_z_body_frame, 3),
    "moveByVelocity": (velocity.move_by_velocity, 3),
    "moveByVelocityZ": (velocity.move_by_velocity_z, 3),
    "moveByMotorPWMs": (attitude.move_by_motor_pwms, 4),
    "moveByRollPitchYawZ": (attitude.move_by_roll_pitch_yaw_z, 4),
    "moveByRollPitchYawThrottle": (attitude.move_by_roll_pitch_yaw_throttle, 4),
    "moveByRollPitchYawrateThrottle": (attitude.move_by_roll_pitch_yawrate_throttle, 4),
    "moveByRollPitchYawrateZ": (attitude.move_by_roll_pitch_yawrate_z, 4),
    "moveByAngleRatesZ": (attitude.move_by_angle_rates_z, 4),
    "moveByAngleRatesThrottle": (attitude.move_by_angle_rates_throttle, 4),
    "moveOnPath": (path.move_on_path, 2),
    "moveToPosition": (path.move_to_position, 4),
    "moveToGPS": (move_to_gps, 4),
    "moveToZ": (path.move_to_z, 2),
    "moveByManual": (manual.move_by_manual, 3),
    "rotateToYaw": (rotate.rotate_to_yaw, 1),
    "rotateByYawRate": (rotate.rotate_by_yaw_rate, 1),
}
"""by name: the move, and which of its arguments is a time and may be infinite"""


def numbers(arguments: Sequence[Any]) -> Iterator[float]:
    """Yield every number among arguments."""
    for argument in arguments:
        match argument:
            case float() | int():
                yield argument
            case YawMode():
                yield argument.yaw_or_rate
            case list() | tuple() | np.ndarray():
                yield from np.ravel(np.array(argument, float)).tolist()


def fly(name: str, simulator: Simulator, *arguments: Any) -> Any:
    """Start a move of the vehicle named last; return its answer to come."""
    move, time = MOVES[name]
    vehicle, given = simulator.vehicle(arguments[-1]), arguments[:-1]
    goals = [argument for index, argument in enumerate(given) if index != time]
    if not all(abs(number) <= LARGEST for number in numbers(goals)) or (time is not None and math.isnan(given[time])):
        raise Refused(f"{name} takes finite numbers only")
    return simulator.begin(vehicle, move(vehicle, *given), name, given)


def enable_api_control(simulator: Simulator, on: bool, name: str) -> None:
    """Let the API fly the vehicle, or its sticks."""
    vehicle = simulator.vehicle(name)
    if not on or vehicle.open_to_api:
        vehicle.quadrotor.take_control(on)


def is_api_control_enabled(simulator: Simulator, name: str) -> bool:
    """Return whether the API flies the vehicle."""
    return bool(simulator.vehicle(name).quadrotor["controlled"])


def arm_disarm(simulator: Simulator, on: bool, name: str) -> bool:
    """Arm the vehicle or disarm it; return whether that was possible."""
    return simulator.vehicle(name).quadrotor.arm(on)


def cancel_last_task(simulator: Simulator, name: str) -> None:
    """Stop the move under way; the firmware holds the position soon after."""
    simulator.vehicle(name).slot.cancel(simulator.now)


def move_by_rc(simulator: Simulator, data: RCData, name: str) -> None:
    """Move the sticks of the vehicle's remote control; they fly it while the API has no control."""
    vehicle = simulator.vehicle(name)
    sticks = [data.roll, -data.pitch, data.yaw, data.throttle, data.switches & 1, data.switches >> 1 & 1]
    if not np.isfinite(sticks).all():
        raise Refused("moveByRC takes finite numbers only")
    vehicle.rc_data = data
    vehicle.quadrotor.sticks(sticks, data.is_valid)


def set_gains(loop: int, simulator: Simulator, kp: Any, ki: Any, kd: Any, name: str) -> None:
    """Set the gains of a loop: of roll, pitch and yaw, or of x, y and z."""
    gains = np.zeros((3, 4))
    for row, given in zip(gains, (kp, ki, kd), strict=True):
        values = np.asarray(given, float)
        if len(values) < 3 or not np.isfinite(values).all():
            raise Refused("a controller takes three finite gains each")
        row[:] = (*values[:3], 0.0) if loop in (ANGLE_LOOP, RATE_LOOP) else (values[1], values[0], 0.0, values[2])
    if loop in (ANGLE_LOOP, RATE_LOOP):
        gains[0, 3] = 1.0
    simulator.vehicle(name).quadrotor.set_gains(loop, gains)


def set_safety(simulator: Simulator, *arguments: Any) -> bool:
    """Refuse, as AirSim does: no part of it ever installs what this would set."""
    simulator.vehicle(arguments[-1])
    raise Refused("The setSafety call requires safety_eval_ptr_ to be set first")


def set_ext_force(simulator: Simulator, force: Array) -> None:
    """Push every vehicle with a force (3,) N, NED, until told otherwise."""
    if not np.isfinite(force).all():
        raise Refused("simSetExtForce takes finite numbers only")
    simulator.push = np.array(force, float)


HANDLERS: dict[str, Callable[..., Any]] = {
    **{name: partial(fly, name) for name in MOVES},
    "enableApiControl": enable_api_control,
    "isApiControlEnabled": is_api_control_enabled,
    "armDisarm": arm_disarm,
    "cancelLastTask": cancel_last_task,
    "moveByRC": move_by_rc,
    "setAngleLevelControllerGains": partial(set_gains, ANGLE_LOOP),
    "setAngleRateControllerGains": partial(set_gains, RATE_LOOP),
    "setVelocityControllerGains": partial(set_gains, VELOCITY_LOOP),
    "setPositionControllerGains": partial(set_gains, POSITION_LOOP),
    "setSafety": set_safety,
    "simSetExtForce": set_ext_force,
}
