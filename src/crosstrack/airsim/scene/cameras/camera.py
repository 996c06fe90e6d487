"""Cameras on a vehicle, or in the world."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from crosstrack.airsim.scene.cameras.lens import Lens
from crosstrack.airsim.scene.cameras.settings import CameraSettings, Capture, Gimbal
from crosstrack.airsim.scene.poses import angles, from_angles, onto
from crosstrack.airsim.structs import Pose, ProjectionMatrix

NEAR_PLANE = 10.0
"""of the projection, in its own units"""
USUAL = {
    "front_center": (0.46, 0.0, 0.0, 0.0, 0.0),
    "front_right": (0.46, 0.125, 0.0, 0.0, 0.0),
    "front_left": (0.46, -0.125, 0.0, 0.0, 0.0),
    "bottom_center": (0.0, 0.0, 0.0, 0.0, -90.0),
    "back_center": (-0.46, 0.0, 0.0, 180.0, 0.0),
}
"""m forward, right and down; degrees of yaw and pitch"""
ALIASES = {
    "0": "front_center",
    "1": "front_right",
    "2": "front_left",
    "3": "bottom_center",
    "4": "back_center",
    "": "front_center",
    "fpv": "front_center",
}
DISTORTION = ("K1", "K2", "K3", "P1", "P2")


@dataclass
class Camera:
    """A camera, as a client may have changed it."""

    pose: Pose
    """relative to what it is mounted on"""
    captures: dict[int, Capture]
    """how pictures are taken, by type"""
    gimbal: Gimbal = field(default_factory=Gimbal)
    lens: Lens = field(default_factory=Lens)
    fovs: dict[int, float] = field(default_factory=dict)
    """degrees, by type of picture, where set since"""
    distortion: dict[str, float] = field(default_factory=lambda: dict.fromkeys(DISTORTION, 0.0))
    """kept, but without effect on pictures"""
    wanted: dict[int, list[str]] = field(default_factory=dict)
    """patterns of the names to detect, by type of picture"""
    radius: dict[int, float] = field(default_factory=dict)
    """m, within which objects are detected, by type of picture"""

    def capture(self, image_type: int) -> Capture:
        """Return how pictures of a type are taken."""
        return self.captures.get(image_type, Capture())

    def view(self, image_type: int) -> float:
        """Return the field of view (degrees) of pictures of a type."""
        return self.fovs.get(image_type, self.capture(image_type).fov_degrees)

    def placed(self, mount: Pose) -> Pose:
        """Return where the camera is and how it is turned, from the pose of what it is mounted on."""
        pose = onto(mount, self.pose)
        share = min(self.gimbal.stabilization, 1.0)
        if share == 0.0:
            return pose
        kept = (self.gimbal.yaw, self.gimbal.pitch, self.gimbal.roll)
        mixed = [
            now if math.isnan(fixed) else share * fixed + (1.0 - share) * now
            for fixed, now in zip(kept, angles(pose.orientation), strict=True)
        ]
        return Pose(pose.position, from_angles(*mixed))

    def projection(self) -> ProjectionMatrix:
        """Return the matrix that takes homogeneous points of the camera (forward, right, down) to the picture.

        With the half field of view h: depth reversed, nothing cut off far away; the picture's x is right, y is up.
        """
        capture = self.capture(0)
        across, up = 1.0, capture.width / capture.height
        if capture.width < capture.height:
            across, up = 1.0 / up, 1.0
        scale = 1.0 / math.tan(math.radians(self.view(0)) / 2)
        rows = [[0, across * scale, 0, 0], [0, 0, -up * scale, 0], [0, 0, 0, NEAR_PLANE], [-1, 0, 0, 0]]
        return ProjectionMatrix(np.array(rows, dtype=np.float32))


def made(settings: CameraSettings, usual: tuple[float, float, float, float, float] = (0, 0, 0, 0, 0)) -> Camera:
    """Return a camera; what its settings leave out of its pose is as usual."""
    given = np.array([settings.x, settings.y, settings.z, settings.yaw, settings.pitch, settings.roll])
    x, y, z, yaw, pitch, roll = np.where(np.isnan(given), [*usual, 0.0], given)
    pose = Pose(np.array([x, y, z]), from_angles(yaw, pitch, roll))
    camera = Camera(pose, dict(settings.captures), settings.gimbal)
    if -1 in settings.captures:
        camera.lens.fov = settings.captures[-1].fov_degrees
    return camera


class Cameras:
    """Cameras by name; those of a multirotor go by numbers too."""

    def __init__(self, settings: Mapping[str, CameraSettings], defaults: CameraSettings, aboard: bool) -> None:
        self.cameras: dict[str, Camera] = {}
        names = [*USUAL, *(name for name in settings if name not in USUAL)] if aboard else list(settings)
        for name in names:
            self.cameras[name] = made(settings.get(name, defaults), USUAL.get(name, (0, 0, 0, 0, 0)))
        if aboard:
            for alias, name in ALIASES.items():
                self.cameras.setdefault(alias, self.cameras[name])

    def find(self, name: str) -> Camera | None:
        """Return the camera of a name; None where there is none."""
        return self.cameras.get(name)
