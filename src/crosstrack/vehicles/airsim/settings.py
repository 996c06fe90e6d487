"""AirSim's settings.json for a mission: the sensors of its vehicles, by names that the flight looks for."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from crosstrack.errors import Problem
from crosstrack.protocols import Sensor
from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.distance_ring import DistanceRing
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.ranging import Ranging

LIDAR, CAMERA, RING, DISTANCE = "Lidar", "Depth", "Ring", "Distance"
"""names, with the number of the sensor in the mission; a ring's with the number of the beam too"""
DISTANCE_TYPE, LIDAR_TYPE = 5, 6
"""AirSim's numbers for sensors"""
DEPTH_PLANAR, DEPTH_PERSPECTIVE = 1, 2
"""and for images of distances, along the axis and along the rays"""
TURNS = 10
"""a second, of AirSim's lidars: as often as they are updated, so that each update is a whole turn"""
BEYOND = 1.0
"""m, that distance sensors reach farther than the mission says: of nothing seen they answer that, and noise of 0.2 m"""
NEAR = 1e-6


def mounted(sensor: Ranging) -> dict[str, float]:
    """Return where a sensor sits, as AirSim has it: forward, right, down, degrees nose up and clockwise."""
    ahead, left, up = sensor.position
    return {"X": ahead, "Y": -left, "Z": -up, "Roll": 0.0, "Pitch": -sensor.pitch_deg, "Yaw": -sensor.yaw_deg}


def lidar_settings(lidar: Lidar) -> dict[str, Any]:
    """Return the settings of a lidar; a scan is one whole turn."""
    half = 0.5 * lidar.fov_deg
    return {
        "SensorType": LIDAR_TYPE,
        "Enabled": True,
        "NumberOfChannels": lidar.rings,
        "Range": lidar.range,
        "RotationsPerSecond": TURNS,
        # Over the whole turn, of which the field of view is cut; one more, so that no column falls between two.
        "PointsPerSecond": lidar.rings * math.ceil(360.0 / lidar.fov_deg * lidar.columns + 1) * TURNS,
        "HorizontalFOVStart": -half,
        "HorizontalFOVEnd": half,
        "VerticalFOVLower": lidar.lowest_deg,
        "VerticalFOVUpper": lidar.highest_deg,
        "DataFrame": "SensorLocalFrame",
        **mounted(lidar),
    }


def camera_settings(camera: DepthCamera) -> dict[str, Any]:
    """Return the settings of a camera."""
    return {"CaptureSettings": [capture_settings(camera, DEPTH_PERSPECTIVE)], **mounted(camera)}


def capture_settings(camera: DepthCamera, kind: int) -> dict[str, Any]:
    """Return the settings of a kind of image."""
    return {"ImageType": kind, "Width": camera.width, "Height": camera.height, "FOV_Degrees": camera.fov_deg}


def depth_kind(camera: DepthCamera, given: Mapping[str, Any]) -> int | None:
    """Return the kind of depth image that a camera of AirSim makes as the mission wants it; None for none."""
    for kind in (DEPTH_PERSPECTIVE, DEPTH_PLANAR):
        wanted = capture_settings(camera, kind)
        if any(same(capture, wanted) for capture in given.get("CaptureSettings", ())):
            return kind
    return None


def beam_settings(ring: DistanceRing, beam: int) -> dict[str, Any]:
    """Return the settings of the distance sensor of one beam."""
    place = mounted(ring)
    return {
        "SensorType": DISTANCE_TYPE,
        "Enabled": True,
        "MinDistance": 0.0,
        "MaxDistance": ring.range + BEYOND,
        **place,
        "Yaw": place["Yaw"] - 360.0 * beam / ring.count,
    }


def sensors_of(sensors: Sequence[Sensor]) -> dict[str, dict[str, Any]]:
    """Return what a vehicle's part of settings.json says of sensors: `Sensors` and `Cameras`."""
    found: dict[str, dict[str, Any]] = {"Sensors": {}, "Cameras": {}}
    for k, sensor in enumerate(sensors):
        if isinstance(sensor, Lidar):
            found["Sensors"][f"{LIDAR}{k}"] = lidar_settings(sensor)
        elif isinstance(sensor, DepthCamera):
            found["Cameras"][f"{CAMERA}{k}"] = camera_settings(sensor)
        elif isinstance(sensor, DistanceRing):
            for beam in range(sensor.count):
                found["Sensors"][f"{RING}{k}{DISTANCE}{beam}"] = beam_settings(sensor, beam)
    return found


def differences(sensors: Sequence[Sensor], settings: Mapping[str, Any]) -> list[Problem]:
    """Return how a vehicle's part of AirSim's settings differs from what the sensors of a mission need."""
    problems = []
    for k, sensor in enumerate(sensors):
        if not isinstance(sensor, Lidar | DepthCamera | DistanceRing):
            problems.append(Problem(f"sensors[{k}]", f"AirSim has nothing like {type(sensor).__name__}"))
    for group, wanted in sensors_of(sensors).items():
        given = settings.get(group) or {}
        for name, needed in wanted.items():
            if name not in given:
                problems.append(Problem(f"{group}.{name}", f"is missing; write {json.dumps(needed)}"))
                continue
            for key, value in needed.items():
                found = given[name].get(key)
                fits = same(found, value)
                if key == "CaptureSettings":
                    fits = depth_kind(camera_of(sensors, name), given[name]) is not None
                if key != "DataFrame" and not fits:
                    problems.append(Problem(f"{group}.{name}.{key}", f"must be {value!r}, found {found!r}"))
    return problems


def camera_of(sensors: Sequence[Sensor], name: str) -> DepthCamera:
    """Return the camera of a mission that a name stands for."""
    camera = sensors[int(name.removeprefix(CAMERA))]
    assert isinstance(camera, DepthCamera)  # by its name
    return camera


def same(found: object, wanted: object) -> bool:
    """Return whether two values of settings are equal, but for rounding."""
    if isinstance(found, int | float) and isinstance(wanted, int | float):
        return abs(found - wanted) <= NEAR * max(1.0, abs(wanted))
    if isinstance(found, Sequence) and isinstance(wanted, Sequence) and not isinstance(wanted, str):
        return len(found) == len(wanted) and all(map(same, found, wanted))
    if isinstance(found, Mapping) and isinstance(wanted, Mapping):
        return all(same(found.get(key), value) for key, value in wanted.items())
    return found == wanted
