"""Calls that tell where a vehicle is and how it moves, or put it somewhere else."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import (
    CollisionInfo,
    EnvironmentState,
    GeoPoint,
    KinematicsState,
    MultirotorState,
    Pose,
    RotorStates,
)
from crosstrack.types import Array


def get_multirotor_state(simulator: Simulator, name: str) -> MultirotorState:
    """Return all that the vehicle knows of itself."""
    vehicle = simulator.vehicle(name)
    return MultirotorState(
        kinematics_estimated=vehicle.kinematics(),
        gps_location=vehicle.location(),
        timestamp=simulator.now,
        landed_state=int(vehicle.quadrotor["flying"]),
        rc_data=vehicle.rc_data,
    )


def get_rotor_states(simulator: Simulator, name: str) -> RotorStates:
    """Return how the rotors turn."""
    return simulator.vehicle(name).rotors()


def get_home_geo_point(simulator: Simulator, name: str) -> GeoPoint:
    """Return where on the earth the vehicle started."""
    return simulator.vehicle(name).home


def get_vehicle_pose(simulator: Simulator, name: str) -> Pose:
    """Return where the vehicle is relative to where it started."""
    return simulator.pawn(name).local_pose()


def set_vehicle_pose(simulator: Simulator, pose: Pose, ignore_collision: bool, name: str) -> None:
    """Put the vehicle somewhere else, relative to where it started.

    It is put there whatever lies between, as with `ignore_collision`: AirSim's own physics does not stop it either.
    """
    vehicle = simulator.pawn(name)
    vehicle.place(Pose(finite("position", pose.position), unit(pose.orientation)))


def get_ground_truth_kinematics(simulator: Simulator, name: str) -> KinematicsState:
    """Return how the vehicle moves, relative to where it started."""
    return simulator.pawn(name).kinematics()


def set_kinematics(simulator: Simulator, state: KinematicsState, ignore_collision: bool, name: str) -> None:
    """Give the vehicle another motion, relative to where it started."""
    vehicle = simulator.pawn(name)
    for part in ("linear_velocity", "angular_velocity", "linear_acceleration", "angular_acceleration"):
        finite(part, getattr(state, part))
    finite("position", state.position)
    vehicle.set_kinematics(replace(state, orientation=unit(state.orientation)))


def get_ground_truth_environment(simulator: Simulator, name: str) -> EnvironmentState:
    """Return the air and the gravity where the vehicle is."""
    return simulator.pawn(name).environment()


def get_collision_info(simulator: Simulator, name: str) -> CollisionInfo:
    """Return the last collision of the vehicle; the next time it will not have collided unless it does again."""
    vehicle = simulator.pawn(name)
    last = vehicle.collision
    vehicle.collision = replace(last, has_collided=False)
    return last


def list_vehicles(simulator: Simulator) -> list[str]:
    """Return the names of all vehicles."""
    return [name for name in simulator.vehicles if name]


def finite(name: str, vector: Array) -> Array:
    """Return a vector whose parts are all finite.

    Raises:
        Refused: they are not.
    """
    if not np.isfinite(vector).all():
        raise Refused(f"{name} must be finite, not {np.asarray(vector).tolist()}")
    return vector


def unit(orientation: Array) -> Array:
    """Return a quaternion at length one.

    Raises:
        Refused: it is not finite, or zero.
    """
    size = float(np.linalg.norm(finite("orientation", orientation)))
    if size < 1e-6:
        raise Refused("orientation must be a quaternion that turns, not zero")
    return np.asarray(orientation) / size


HANDLERS: dict[str, Callable[..., Any]] = {
    "getMultirotorState": get_multirotor_state,
    "getRotorStates": get_rotor_states,
    "getHomeGeoPoint": get_home_geo_point,
    "simGetVehiclePose": get_vehicle_pose,
    "simSetVehiclePose": set_vehicle_pose,
    "simGetGroundTruthKinematics": get_ground_truth_kinematics,
    "simSetKinematics": set_kinematics,
    "simGetGroundTruthEnvironment": get_ground_truth_environment,
    "simGetCollisionInfo": get_collision_info,
    "listVehicles": list_vehicles,
}
