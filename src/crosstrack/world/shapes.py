"""Solid obstacles as a mission writes them: their fields are the mission schema."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Len

from crosstrack.types import Finite, Positive, Vector
from crosstrack.world.mesh import Mesh, ball, circle, extrude
from crosstrack.world.polygon import fault

Point = tuple[Finite, Finite]
Interval = tuple[Finite, Finite]
Polygon = Annotated[tuple[Point, ...], Len(3, 1000)]


def check_interval(z: Interval) -> None:
    """Raise ValueError unless an interval of heights is one."""
    if not z[0] < z[1]:
        raise ValueError(f"z is {list(z)}: its first value must be below its second")


@dataclass(frozen=True)
class Box:
    """A box along the axes."""

    min: Vector
    """m, lowest corner"""
    max: Vector
    """m, highest corner"""

    def __post_init__(self) -> None:
        wrong = [
            f"{axis} from {low} to {high}"
            for axis, low, high in zip("xyz", self.min, self.max, strict=True)
            if not low < high
        ]
        if wrong:
            raise ValueError(f"min must be below max on every axis; found {', '.join(wrong)}")

    def mesh(self) -> Mesh:
        """Return the surface, normals outward."""
        (x0, y0, lo), (x1, y1, hi) = self.min, self.max
        return extrude(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), lo, hi)


@dataclass(frozen=True)
class Cylinder:
    """An upright cylinder with flat ends."""

    center: Point
    """m, of its axis"""
    radius: Positive
    """m"""
    z: Interval
    """m, heights of its lower and upper end"""

    def __post_init__(self) -> None:
        check_interval(self.z)

    def mesh(self) -> Mesh:
        """Return a surface with its corners on the cylinder, normals outward."""
        return extrude(np.array(self.center) + self.radius * circle(32), *self.z)


@dataclass(frozen=True)
class Sphere:
    """A ball."""

    center: Vector
    """m"""
    radius: Positive
    """m"""

    def mesh(self) -> Mesh:
        """Return a surface with its corners on the sphere, normals outward."""
        return ball(np.array(self.center), self.radius)


@dataclass(frozen=True)
class Prism:
    """An upright prism over a simple polygon, convex or not."""

    polygon: Polygon
    """m, corners in order, either way round; the last joins the first"""
    z: Interval
    """m, heights of its lower and upper end"""

    def __post_init__(self) -> None:
        check_interval(self.z)
        found = fault(np.array(self.polygon, dtype=float).reshape(-1, 2))
        if found:
            raise ValueError(found)

    def mesh(self) -> Mesh:
        """Return the surface, normals outward."""
        return extrude(np.array(self.polygon), *self.z)


Shape = Box | Cylinder | Sphere | Prism
