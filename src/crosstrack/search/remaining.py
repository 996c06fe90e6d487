"""How far it is at least to the goal: Dijkstra's search over the plane, a column being as free as its freest point.

No way over the lattice is shorter seen from above than the shortest one here, so with the height that is left as the
other side of a right angle it never says too much. Where obstacles stand upright, trees and walls, it is nearly exact.

Source: Dijkstra 1959, A note on two problems in connexion with graphs (Numerische Mathematik).
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.protocols import Field
from crosstrack.search.heap import lower, pop

Costs = NDArray[np.float32]
CLOSED = -2


@compiled
def remaining(values: Field, cell: float, wanted: float, doubt: float, goal: int) -> Costs:
    """Return the least cost to a goal from everywhere, (nx ny,) cells, inf where there is no way.

    Args:
        values: (nx, ny) m, distances; below zero where a point may not be passed, as on the four sides
        cell: m, between two points
        wanted: m, see `astar.search`
        doubt: likewise
        goal: index of the point, row-major
    """
    nx, ny = values.shape
    size = nx * ny
    field = values.reshape(size)
    steps = np.array([-ny - 1, -ny, -ny + 1, -1, 1, ny - 1, ny, ny + 1])
    place, heap, keys = np.full(size, -1, np.int32), np.empty(size, np.int32), np.empty(size, np.float32)
    cost = np.full(size, np.inf, np.float32)
    cost[goal] = 0.0
    count = lower(goal, 0.0, heap, place, keys, 0)
    slope = np.float32(doubt / wanted)
    while count > 0:
        at = pop(heap, place, keys, count)
        count -= 1
        place[at] = CLOSED
        dear = 1.0 + slope * max(wanted - field[at], 0.0)
        for k in range(8):
            to = at + steps[k]
            length = 1.0 if k in (1, 3, 4, 6) else math.sqrt(2.0)
            if field[to] < 0.0 or field[at] + field[to] < length * cell:
                continue
            paid = cost[at] + length * dear
            if paid < cost[to] and place[to] != CLOSED:
                cost[to] = paid
                count = lower(to, paid, heap, place, keys, count)
    return cost
