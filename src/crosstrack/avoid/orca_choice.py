"""One decision of optimal reciprocal collision avoidance: which velocity to fly among what is around."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.avoid.orca_planes import excess, sideways
from crosstrack.avoid.orca_velocity import Triple, nearest, safest
from crosstrack.compiled import compiled
from crosstrack.types import Array

SIDES = 12
"""of the polygon that stands for the greatest speed"""
SLOW = 1e-3
"""m/s, a velocity that is none"""

PATIENCE = 1.0
"""s, time constant of how much a vehicle has been held up"""
UNHELD = 0.05
"""of being held up: little enough to be none"""
STALLED = 0.2
"""of the speed wanted: one that is held up and slower has stalled"""
STUBBORN = 2.0
"""s, stalled, after which a vehicle tries the other side"""

Hold = tuple[float, float, float]
"""how much a vehicle has been held up, from 0 to 1; to which side it turns, 1 for its right; s, since it stalled"""
Rule = tuple[float, float, float, float, float]
"""own radius (m), margin (m), horizon (s), greatest level speed (m/s), how fast it may leave its height (m/s)"""


@compiled
def put(planes: Array, k: int, nx: float, ny: float, nz: float, bound: float) -> None:
    """Write the half-space n·v >= bound."""
    planes[k, 0], planes[k, 1], planes[k, 2], planes[k, 3] = nx, ny, nz, bound


@compiled
def put_limits(planes: Array, k: int, wanted: Array, rule: Rule) -> int:
    """Write the half-spaces of what may be flown: a polygon of speeds, and a band of climbs.

    The polygon has a corner at the heading wanted. A climb asked for may always be stopped, and
    is left by no more than the rule says.
    """
    _, _, _, speed, climb = rule
    heading, bound = math.atan2(wanted[1], wanted[0]), -speed * math.cos(math.pi / SIDES)
    for i in range(SIDES):
        angle = heading + (2 * i + 1) * math.pi / SIDES
        put(planes, k + i, math.cos(angle), math.sin(angle), 0.0, bound)
    put(planes, k + SIDES, 0.0, 0.0, 1.0, min(0.0, wanted[2]) - climb)
    put(planes, k + SIDES + 1, 0.0, 0.0, -1.0, -max(0.0, wanted[2]) - climb)
    return k + SIDES + 2


@compiled
def put_walls(planes: Array, k: int, walls: Array, horizon: float) -> int:
    """Write the half-spaces of what stands still: towards it no faster than the gap over the horizon."""
    for i in range(walls.shape[0]):
        put(planes, k + i, walls[i, 0], walls[i, 1], walls[i, 2], -max(0.0, walls[i, 3]) / horizon)
    return k + len(walls)


@compiled
def put_others(
    planes: Array,
    k: int,
    position: Array,
    velocity: Array,
    others: Array,
    motion: Array,
    radius: Array,
    avoids: NDArray[np.bool_],
    rule: Rule,
) -> int:
    """Write the half-spaces of what moves, the nearest first; of one that avoids too, half of the change is taken."""
    own, margin, horizon, _, _ = rule
    away = np.empty(others.shape[0])
    for j in range(others.shape[0]):
        x, y, z = others[j, 0] - position[0], others[j, 1] - position[1], others[j, 2] - position[2]
        away[j] = x * x + y * y + z * z
    for next_nearest in np.argsort(away):
        j = int(next_nearest)
        touch = own + radius[j]
        vx, vy, vz = velocity[0] - motion[j, 0], velocity[1] - motion[j, 1], velocity[2] - motion[j, 2]
        px, py, pz = others[j, 0] - position[0], others[j, 1] - position[1], others[j, 2] - position[2]
        nx, ny, nz, outside = excess(px, py, pz, vx, vy, vz, touch, touch + margin, horizon)
        share = 0.5 if avoids[j] else 1.0
        bound = nx * velocity[0] + ny * velocity[1] + nz * velocity[2] - share * outside
        put(planes, k, nx, ny, nz, bound)
        k += 1
    return k


@compiled
def turned(wanted: Array, angle: float) -> Triple:
    """Return a velocity turned by an angle (rad), clockwise seen from above; its climb stays."""
    size = math.sqrt(wanted[0] ** 2 + wanted[1] ** 2 + wanted[2] ** 2)
    if size < SLOW:
        return wanted[0], wanted[1], wanted[2]
    x, y, _ = sideways(wanted[0] / size, wanted[1] / size, wanted[2] / size)
    along, aside = math.cos(angle), size * math.sin(angle)
    return along * wanted[0] + aside * x, along * wanted[1] + aside * y, wanted[2]


@compiled
def barred_by(planes: Array, wanted: Array) -> float:
    """Return how much of a velocity half-spaces forbid, from 0 to 1, all where they leave none."""
    square = wanted[0] ** 2 + wanted[1] ** 2 + wanted[2] ** 2
    if square < SLOW * SLOW:
        return 0.0
    found, x, y, z = nearest(planes, (wanted[0], wanted[1], wanted[2]))
    if not found:
        return 1.0
    kept = (x * wanted[0] + y * wanted[1] + z * wanted[2]) / square
    return 1.0 - min(1.0, max(0.0, float(kept)))


@compiled
def held_up(hold: Hold, barred: float, share: float, duration: float) -> Hold:
    """Return how a vehicle has been held up, a time (s) later.

    Args:
        hold: until now
        barred: how much of the velocity wanted is forbidden, from 0 to 1
        share: speed flown over speed wanted
        duration: s
    """
    held, side, stalled = hold
    held += min(1.0, duration / PATIENCE) * (barred - held)
    stalled = stalled + duration if barred > 0.5 and share < STALLED else max(0.0, stalled - duration)
    if stalled > STUBBORN:
        return held, -side, 0.0
    return held, side if held > UNHELD else 1.0, stalled


@compiled
def choose(
    position: Array,
    velocity: Array,
    wanted: Array,
    hold: Hold,
    walls: Array,
    others: Array,
    motion: Array,
    radius: Array,
    avoids: NDArray[np.bool_],
    rule: Rule,
    duration: float,
) -> tuple[Triple, Hold]:
    """Return the velocity to fly (m/s), and how the vehicle has been held up.

    Args:
        position: (3,) m
        velocity: (3,) m/s
        wanted: (3,) m/s, the velocity preferred
        hold: how it was held up until now
        walls: (m, 4) unit normals away from what stands still, and gaps (m)
        others: (n, 3) m, where balls are that move
        motion: (n, 3) m/s, their velocities
        radius: (n,) m
        avoids: (n,) whether they give way too
        rule: see `Rule`
        duration: s, until the next decision
    """
    planes = np.empty((walls.shape[0] + SIDES + 2 + others.shape[0], 4))
    fixed = put_limits(planes, put_walls(planes, 0, walls, rule[2]), wanted, rule)
    put_others(planes, fixed, position, velocity, others, motion, radius, avoids, rule)
    x, y, z = safest(planes, turned(wanted, hold[1] * 0.5 * math.pi * hold[0]), fixed)
    square = wanted[0] ** 2 + wanted[1] ** 2 + wanted[2] ** 2
    flown = velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2
    share = math.sqrt(flown / square) if square > SLOW * SLOW else 1.0
    return (x, y, z), held_up(hold, barred_by(planes, wanted), share, duration)
