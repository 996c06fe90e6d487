"""What stands still in a flight: the route, the course and the world, as points and triangles."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.plan import Plan
from crosstrack.protocols import Path
from crosstrack.types import Array

Mesh = tuple[str, Array, NDArray[np.integer]]
"""name, vertices (n, 3) m, triangles (m, 3) as rows of vertices"""


@runtime_checkable
class Drawable(Protocol):
    """A map that can be drawn."""

    def meshes(self) -> list[Mesh]:
        """Return the obstacles as closed meshes."""


@dataclass(frozen=True)
class Scene:
    """The still part of a flight."""

    route: Array
    """(n, 3) m, the path as asked for"""
    course: Array
    """(n, 3) m, the path as planned"""
    meshes: tuple[Mesh, ...]
    """the obstacles"""

    def solid(self) -> tuple[Array, NDArray[np.integer]] | None:
        """Return all obstacles as one mesh: vertices (n, 3) m and triangles (m, 3); None without any."""
        if not self.meshes:
            return None
        starts = np.cumsum([0, *(len(vertices) for _, vertices, _ in self.meshes[:-1])])
        triangles = [mesh[2] + start for mesh, start in zip(self.meshes, starts, strict=True)]
        return np.concatenate([vertices for _, vertices, _ in self.meshes]), np.concatenate(triangles)


def scene(plan: Plan, points: int = 2000) -> Scene:
    """Return what to draw of a plan; paths as at most `points` points evenly spaced by arc length."""
    world = plan.scenario.world
    return Scene(
        route=along(plan.route, points),
        course=along(plan.course.path, points),
        meshes=tuple(world.meshes()) if isinstance(world, Drawable) else (),
    )


def along(path: Path, points: int, spacing: float = 0.1) -> Array:
    """Return points (n, 3) of a path from end to end, `spacing` m apart, at most `points` of them."""
    count = int(min(points, max(2, np.ceil(path.length / spacing) + 1)))
    return path(np.linspace(0.0, path.length, count))
