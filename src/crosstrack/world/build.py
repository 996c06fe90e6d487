"""The world as a mission writes it."""

import math
from dataclasses import dataclass, fields, replace
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Lt

from crosstrack.types import Finite, Vector
from crosstrack.world.cloud import Cloud
from crosstrack.world.files import Files
from crosstrack.world.image import ImageMap
from crosstrack.world.moving import Moving, MovingObstacles
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World


@dataclass(frozen=True)
class ShapeSpec:
    """One shape under its name: exactly one of these is given."""

    box: Box | None = None
    cylinder: Cylinder | None = None
    sphere: Sphere | None = None
    prism: Prism | None = None

    def __post_init__(self) -> None:
        given = [field.name for field in fields(self) if getattr(self, field.name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            raise ValueError(f"exactly one of box, cylinder, sphere or prism is needed; found {found}")

    @property
    def shape(self) -> Shape:
        """The shape given."""
        shape = self.box or self.cylinder or self.sphere or self.prism
        assert shape is not None
        return shape


@dataclass(frozen=True)
class MovingSpec:
    """A shape that moves at a steady velocity."""

    shape: ShapeSpec
    """where it is when the flight begins"""
    velocity: Vector
    """m/s, world"""
    turns: Annotated[float, Ge(0.1), Lt(math.inf)] | None = None
    """s, after which it turns back, again and again; left out, it never does"""


@dataclass(frozen=True)
class WorldSpec:
    """What is in the way, from any of these sources together, and the space that may be flown."""

    bounds: tuple[Vector, Vector] | None = None
    """m, lowest and highest corner of the space that may be flown"""
    ground: Finite = 0.0
    """m, height of the ground"""
    shapes: tuple[ShapeSpec, ...] = ()
    """obstacles with exact distances"""
    unmapped: tuple[ShapeSpec, ...] = ()
    """more of them that no map shows: the vehicle is not told of them"""
    moving: tuple[MovingSpec, ...] = ()
    """obstacles that move"""
    image: ImageMap | None = None
    """a picture as a map of walls"""
    cloud: Cloud | None = None
    """a point cloud"""
    generate: Any = None
    """a registered generator"""

    def __post_init__(self) -> None:
        if self.bounds is None:
            return
        wrong = [
            f"{axis} from {low} to {high}"
            for axis, low, high in zip("xyz", *self.bounds, strict=True)
            if not low < high
        ]
        if wrong:
            raise ValueError(f"bounds: the first corner must be below the second; found {', '.join(wrong)}")

    def files(self) -> list[str]:
        """Return the names of the files that it reads."""
        return [part.file for part in (self.image, self.cloud) if part is not None]

    def build(self, files: Files) -> World:
        """Read the files and return the world as it is, less what moves.

        Args:
            files: the folder that names are relative to, or the contents of the files by name

        Raises:
            InputError: a file is missing or cannot be used.
        """
        made = self.generate.shapes(self.ground) if self.generate is not None else ()
        grids = [self.image.build(files, self.ground)] if self.image else []
        clouds = [self.cloud.build(files)] if self.cloud else []
        return World(
            shapes=(*(spec.shape for spec in self.shapes), *made, *(spec.shape for spec in self.unmapped)),
            grids=(*grids, *clouds),
            bounds=None if self.bounds is None else np.array(self.bounds, dtype=float),
            ground=self.ground,
        )

    def told(self, world: World) -> World:
        """Return what a map shows of the world that `build` returned: all but `unmapped`."""
        if not self.unmapped:
            return world
        return replace(world, shapes=world.shapes[: -len(self.unmapped)])

    def traffic(self) -> MovingObstacles | None:
        """Return what moves; None where nothing does."""
        if not self.moving:
            return None
        movers = tuple(Moving(spec.shape.shape, spec.velocity, spec.turns) for spec in self.moving)
        return MovingObstacles(movers, self.ground)
