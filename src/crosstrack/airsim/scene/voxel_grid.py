"""Which cells around a point are in the way, as AirSim writes them: a binvox file.

Cells are ordered as AirSim has them: north changes quickest, then height, then east. Runs of equal cells follow a
header of text, a byte for the value and one for the length of each (Min, binvox, 2004).
"""

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array
from crosstrack.world.world import World

MOST_CELLS = 1 << 25
LONGEST_RUN = 255


def counts(size: tuple[int, int, int], cell: float) -> tuple[int, int, int]:
    """Return how many cells there are north, east and up in a box of so many metres.

    Raises:
        ValueError: there are none, or more than `MOST_CELLS`.
    """
    if not 1e-6 <= cell < 1e6 or min(size) <= 0:
        raise ValueError(f"a grid of {size} m with cells of {cell} m; both must be above 0")
    north, east, up = (int(np.float32(side) / np.float32(cell)) for side in size)
    if not 0 < north * east * up <= MOST_CELLS:
        raise ValueError(f"a grid of {north} x {east} x {up} cells; it must have 1 to {MOST_CELLS}")
    return north, east, up


def occupied(world: World, centre: Array, size: tuple[int, int, int], cell: float) -> NDArray[np.bool_]:
    """Return which cells (east, up, north) are in the way: those that a ball in them touches, and those in the ground.

    Args:
        world: what is there
        centre: (3,) m, NED
        size: m, north, east, up
        cell: m, edge of a cell
    """
    north, east, up = (
        (np.arange(count) - count // 2) * cell + middle
        for count, middle in zip(counts(size, cell), (centre[0], centre[1], -centre[2]), strict=True)
    )
    out = np.zeros((len(east), len(up), len(north)), dtype=bool)
    for k in range(len(east)):
        points = np.stack(np.broadcast_arrays(east[k], north, up[:, None]), axis=-1)
        out[k] = (world.distance(points) <= cell / 2) | (points[..., 2] - cell / 2 < world.ground)
    return out


def binvox(cells: NDArray[np.bool_], size: tuple[int, int, int]) -> bytes:
    """Return the file of cells (east, up, north) in a box of so many metres north, east and up."""
    east, up, north = cells.shape
    low = " ".join(f"{-0.5 * side:g}" for side in size)
    header = (
        f"#binvox 1\ndim {north} {up} {east}\ntranslate {low}\nscale {np.float32(1) / np.float32(size[0]):g}\ndata\n"
    )
    return header.encode() + runs(cells.ravel())


def runs(values: NDArray[np.bool_]) -> bytes:
    """Return runs of equal values, each as the value and a length of at most 255."""
    starts = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1]]))
    lengths = np.diff(np.append(starts, len(values)))
    pieces = -(-lengths // LONGEST_RUN)
    out = np.empty((int(pieces.sum()), 2), dtype=np.uint8)
    out[:, 0] = np.repeat(values[starts], pieces)
    out[:, 1] = LONGEST_RUN
    out[np.cumsum(pieces) - 1, 1] = lengths - (pieces - 1) * LONGEST_RUN
    return out.tobytes()
