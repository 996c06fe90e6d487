"""Pictures of all of AirSim's types."""

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crosstrack import frames
from crosstrack.airsim.scene.palette import PALETTE
from crosstrack.airsim.scene.png import encoded
from crosstrack.airsim.scene.poses import turned_to_enu
from crosstrack.airsim.scene.scene import Eye, Sighting
from crosstrack.airsim.scene.shading import GRASS, Bytes, colours, shade
from crosstrack.airsim.scene.trace import GROUND
from crosstrack.airsim.structs import Pose
from crosstrack.compiled import compiled
from crosstrack.types import Array

Singles = NDArray[np.float32]
REACH = 10_000.0
"""m, beyond which there is only sky"""
NOTHING = 65504.0
"""m, the depth of the sky: the largest number of half precision"""
DEEPEST = 100.0
"""m, that is white in DepthVis"""
BASELINE = 0.25
"""m, between the front left and the front right camera"""


class Kind(IntEnum):
    """Kinds of images that are made here, by AirSim's numbers."""

    SCENE = 0
    DEPTH_PLANAR = 1
    DEPTH_PERSPECTIVE = 2
    DEPTH_VIS = 3
    DISPARITY = 4
    SEGMENTATION = 5
    NORMALS = 6
    INFRARED = 7


@compiled
def pinhole(turn: Array, width: int, height: int, half: float) -> tuple[Array, Array]:
    """Return unit vectors (n, 3) through the middles of pixels, row by row, and their parts (n,) along the axis.

    Args:
        turn: (3, 3) from the camera (forward, right, down) to the world
        width: pixels
        height: pixels
        half: tangent of half the angle from the left to the right edge
    """
    out, along = np.empty((width * height, 3)), np.empty(width * height)
    step = 2.0 * half / width
    for v in range(height):
        down = (v + 0.5 - 0.5 * height) * step
        for u in range(width):
            right = (u + 0.5 - 0.5 * width) * step
            k, part = v * width + u, 1.0 / math.sqrt(1.0 + right * right + down * down)
            for axis in range(3):
                out[k, axis] = (turn[axis, 0] + right * turn[axis, 1] + down * turn[axis, 2]) * part
            along[k] = part
    return out, along


@dataclass(frozen=True, eq=False)
class Shot:
    """What a camera sees at one instant; pictures of several types are made from the same rays."""

    eye: Eye
    pose: Pose
    """world NED"""
    width: int
    """pixels"""
    height: int
    """pixels"""
    fov: float
    """degrees, across the longer side"""

    @cached_property
    def origin(self) -> Array:
        """(3,) m, ENU"""
        return np.ascontiguousarray(frames.enu_from_ned(self.pose.position))

    @cached_property
    def half(self) -> float:
        """Tangent of half the angle from the left to the right edge; the field of view is across the longer side."""
        return math.tan(math.radians(self.fov) / 2) * min(1.0, self.width / self.height)

    @cached_property
    def rays(self) -> tuple[Array, Array]:
        """Unit vectors (n, 3), ENU, and their parts (n,) along the optical axis."""
        return pinhole(turned_to_enu(self.pose.orientation), self.width, self.height, self.half)

    @cached_property
    def sighting(self) -> Sighting:
        """What the rays hit."""
        return self.eye.look(self.origin, self.rays[0], REACH)

    @cached_property
    def planar(self) -> Singles:
        """(n,) m, depth along the optical axis"""
        return np.minimum(self.sighting.ranges * self.rays[1], NOTHING).astype(np.float32)

    def scene(self) -> Bytes:
        """Return the shaded picture (n, 3) blue, green, red."""
        paint = colours(self.eye.numbers)
        paint[GROUND] = GRASS
        eye, found = self.eye, self.sighting
        args = self.origin, self.rays[0], found.ranges, found.seen, found.rows
        return shade(eye.table, eye.balls, *args, paint)

    def segmentation(self) -> Bytes:
        """Return the picture (n, 3) blue, green, red of the numbers of things, black where they have none."""
        numbers = self.eye.numbers
        paint = np.where((numbers >= 0)[:, None], PALETTE[numbers % 256], 0).astype(np.uint8)
        return np.ascontiguousarray(paint[:, ::-1])[self.sighting.seen]

    def infrared(self) -> Bytes:
        """Return the picture (n, 3) of the numbers of things as grey, black where they have none."""
        numbers = self.eye.numbers
        grey = np.where(numbers >= 0, numbers % 256, 0).astype(np.uint8)
        return np.repeat(grey[self.sighting.seen][:, None], 3, axis=1)

    def normals(self) -> Bytes:
        """Return the picture (n, 3) of where surfaces face: red north, green east, blue up, grey for none."""
        out = self.eye.normals(self.origin, self.rays[0], self.sighting)
        return (127.5 * (1.0 + out[:, [2, 0, 1]])).astype(np.uint8)

    def numbers(self, image_type: int) -> Singles:
        """Return a picture (n,) as numbers: m, shares of 1, or what is red of a coloured one."""
        match image_type:
            case Kind.DEPTH_PLANAR:
                return self.planar
            case Kind.DEPTH_PERSPECTIVE:
                return np.minimum(self.sighting.ranges, NOTHING).astype(np.float32)
            case Kind.DEPTH_VIS:
                depth: Singles = np.minimum(self.planar / np.float32(DEEPEST), np.float32(1))
                return depth
            case Kind.DISPARITY:
                with np.errstate(divide="ignore"):
                    shift: Singles = np.minimum(np.float32(BASELINE / (2 * self.half)) / self.planar, np.float32(1))
                return shift
        return self.coloured(image_type)[:, 2].astype(np.float32) / np.float32(255)

    def coloured(self, image_type: int) -> Bytes:
        """Return a picture (n, 3) blue, green, red; numbers as grey from 0 to 1, white beyond."""
        match image_type:
            case Kind.SCENE:
                return self.scene()
            case Kind.SEGMENTATION:
                return self.segmentation()
            case Kind.NORMALS:
                return self.normals()
            case Kind.INFRARED:
                return self.infrared()
        grey = (np.minimum(self.numbers(image_type), np.float32(1)) * np.float32(255)).astype(np.uint8)
        return np.repeat(grey[:, None], 3, axis=1)

    def png(self, image_type: int) -> bytes:
        """Return a picture as PNG, with an opacity as AirSim's have."""
        full = np.full((self.height, self.width, 4), 255, dtype=np.uint8)
        full[..., :3] = self.coloured(image_type).reshape(self.height, self.width, 3)[..., ::-1]
        return encoded(full)
