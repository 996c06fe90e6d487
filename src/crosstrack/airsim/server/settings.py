"""AirSim's settings.json: what of it means something here, with AirSim's defaults.

Keys that are not known are ignored, as AirSim does; a known key with a wrong value is a problem, and all problems are
told at once.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, field_validator, model_validator

from crosstrack.airsim.scene.cameras.settings import IMAGE_TYPES, CameraSettings
from crosstrack.airsim.scene.poses import from_angles
from crosstrack.airsim.scene.section import UNSET, Above, AtLeast, Number, Section
from crosstrack.airsim.scene.sensors.suite import SensorSettings, usual
from crosstrack.airsim.server.transport import LOOPBACK, PORT
from crosstrack.airsim.structs import Pose
from crosstrack.errors import InputError, Problem
from crosstrack.frames import Origin

DEFAULT_VEHICLE = "SimpleFlight"
MOST_BYTES = 1 << 24
Sensors = Mapping[str, SensorSettings]


class OriginGeopoint(Section):
    """Where the origin of the world lies on the Earth."""

    latitude: float = Field(default=Origin.latitude, ge=-90, le=90)
    """degrees north"""
    longitude: float = Field(default=Origin.longitude, ge=-180, le=180)
    """degrees east"""
    altitude: Number = Origin.altitude
    """m"""


class Wind(Section):
    """The wind, m/s, NED."""

    x: Number = 0.0
    y: Number = 0.0
    z: Number = 0.0


class RecordedCamera(Section):
    """A picture of a recording."""

    camera_name: str = ""
    camera_id: int = Field(default=0, validation_alias="CameraID")
    """stands for the name where there is none"""
    image_type: int = Field(default=0, ge=0, lt=IMAGE_TYPES)
    pixels_as_float: bool = False
    compress: bool = True
    vehicle_name: str = ""
    """empty for the first vehicle"""

    @property
    def name(self) -> str:
        """Name or number of the camera."""
        return self.camera_name or str(self.camera_id)


class Recording(Section):
    """What a recording holds."""

    record_on_move: bool = False
    """only vehicles that have moved since"""
    record_interval: Above = 0.05
    """s"""
    folder: str = ""
    """in which recordings get a folder each; empty for `recordings` in the working folder"""
    enabled: bool = False
    """from the start on"""
    cameras: tuple[RecordedCamera, ...] | None = Field(default=None, strict=False)
    """None for the first camera of every vehicle"""


class VehicleSettings(Section):
    """A vehicle."""

    vehicle_type: Annotated[str, Field(min_length=1)]
    default_vehicle_state: str = ""
    """Armed or Disarmed; empty for Armed"""
    allow_api_always: bool = Field(default=True, validation_alias="AllowAPIAlways")
    auto_create: bool = True
    """whether it is there from the start on"""
    enable_trace: bool = False
    """whether its way is drawn"""
    enable_collisions: bool = True
    x: Number = UNSET
    """m, north of the origin of the world, where it starts"""
    y: Number = UNSET
    """m, east"""
    z: Number = UNSET
    """m, down"""
    yaw: Number = UNSET
    """degrees, clockwise from north"""
    pitch: Number = UNSET
    """degrees, nose up"""
    roll: Number = UNSET
    """degrees, right side down"""
    cameras: Mapping[str, CameraSettings] = Field(default={})
    """beside those that every multirotor has, or in place of them"""
    sensors: Sensors = Field(default={})
    """by name; of kinds not listed there are the usual ones"""

    @field_validator("vehicle_type")
    @classmethod
    def flown_here(cls, kind: str) -> str:
        """Refuse vehicles that need another firmware."""
        if kind.lower() != "simpleflight":
            raise ValueError("only SimpleFlight is flown here")
        return kind

    @property
    def start(self) -> Pose:
        """World NED; at the origin, looking north, where nothing is said."""
        position = np.nan_to_num([self.x, self.y, self.z])
        return Pose(position, from_angles(self.yaw, self.pitch, self.roll))


class Settings(Section):
    """What settings.json says."""

    sim_mode: Literal["", "Multirotor"] = ""
    """cars and vehicles without physics are not offered"""
    clock_speed: Annotated[float, Field(ge=0.01, le=1000)] = 1.0
    local_host_ip: str = ""
    """address to listen at; empty for this machine only"""
    api_server_port: int = Field(default=PORT, ge=1, le=65535)
    origin_geopoint: OriginGeopoint = OriginGeopoint()
    wind: Wind = Wind()
    recording: Recording = Recording()
    camera_defaults: CameraSettings = CameraSettings()
    """of cameras without settings of their own"""
    external_cameras: Mapping[str, CameraSettings] = Field(default={})
    """that stand in the world"""
    default_sensors: Sensors = Field(default_factory=usual)
    vehicles: Mapping[str, VehicleSettings] = Field(default={})
    show_los_debug_lines: bool = False
    speed_unit_factor: AtLeast = 1.0
    text: str = Field(default="", validation_alias="\0text")
    """the file as it was read"""

    @model_validator(mode="before")
    @classmethod
    def completed(cls, found: Any) -> Any:
        """Add what vehicles take over from the whole: their usual sensors, and what their cameras have in common."""
        if not isinstance(found, dict):
            return found
        found = dict(found)
        common = found.get("CameraDefaults")
        for key in ("Vehicles", "ExternalCameras"):
            if isinstance(found.get(key), dict):
                section = found[key]
                found[key] = {name: _inherited(section[name], common, key == "Vehicles") for name in sorted(section)}
        return found

    @property
    def origin(self) -> Origin:
        """Where the origin of the world lies on the Earth."""
        place = self.origin_geopoint
        return Origin(place.latitude, place.longitude, place.altitude)

    @property
    def address(self) -> str:
        """Where to listen."""
        return self.local_host_ip or LOOPBACK

    def fleet(self) -> dict[str, VehicleSettings]:
        """Return the vehicles that are there from the start on, by name in AirSim's order."""
        if not self.vehicles:
            return {DEFAULT_VEHICLE: VehicleSettings(vehicle_type="SimpleFlight")}
        return {name: self.vehicles[name] for name in sorted(self.vehicles) if self.vehicles[name].auto_create}

    def sensors(self, vehicle: VehicleSettings) -> dict[str, SensorSettings]:
        """Return the sensors of a vehicle: its own, and the usual ones of kinds that it does not list."""
        listed = {sensor.sensor_type for sensor in vehicle.sensors.values()}
        others = {name: one for name, one in self.default_sensors.items() if one.sensor_type not in listed}
        return {**others, **vehicle.sensors}


