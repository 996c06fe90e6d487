"""Distances from the straight legs of a polyline, for compiled code."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

SMALLEST = float(np.finfo(float).tiny)


@compiled
def prepared(corners: Array) -> tuple[Array, Array]:
    """Return a polyline relative to its first corner as numbers for the functions below.

    Returns:
        legs (legs, 2 dimensions + 1): start, end less start (m), 1 / length² or 0; and boxes (blocks, 2 dimensions):
        lowest and negative highest corner (m) around every √legs legs in a row.
    """
    count, dimensions = max(corners.shape[0] - 1, 1), corners.shape[1]
    size = math.ceil(math.sqrt(count))
    legs = np.empty((count, 2 * dimensions + 1))
    boxes = np.empty(((count + size - 1) // size, 2 * dimensions))
    for block in range(boxes.shape[0]):
        for d in range(2 * dimensions):
            boxes[block, d] = np.inf
    for i in range(count):
        square, block = 0.0, i // size
        for d in range(dimensions):
            end = corners[min(i + 1, corners.shape[0] - 1), d]
            legs[i, d], legs[i, dimensions + d] = corners[i, d] - corners[0, d], end - corners[i, d]
            square += legs[i, dimensions + d] ** 2
            end -= corners[0, d]
            boxes[block, d] = min(boxes[block, d], legs[i, d], end)
            boxes[block, dimensions + d] = min(boxes[block, dimensions + d], -legs[i, d], -end)
        legs[i, 2 * dimensions] = 1.0 / square if square > SMALLEST else 0.0
    return legs, boxes


@compiled
def along(part: Array, i: int, leg: int, legs: Array) -> float:
    """Return how far along a leg the foot of point i lies: 0 at its start, 1 at its end, beyond them outside."""
    dimensions = part.shape[0]
    foot = 0.0
    for d in range(dimensions):
        foot += (part[d, i] - legs[leg, d]) * legs[leg, dimensions + d]
    return float(foot * legs[leg, 2 * dimensions])


@compiled
def gap(part: Array, i: int, leg: int, legs: Array) -> float:
    """Return the squared distance (m²) of point i of `part` (dimensions, points) from a leg."""
    dimensions = part.shape[0]
    foot = min(max(along(part, i, leg, legs), 0.0), 1.0)
    total = 0.0
    for d in range(dimensions):
        total += (part[d, i] - legs[leg, d] - foot * legs[leg, dimensions + d]) ** 2
    return total


@compiled
def closest(point: Array, own: int, hint: int, legs: Array, boxes: Array) -> tuple[float, int]:
    """Return the distance (m) of a point from the nearest leg, and its index: of leg `own`, or of all for WHOLE."""
    dimensions = point.shape[0]
    best, nearest = np.inf, hint
    size = math.ceil(math.sqrt(legs.shape[0]))
    for block in range(-1, boxes.shape[0] if own < 0 else 0):
        away = 0.0
        for d in range(dimensions if block >= 0 else 0):
            away += max(boxes[block, d] - point[d, 0], point[d, 0] + boxes[block, dimensions + d], 0.0) ** 2
        first, last = block * size, min((block + 1) * size, legs.shape[0])
        if block < 0:
            first, last = hint, hint + 1
        for leg in range(first, last if away < best else first):
            distance = gap(point, 0, leg, legs)
            if distance < best:
                best, nearest = distance, leg
    return math.sqrt(best), nearest


@compiled
def hull(part: Array, leg: int, legs: Array) -> float:
    """Return the largest distance (m) of control points (dimensions, terms) from a leg."""
    most: float = 0.0
    for i in range(part.shape[1]):
        distance = gap(part, i, leg, legs)
        most = max(most, distance)
    return math.sqrt(most)


@compiled
def alongside(part: Array, leg: int, legs: Array, allowance: float, offsets: Array) -> float:
    """Fill `offsets` (terms, dimensions) with control points of a vector no shorter than the distance from a leg.

    Before and beyond the leg it is the vector from its end, beside it the one square to it.

    Args:
        part: (dimensions, terms) m
        leg: index
        legs: see `prepared`
        allowance: m, by which a part may reach past the ends and still count as beside
        offsets: (terms, dimensions) m

    Returns:
        What must be added to the vector's length, m, or -1 where the part is not on one side.
    """
    dimensions, terms = part.shape
    least, most = np.inf, -np.inf
    for i in range(terms):
        s = along(part, i, leg, legs)
        least, most = min(least, s), max(most, s)
        offsets[i, 0] = s
    past = max(-least, most - 1.0, 0.0)
    inverse = legs[leg, 2 * dimensions]
    length = math.sqrt(1.0 / inverse) if inverse > 0.0 else 0.0
    before, beyond = most <= 0.0, least >= 1.0
    if not (before or beyond or past * length <= allowance):
        return -1.0
    for i in range(terms):
        s = 0.0 if before else 1.0 if beyond else offsets[i, 0]
        for d in range(dimensions):
            offsets[i, d] = part[d, i] - legs[leg, d] - s * legs[leg, dimensions + d]
    return 0.0 if before or beyond else past * length
