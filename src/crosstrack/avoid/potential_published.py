"""The potential field as the article's program has it, with its limits: the baseline that walks through walls."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.avoid.potential_field import slowness
from crosstrack.types import Array

ATTRACTION, REPULSION, BOOST = 0.5, 20.0, 3.0
SEARCH = 20
"""cells, that are looked through along each of five directions"""
SPEED, PUSH, STEP = 2.0, 2.0, 0.2
TURN = math.radians(15)
SLOW = 0.6
"""of the speed: a slower approach, or a slower retreat, counts as a local minimum"""


def published_path(free: NDArray[np.bool_], start: Array, goal: Array, most: int = 2000) -> Array:
    """Return the path (n, 2) of the published program on a map of cells, until it arrives or has made `most` steps.

    Obstacles are seen in five directions only, 45° apart about the heading, which the program takes mirrored at the
    diagonal; nothing stops a step that leads into an obstacle or across it; V_ra counts by its size, whether the goal
    comes nearer or not; and there is no end where the goal cannot be reached.

    Args:
        free: (x, y) which cells are free; beyond the edge none is
        start: (2,) cells
        goal: (2,) cells
        most: steps; the program itself would go on for ever
    """
    position, velocity = np.array(start, dtype=float), np.array([1.0, 1.0])
    path, turn = [position], 0.0
    while float(np.linalg.norm(position - goal)) > 2.0 and len(path) <= most:
        push = seen(free, position, velocity, goal)
        pull = -ATTRACTION * (position - goal)
        if len(path) > 1:
            remaining = [float(np.linalg.norm(point - goal)) for point in path[-2:]]
            closing = abs(remaining[1] - remaining[0]) / STEP
            turn = turned(turn, pull, push) if closing < SLOW * SPEED else 0.0
            cosine, sine = math.cos(turn), math.sin(turn)
            push = np.array([cosine * push[0] - sine * push[1], sine * push[0] + cosine * push[1]])
            near = 1 + 15 * math.exp(-0.5 * (float(np.linalg.norm(position - goal)) - 3) ** 2)
            pull = slowness(SPEED, closing) * near * BOOST * pull
        force = pull + push
        force = force * min(1.0, PUSH / max(float(np.abs(force).max()), 1e-12))
        velocity = velocity + STEP * force
        velocity = velocity * min(1.0, SPEED / max(float(np.linalg.norm(velocity)), 1e-12))
        position = position + STEP * velocity
        path.append(position)
    return np.array(path)


def turned(turn: float, pull: Array, push: Array) -> float:
    """Return the angle (rad) to turn the repulsion by: that chosen before, or to the side where it points already."""
    if turn != 0.0:
        return turn
    angle = math.remainder(math.atan2(push[1], push[0]) - math.atan2(pull[1], pull[0]), 2 * math.pi)
    return -TURN if angle > 0 else TURN


def seen(free: NDArray[np.bool_], position: Array, velocity: Array, goal: Array) -> Array:
    """Return the repulsion (2,) of the first obstacle cell along each direction."""
    heading, total = math.atan2(velocity[1], velocity[0]), np.zeros(2)
    for k in range(-2, 3):
        angle = heading + k * math.pi / 4
        for distance in range(SEARCH):
            cell = [int(position[0] + distance * math.sin(angle)), int(position[1] + distance * math.cos(angle))]
            inside = 0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1]
            if inside and free[cell[0], cell[1]]:
                continue
            way = position - cell
            gap = max(float(np.linalg.norm(way)), 1e-3)
            weight = float(np.linalg.norm(goal - cell)) ** 2
            total = total + REPULSION * (1 / gap - 1 / SEARCH) / gap**3 * weight * way
            break
    return total
