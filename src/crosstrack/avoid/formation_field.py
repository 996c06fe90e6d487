"""The potential between vehicles in formation, and that of obstacles, as velocities."""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.vectors import direction, dot, limited, norm

TINY = 1e-6


@compiled
def strength(distance: float, nearest: float, reach: float) -> float:
    """Return the repulsion at a distance (m): 1 at the nearest allowed and nearer, 0 from the reach on.

    That of the potential U = k (d/d0 - 1 - ln(d/d0)), whose slope k (1/d0 - 1/d) grows as Khatib's towards the obstacle
    and ends smoothly at the reach d0.
    """
    if distance >= reach:
        return 0.0
    return min(1.0, (1.0 / max(distance, TINY) - 1.0 / reach) / (1.0 / nearest - 1.0 / reach))


@compiled
def from_others(position: Array, others: Array, radii: Array, radius: float, reach: float) -> Array:
    """Return the sum of the repulsions (3,) of balls (n, 3) m with radii (n,) m on a ball; 1 where they touch."""
    push = position - position
    for j in range(others.shape[0]):
        away = position - others[j]
        touch = radius + radii[j]
        push += strength(norm(away), touch, max(reach, 1.5 * touch)) * direction(away)
    return push


@compiled
def around_obstacle(wanted: Array, normal: Array, share: float) -> Array:
    """Return a velocity (3,) of which a share is turned to pass an obstacle, level, on the side it leads to already.

    What leads into the obstacle is turned along it; straight at it, to the right.

    Args:
        wanted: (3,) m/s
        normal: (3,) unit vector away from the obstacle
        share: from 0, far, to 1, there
    """
    inwards = -dot(wanted, normal)
    if inwards <= 0.0 or share <= 0.0:
        return wanted
    across = wanted + inwards * normal
    side = normal.copy()
    side[0], side[1], side[2] = -normal[1], normal[0], 0.0
    side = direction(side)
    if dot(across, side) < 0.0:
        side = -side
    return wanted + share * inwards * (normal + side)


@compiled
def formed(
    wanted: Array,
    to_slot: Array,
    push: Array,
    normal: Array,
    distance: float,
    radius: float,
    rule: tuple[float, float, float, float],
) -> Array:
    """Return the velocity (3,) m/s of a vehicle in formation.

    Args:
        wanted: (3,) m/s, of the course
        to_slot: (3,) m, from the vehicle to its slot
        push: (3,) of the other vehicles, see `from_others`
        normal: (3,) unit vector away from the nearest obstacle
        distance: m, to it
        radius: m, of the vehicle
        rule: stiffness (1/s), greatest part of the speed spent on the shape, reach of obstacles (m), speed (m/s)
    """
    stiffness, most, reach, speed = rule
    share = strength(distance, radius, reach) if math.isfinite(distance) else 0.0
    velocity = wanted + (1.0 - share) * limited(stiffness * to_slot, most * speed)
    velocity = around_obstacle(velocity, normal, share)
    return limited(velocity + speed * (push + share * normal), speed)
