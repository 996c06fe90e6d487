"""The still part of a drawing: what the vehicle was told of the world, and what it was not told of, apart."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.plan import Plan
from crosstrack.flight.scene import Scene, scene
from crosstrack.show.style import FOOTPRINT, OBSTACLE, UNMAPPED, UNMAPPED_FOOTPRINT
from crosstrack.types import Array
from crosstrack.world.world import World

ABSENT = "not on the map"
"""name of the meshes of obstacles that the vehicle was not told of"""


@dataclass(frozen=True)
class Group:
    """Obstacles that are drawn alike."""

    name: str
    color: str
    """in space"""
    footprint: str
    """their colour from above"""
    scene: Scene
    """with no other obstacles"""

    @property
    def mesh(self) -> tuple[Array, NDArray[np.integer]]:
        """All of them as one mesh: vertices (n, 3) m and triangles (m, 3)"""
        mesh = self.scene.solid()
        assert mesh is not None
        return mesh


def stage(plan: Plan) -> Scene:
    """Return the scene of a plan, in which obstacles that a map does not show have a name of their own.

    A vehicle that was given no map at all has nothing that they could be told apart from.
    """
    drawn, world, told = scene(plan), plan.scenario.world, plan.told
    if not (isinstance(world, World) and isinstance(told, World)) or not (told.shapes or told.grids):
        return drawn
    shown = set(told.shapes)
    absent = World(tuple(shape for shape in world.shapes if shape not in shown))
    if not absent.shapes:
        return drawn
    meshes = [(ABSENT, vertices, triangles) for _, vertices, triangles in absent.meshes()]
    return replace(drawn, meshes=(*replace(world, shapes=told.shapes).meshes(), *meshes))


def groups(drawn: Scene) -> Iterator[Group]:
    """Yield the obstacles of a scene in groups that are drawn alike; none without any."""
    looks = (("obstacles", OBSTACLE, FOOTPRINT, False), (ABSENT, UNMAPPED, UNMAPPED_FOOTPRINT, True))
    for name, color, footprint, absent in looks:
        meshes = tuple(mesh for mesh in drawn.meshes if (mesh[0] == ABSENT) is absent)
        if meshes:
            yield Group(name, color, footprint, replace(drawn, meshes=meshes))


NOWHERE = np.full((1, 3), np.nan)
"""m, a point that is not drawn, for an entry of a legend"""
