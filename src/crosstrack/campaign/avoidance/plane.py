"""Worlds of upright obstacles that are as high as the space: all that matters of them lies in the plane."""

from dataclasses import dataclass

import numpy as np

from crosstrack.types import Array
from crosstrack.world.shapes import Box, Cylinder, Shape
from crosstrack.world.world import World


@dataclass(frozen=True)
class Plane:
    """Where the centre of a vehicle must not be, in the plane: the inside of circles and rectangles.

    What lies within a distance c of a box is the union of four circles of radius c around its corners and of the
    box made longer by c along either axis.
    """

    circles: Array
    """(n, 3) m: x, y, radius"""
    rectangles: Array
    """(m, 4) m: lowest x and y, highest x and y"""
    region: Array
    """(4,) m, likewise: what may be flown; infinite without bounds"""


def plane(world: World, clearance: float) -> Plane:
    """Return the plane of a world in which a clearance (m) is kept, from its bounds too.

    Raises:
        ValueError: the world is more than upright cylinders and boxes from the ground to the top of its bounds.
    """
    top = np.inf if world.bounds is None else float(world.bounds[1, 2])
    if world.grids or not all(upright(shape, world.ground, top) for shape in world.shapes):
        raise ValueError("a shortest way is known among cylinders and boxes from the ground to the top of the bounds")
    discs = [shape for shape in world.shapes if isinstance(shape, Cylinder)]
    boxes = [shape for shape in world.shapes if isinstance(shape, Box)]
    around = [(*disc.center, disc.radius + clearance) for disc in discs]
    rectangles = []
    for box in boxes:
        (x0, y0, _), (x1, y1, _) = box.min, box.max
        around += [(x, y, clearance) for x in (x0, x1) for y in (y0, y1)]
        rectangles += [(x0 - clearance, y0, x1 + clearance, y1), (x0, y0 - clearance, x1, y1 + clearance)]
    region = np.array([-np.inf, -np.inf, np.inf, np.inf])
    if world.bounds is not None:
        region = np.concatenate([world.bounds[0, :2] + clearance, world.bounds[1, :2] - clearance])
    return Plane(np.array(around, dtype=float).reshape(-1, 3), np.array(rectangles, dtype=float).reshape(-1, 4), region)


def upright(shape: Shape, ground: float, top: float) -> bool:
    """Return whether a shape is a cylinder or a box from the ground to a height (m)."""
    if isinstance(shape, Cylinder):
        low, high = shape.z
    elif isinstance(shape, Box):
        low, high = shape.min[2], shape.max[2]
    else:
        return False
    return low <= ground and high >= top
