"""Poses in AirSim's frames: world north, east, down; bodies forward, right, down."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from crosstrack import frames
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array


def matrix(orientation: Array) -> Array:
    """Return the matrix (3, 3) from the body to the world of a quaternion xyzw, which need not be of length one."""
    turned: Array = Rotation.from_quat(orientation).as_matrix()
    return turned


def from_angles(yaw: float, pitch: float, roll: float) -> Array:
    """Return the quaternion xyzw that yaws, then pitches, then rolls (degrees, NaN for 0)."""
    angles = np.nan_to_num([yaw, pitch, roll])
    turned: Array = Rotation.from_euler("ZYX", angles, degrees=True).as_quat()
    return turned


def angles(orientation: Array) -> tuple[float, float, float]:
    """Return yaw, pitch and roll (degrees) of a quaternion xyzw; roll is 0 where the nose points up or down."""
    turn = matrix(orientation)
    flat = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.degrees(math.atan2(-turn[2, 0], flat))
    if flat < 1e-9:
        return math.degrees(math.atan2(-turn[0, 1], turn[1, 1])), pitch, 0.0
    roll = math.atan2(turn[2, 1], turn[2, 2])
    return math.degrees(math.atan2(turn[1, 0], turn[0, 0])), pitch, math.degrees(roll)


def onto(parent: Pose, child: Pose) -> Pose:
    """Return a pose that is given relative to another in the frame of that other."""
    turn = Rotation.from_quat(parent.orientation)
    position = parent.position + turn.apply(child.position)
    return Pose(position, (turn * Rotation.from_quat(child.orientation)).as_quat())


def seen_from(parent: Pose, other: Pose) -> Pose:
    """Return a pose relative to another, both given in the same frame; undoes `onto`."""
    back = Rotation.from_quat(parent.orientation).inv()
    position = back.apply(other.position - parent.position)
    return Pose(position, (back * Rotation.from_quat(other.orientation)).as_quat())


def turned_to_enu(orientation: Array) -> Array:
    """Return the matrix (3, 3) that turns vectors of a body (FRD) into the world (ENU)."""
    return np.ascontiguousarray(frames.enu_from_ned(matrix(orientation).T).T)


def usable(pose: Pose) -> bool:
    """Return whether a pose is made of finite numbers and its quaternion can be normalised."""
    finite = np.isfinite(pose.position).all() and np.isfinite(pose.orientation).all()
    return bool(finite and np.linalg.norm(pose.orientation) > 1e-6)
