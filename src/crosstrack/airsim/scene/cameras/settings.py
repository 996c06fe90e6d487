"""Cameras as settings.json has them."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from crosstrack.airsim.scene.section import UNSET, AtLeast, Mounted, Number, Section

Pixels = Annotated[int, Field(ge=1, le=8192)]
IMAGE_TYPES = 10
DEFAULT_FOV = 90.0
"""degrees"""


class Capture(Section):
    """How pictures of one type are taken."""

    image_type: int = Field(default=0, ge=-1, lt=IMAGE_TYPES)
    """-1 for the camera itself, which takes no pictures"""
    width: Pixels = 256
    """pixels"""
    height: Pixels = 144
    """pixels"""
    fov_degrees: float = Field(default=DEFAULT_FOV, gt=0, lt=180, validation_alias="FOV_Degrees")
    """degrees, across the longer side"""
    projection_mode: Literal["", "Perspective", "perspective"] = ""
    """orthographic pictures are not offered"""


class Gimbal(Section):
    """What keeps a camera from turning with its vehicle."""

    stabilization: AtLeast = 0.0
    """1 keeps the angles given, 0 none of them"""
    yaw: Number = UNSET
    """degrees, kept in the world; left out, it turns with the vehicle"""
    pitch: Number = UNSET
    """degrees, kept in the world; left out, it turns with the vehicle"""
    roll: Number = UNSET
    """degrees, kept in the world; left out, it turns with the vehicle"""


class CameraSettings(Mounted):
    """A camera."""

    captures: Annotated[Mapping[int, Capture], Field(validation_alias="CaptureSettings")] = {}
    """by type of picture, in settings.json a list"""
    gimbal: Gimbal = Gimbal()

    @field_validator("captures", mode="before")
    @classmethod
    def by_type(cls, found: Any) -> Any:
        """Return the list by the type of picture; of several for one type the last."""
        if not isinstance(found, list):
            return found
        return {one.get("ImageType", 0) if isinstance(one, dict) else 0: one for one in found}
