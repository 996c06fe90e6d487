"""Things of a scene."""

from dataclasses import dataclass, replace

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene.assets import place
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array
from crosstrack.world.grids import Grid, Relief, Voxels
from crosstrack.world.mesh import Mesh
from crosstrack.world.shapes import Box, Cylinder, Shape, Sphere


@dataclass(frozen=True, eq=False)
class Thing:
    """Something with a name that cameras see."""

    name: str
    asset: str
    """what it is made from; empty for what cannot be moved or scaled"""
    pose: Pose
    """world NED"""
    scale: Array
    """(3,) of the asset's size of 1 m, along its own axes"""
    number: int
    """in segmentation pictures, -1 for none"""
    solid: Shape | Grid | None
    """what is in the way, ENU; None for the sky and the ground"""

    @property
    def box(self) -> Array:
        """(2, 3) m, lowest and highest corner of the box around it, ENU"""
        assert self.solid is not None
        return around(self.solid)

    @property
    def cells(self) -> int:
        """Cubes that it was cut into, 0 where it is whole."""
        return self.solid.occupied.size if self.asset and isinstance(self.solid, Voxels) else 0

    def mesh(self) -> Mesh:
        """Return its surface, ENU."""
        assert self.solid is not None
        return self.solid.mesh()

    def moved(self, pose: Pose) -> "Thing":
        """Return it with another pose."""
        return replace(self, pose=pose, solid=place(self.asset, pose, self.scale))

    def scaled(self, scale: Array) -> "Thing":
        """Return it with another scale."""
        return replace(self, scale=scale, solid=place(self.asset, self.pose, scale))


def around(solid: Shape | Grid) -> Array:
    """Return the lowest and the highest corner (2, 3) m of the box around a solid, ENU."""
    if isinstance(solid, Relief | Voxels):
        return np.array(solid.box).reshape(2, 3)
    vertices = solid.mesh().vertices
    return np.array([vertices.min(axis=0), vertices.max(axis=0)])


def named(name: str, number: int, asset: str, pose: Pose, scale: Array) -> Thing:
    """Return a thing made from an asset."""
    return Thing(name, asset, pose, scale, number, place(asset, pose, scale))


def standing(name: str, number: int, solid: Shape | Grid) -> Thing:
    """Return a thing of the world (ENU): boxes, cylinders and spheres can be moved, other solids cannot."""
    low, high = around(solid)
    sides = frames.ned_from_enu(high - low) * (1, 1, -1)
    asset = {Box: "Cube", Cylinder: "Cylinder", Sphere: "Sphere"}.get(type(solid), "")
    if isinstance(solid, Cylinder | Sphere):
        sides = np.where(np.arange(3) < (3 if isinstance(solid, Sphere) else 2), 2 * solid.radius, sides)
    pose = Pose(frames.ned_from_enu((low + high) / 2))
    return Thing(name, asset, pose, sides if asset else np.ones(3), number, solid)


def flat(name: str, number: int) -> Thing:
    """Return a thing that is nowhere in particular: the sky, or the ground."""
    return Thing(name, "", Pose(), np.ones(3), number, None)
