"""A binary heap of cells by their keys, least first, in which a key can be lowered."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled

Keys = NDArray[np.float32]
Cells = NDArray[np.int32]


@compiled
def lower(cell: int, key: float, heap: Cells, place: Cells, keys: Keys, count: int) -> int:
    """Put a cell into the heap, or lower its key there; return how many it then holds.

    Args:
        cell: which
        key: its key, not above the one it has there
        heap: (cells,) the cells, of which the first `count` are held
        place: (cells,) where in the heap a cell is; -1 where it is not
        keys: (cells,) of the cells
        count: of the cells held
    """
    at = place[cell]
    if at < 0:
        at = count
        count += 1
    keys[cell] = key
    while at > 0:
        above = (at - 1) >> 1
        other = heap[above]
        if keys[other] <= keys[cell]:
            break
        heap[at] = other
        place[other] = at
        at = above
    heap[at] = cell
    place[cell] = at
    return count


@compiled
def pop(heap: Cells, place: Cells, keys: Keys, count: int) -> int:
    """Take the cell with the least key off a heap that is not empty, which then holds one less."""
    top = heap[0]
    place[top] = -1
    count -= 1
    if count > 0:
        cell = heap[count]
        at = 0
        while True:
            below = 2 * at + 1
            if below >= count:
                break
            if below + 1 < count and keys[heap[below + 1]] < keys[heap[below]]:
                below += 1
            if keys[cell] <= keys[heap[below]]:
                break
            heap[at] = heap[below]
            place[heap[at]] = at
            at = below
        heap[at] = cell
        place[cell] = at
    return int(top)
