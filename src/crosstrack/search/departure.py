"""From where a vehicle is to where it has the clearance: it may be nearer to an obstacle than a plan would go."""

import numpy as np

from crosstrack.errors import Problem, Unreachable
from crosstrack.protocols import Map
from crosstrack.search.repair import ROUNDING
from crosstrack.types import Array

FARTHEST = 2.0
"""clearances, that the place to start from is looked for within"""
FINE = 8
"""points of a lattice for that, on each side of the vehicle along each axis"""
TRIES = 300


def departure(world: Map, point: Array, clearance: float, box: Array, name: str) -> Array:
    """Return the points (n, 3) from a point on to where a way with the clearance may begin, in the box.

    The line there comes no nearer to obstacles than the point is.

    Raises:
        Unreachable: there is no such place near.
    """
    inside = np.clip(point, *box)
    legs = point[None] if np.array_equal(inside, point) else np.array([point, inside])
    distance = float(world.distance(inside))
    if distance >= clearance - ROUNDING:
        return legs
    axis = np.linspace(-FARTHEST, FARTHEST, 2 * FINE + 1) * clearance
    around = inside + np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    around = around[((around >= box[0]) & (around <= box[1])).all(axis=1)]
    around = around[world.distance(around) >= clearance]
    nearest = np.argsort(np.linalg.norm(around - inside, axis=1), kind="stable")[:TRIES]
    for place in around[nearest]:
        if world.swept(inside, place) >= distance - ROUNDING:
            return np.concatenate([legs, place[None]])
    message = f"is {distance:.3g} m from an obstacle, and no place near it has {clearance:.3g} m"
    raise Unreachable("search", [Problem(name, message)])
