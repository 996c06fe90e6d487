"""What sections of settings.json have in common."""

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field
from pydantic.alias_generators import to_pascal

Number = Annotated[float, Field(allow_inf_nan=False)]
Above = Annotated[float, Field(gt=0, allow_inf_nan=False)]
AtLeast = Annotated[float, Field(ge=0, allow_inf_nan=False)]
UNSET = math.nan


class Section(BaseModel):
    """A section of settings.json: keys are the names of the fields in PascalCase; other keys are ignored."""

    model_config = ConfigDict(
        frozen=True,
        strict=True,
        extra="ignore",
        populate_by_name=True,
        alias_generator=to_pascal,
        validate_default=False,
    )


class Mounted(Section):
    """Where something sits on a vehicle; what is left out is NaN."""

    x: Number = UNSET
    """m, forward"""
    y: Number = UNSET
    """m, right"""
    z: Number = UNSET
    """m, down"""
    yaw: Number = UNSET
    """degrees, clockwise from above"""
    pitch: Number = UNSET
    """degrees, nose up"""
    roll: Number = UNSET
    """degrees, right side down"""