def _inherited(section: Any, common: Any, vehicle: bool) -> Any:
    """Return a vehicle, or a camera, with what all cameras have in common in each of its cameras."""
    if not isinstance(common, dict) or not isinstance(section, dict):
        return section
    if not vehicle:
        return _camera(common, section)
    cameras = section.get("Cameras")
    if not isinstance(cameras, dict):
        return section
    return {**section, "Cameras": {name: _camera(common, camera) for name, camera in cameras.items()}}


def _camera(common: dict[str, Any], camera: Any) -> Any:
    """Return a camera with what it leaves out; its captures replace those of the same type."""
    if not isinstance(camera, dict):
        return camera
    both = {**common, **camera}
    one, two = common.get("CaptureSettings", []), camera.get("CaptureSettings", [])
    if isinstance(one, list) and isinstance(two, list):
        both["CaptureSettings"] = [*one, *two]
    return both


def read(path: Path) -> Settings:
    """Read a file.

    Raises:
        InputError: it is missing, is no JSON, or a known key has a wrong value.
    """
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise InputError(str(path), [Problem("", f"it is {size} bytes; at most {MOST_BYTES} are read")])
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), [Problem("", f"cannot be read: {error}")]) from error
    return parse(text, str(path))


def parse(text: str, source: str = "settings.json") -> Settings:
    """Return the settings in a text, which may have comments.

    Raises:
        InputError: it is no JSON, or a known key has a wrong value.
    """
    try:
        found = json.loads(uncommented(text), parse_constant=_no_number)
    except json.JSONDecodeError as error:
        raise InputError(source, [Problem("", f"no JSON: {error.msg}", error.lineno)]) from None
    except (ValueError, RecursionError) as error:
        raise InputError(source, [Problem("", f"no JSON: {error}")]) from None
    if not isinstance(found, dict):
        raise InputError(source, [Problem("", f"it is a {type(found).__name__}; an object is needed")])
    try:
        return Settings.model_validate({**found, "\0text": text})
    except ValidationError as error:
        raise InputError(source, [_problem(one, found) for one in error.errors()]) from None


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number")


def uncommented(text: str) -> str:
    """Return JSON without // and /* */ comments; lines stay where they are."""

    def bare(found: re.Match[str]) -> str:
        return found[0] if found[0].startswith('"') else re.sub(r"[^\n]+", " ", found[0])

    return re.sub(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*[\s\S]*?\*/', bare, text)


def _problem(error: Any, found: Any) -> Problem:
    """Return what pydantic says as a problem; its place as the keys that lead to it in the file."""
    place = ""
    for key in error["loc"]:
        if isinstance(found, dict) and key in found:
            found, place = found[key], f"{place}.{key}" if place else str(key)
        elif isinstance(found, list) and isinstance(key, int):
            at = next(
                (i for i, one in enumerate(found) if isinstance(one, dict) and one.get("ImageType", 0) == key), key
            )
            at = key if place.endswith("Cameras") else at
            found = found[at] if at < len(found) else None
            place += f"[{at}]"
        elif isinstance(found, dict) and error["type"] == "missing":
            found, place = None, f"{place}.{key}" if place else str(key)
    shown = "" if isinstance(found, dict | list) or found is None else f"{json.dumps(found)}: "
    words = {"union_tag_invalid": "its SensorType must be 1 to 6", "union_tag_not_found": "it needs a SensorType"}
    message = words.get(error["type"], error["msg"].removeprefix("Value error, "))
    return Problem(place, f"{shown}{message[0].lower()}{message[1:]}")
