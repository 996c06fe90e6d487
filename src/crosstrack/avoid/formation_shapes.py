"""Shapes of formations: where the slots of some vehicles lie around their middle."""

import math
from typing import Literal

import numpy as np

from crosstrack.types import Array

Shape = Literal["line", "v", "circle"]

ARM = math.pi / 4
"""rad, between the heading and each arm of a V"""


def slots(shape: Shape, count: int, spacing: float, heading: float = 0.0) -> Array:
    """Return the slots of a formation, (count, 3) m from their middle.

    A line flies abreast, from right to left; a V has its tip ahead, then right and left in turn; a circle begins ahead
    and goes round by the left. Neighbours along the shape are `spacing` apart.

    Args:
        shape: line, v or circle
        count: of vehicles
        spacing: m
        heading: rad, of the flight, counter-clockwise from east
    """
    k = np.arange(float(count))
    x: Array
    y: Array
    if shape == "line":
        x, y = np.zeros(count), (k - (count - 1) / 2) * spacing
    elif shape == "v":
        rank, side = (k + 1.0) // 2.0, np.where(k % 2 == 1, -1.0, 1.0)
        x, y = -rank * spacing * math.cos(ARM), side * rank * spacing * math.sin(ARM)
    else:
        radius = spacing / (2 * math.sin(math.pi / count)) if count > 1 else 0.0
        x, y = radius * np.cos(2 * math.pi * k / count), radius * np.sin(2 * math.pi * k / count)
    x -= x.mean()
    y -= y.mean()
    c, s = math.cos(heading), math.sin(heading)
    return np.column_stack([c * x - s * y, s * x + c * y, np.zeros(count)])


def shape_error(positions: Array, places: Array) -> Array:
    """Return how far vehicles are from their shape, wherever it is: RMS over them, (...) m.

    Args:
        positions: (..., count, 3) m
        places: (count, 3) m, the slots from their middle
    """
    off = positions - places
    off = off - off.mean(axis=-2, keepdims=True)
    return np.asarray(np.sqrt((off**2).sum(axis=-1).mean(axis=-1)))
