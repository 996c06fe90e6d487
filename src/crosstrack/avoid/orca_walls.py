"""What stands around a vehicle, as half-spaces: the nearest points of obstacles, the ground, the bounds."""

import numpy as np

from crosstrack.protocols import Map
from crosstrack.types import Array

FEELERS = np.array(
    [[0.0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    + [[x, y, 0.0] for x in (-0.7, 0.7) for y in (-0.7, 0.7)]
)
"""(n, 3) places around a vehicle, over its reach, whose nearest obstacles it keeps clear of"""
SPREAD = 0.3
"""of the reach, the distance of the feelers"""
NEARBY = 1.0
"""m, beyond the reach: a vehicle is never larger"""
SMALL = 1e-6
"""m"""


def walls_around(world: Map, position: Array, radius: float, reach: float) -> Array:
    """Return what stands within reach of a vehicle: unit normals away from it, and gaps, (n, 4), 1 and m.

    Args:
        world: the obstacles, the ground, the bounds
        position: (3,) m
        radius: m, of the vehicle
        reach: m, between the surface of the vehicle and what stands
    """
    walls = np.concatenate([obstacles(world, position, reach), limits(world, position)])
    walls[:, 3] -= radius
    near: Array = walls[walls[:, 3] < reach]
    return near


def obstacles(world: Map, position: Array, reach: float) -> Array:
    """Return the nearest points of the obstacles around, (n, 4): direction from there, and distance (m).

    With the distance d and its gradient g at a feeler, the obstacle's nearest point lies at feeler - d g.
    """
    if float(world.distance(position)) > (1.0 + SPREAD) * reach + NEARBY:
        return np.empty((0, 4))
    feelers = position + SPREAD * reach * FEELERS
    distance = world.distance(feelers)
    seen = np.isfinite(distance)
    if not seen.any():
        return np.empty((0, 4))
    feelers, distance = feelers[seen], distance[seen]
    normal = world.gradient(feelers)
    away = position - (feelers - distance[:, None] * normal)
    size = np.linalg.norm(away, axis=1)
    inside = (size < SMALL) | (distance < 0)
    away = np.where(inside[:, None], normal, away / np.maximum(size, SMALL)[:, None])
    gap = np.where(inside, distance, size) - world.optimism
    kept = ~inside
    kept[0] = True
    rows: Array = np.column_stack([away, gap])[kept]
    return rows


def limits(world: Map, position: Array) -> Array:
    """Return the ground and the bounds, (n, 4): their normals inwards, and how far (m) the vehicle is from them."""
    rows = [[0.0, 0.0, 1.0, position[2] - world.ground]]
    if world.bounds is not None:
        for k, normal in enumerate(np.eye(3)):
            rows.append([*normal, position[k] - world.bounds[0][k]])
            rows.append([*-normal, world.bounds[1][k] - position[k]])
    return np.array(rows)
