"""A* over the points of a lattice, in all 26 directions, and a flood from the goal that ends hopeless searches.

Source: Hart, Nilsson, Raphael 1968, A formal basis for the heuristic determination of minimum cost paths (IEEE
Transactions on Systems Science and Cybernetics).
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.protocols import Field
from crosstrack.search.heap import lower, pop
from crosstrack.search.remaining import Costs
from crosstrack.types import Array

NONE, FOUND, ENCLOSED = range(3)
CLOSED = -2
TIE = 1e-3
"""relative, by which the estimate of what remains counts more: of equals the one nearer to the goal goes first"""


@compiled
def search(
    values: Field, left: Costs, cell: float, wanted: float, doubt: float, start: int, goal: int
) -> tuple[int, NDArray[np.int32], int]:
    """Return whether there is a way, the points of the cheapest one in order, and how many points were looked at.

    Without a way the points are all that can be reached from the goal, `ENCLOSED`, or from the start, `NONE`.

    An edge of length L is free when the distances at its ends add up to L: the balls around them cover it. A metre
    costs 1 + `doubt` (1 - d / `wanted`) at a distance d below the one wanted.

    Args:
        values: (nx, ny, nz) m, distances; below zero where a point may not be passed, as on the six sides
        left: (nx ny,) cells, see `remaining`
        cell: m, between two points
        wanted: m
        doubt: above 0
        start: index of the point, row-major
        goal: likewise
    """
    _, ny, nz = values.shape
    size = values.size
    field = values.reshape(size)
    steps, lengths = directions(ny, nz)
    place, flooded = np.full(size, -1, np.int32), np.zeros(size, np.uint8)
    heap, queue, came = np.empty(size, np.int32), np.empty(size, np.int32), np.empty(size, np.int8)
    cost, keys = np.full(size, np.inf, np.float32), np.empty(size, np.float32)
    height = goal % nz
    queue[0], flooded[goal], head, tail = goal, 1, 0, 1
    cost[start], came[start] = 0.0, -1
    count, seen = lower(start, 0.0, heap, place, keys, 0), 0
    slope = np.float32(doubt / wanted)
    while count > 0:
        at = pop(heap, place, keys, count)
        count -= 1
        place[at] = CLOSED
        seen += 1
        if at == goal:
            return FOUND, traced(came, steps, start, goal), seen
        here, room = cost[at], field[at]
        for k in range(26):
            to = at + steps[k]
            d = field[to]
            if d < 0.0 or room + d < lengths[k] * cell:
                continue
            paid = here + lengths[k] * (1.0 + slope * max(wanted - d, 0.0))
            if paid < cost[to] and place[to] != CLOSED:
                cost[to] = paid
                came[to] = k
                away, climb = left[to // nz], float(to % nz - height)
                key = paid + (1.0 + TIE) * math.sqrt(away * away + climb * climb)
                count = lower(to, key, heap, place, keys, count)
        if flooded[start] == 0:
            if head == tail:
                return ENCLOSED, queue[:tail].copy(), seen
            tail = spread(field, cell, steps, lengths, queue, flooded, head, tail)
            head += 1
    return NONE, np.flatnonzero(place == CLOSED).astype(np.int32), seen


@compiled
def directions(ny: int, nz: int) -> tuple[NDArray[np.int32], Array]:
    """Return of the 26 directions the steps in row-major index, and the lengths in cells."""
    steps, lengths = np.empty(26, np.int32), np.empty(26)
    k = 0
    for i in range(-1, 2):
        for j in range(-1, 2):
            for m in range(-1, 2):
                if i != 0 or j != 0 or m != 0:
                    steps[k] = (i * ny + j) * nz + m
                    lengths[k] = math.sqrt(float(i * i + j * j + m * m))
                    k += 1
    return steps, lengths


@compiled
def spread(
    field: Field,
    cell: float,
    steps: NDArray[np.int32],
    lengths: Array,
    queue: NDArray[np.int32],
    flooded: NDArray[np.uint8],
    head: int,
    tail: int,
) -> int:
    """Flood the neighbours of the next point in the queue; return where the queue then ends."""
    at = queue[head]
    for k in range(26):
        to = at + steps[k]
        if flooded[to] == 0 and field[to] >= 0.0 and field[at] + field[to] >= lengths[k] * cell:
            flooded[to] = 1
            queue[tail] = to
            tail += 1
    return tail


@compiled
def traced(came: NDArray[np.int8], steps: NDArray[np.int32], start: int, goal: int) -> NDArray[np.int32]:
    """Return the points from start to goal, by the directions that they were reached in."""
    count, at = 1, goal
    while at != start:
        at -= steps[came[at]]
        count += 1
    way = np.empty(count, np.int32)
    at = goal
    for i in range(count - 1, 0, -1):
        way[i] = at
        at -= steps[came[at]]
    way[0] = start
    return way
