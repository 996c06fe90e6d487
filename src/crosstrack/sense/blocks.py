"""Points of surfaces by the small cube of space that they lie in: at most one a voxel, in a window that moves along.

Three levels: coarse cubes of 4 x 4 x 4 blocks of 4 x 4 x 4 voxels. The coarse cubes of the window form a ring buffer
along each axis, so that moving the window moves nothing; blocks are taken from a pool as surfaces are seen and given
back when they empty or leave. The points of a block lie side by side.

Functions that are called for every point take numbers, not arrays: numba counts the references to arrays passed on, and
that takes longer than what is done with them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

Integers = NDArray[np.int64]
Cell = tuple[int, int, int]
Frame = tuple[int, int, int, int]

VOXELS = 64
"""in a block, and blocks in a coarse cube"""
SIDE = 16
"""voxels along the edge of a coarse cube"""
MOST_WEIGHT = 4.0
"""hits that a point is the mean of, at most: later ones count for more, so that it stays on the side last seen"""
MOST_TRUST = 3
"""scans in a row that must see through a point before it goes"""


class Blocks(NamedTuple):
    """A pool of blocks and where to find them."""

    cell: float
    """m, edge of a voxel"""
    window: Integers
    """(4,) lowest coarse cube of the window, and how many there are along each axis"""
    pool: Integers
    """(2,) blocks that were ever taken, and the first of those given back or -1"""
    parts: NDArray[np.int32]
    """(coarse cubes, 64) the block in each part of a coarse cube, -1 for none"""
    active: NDArray[np.int32]
    """(coarse cubes,) blocks in each"""
    place: Integers
    """(blocks, 3) in blocks from the origin of the world"""
    home: Integers
    """(blocks,) where `parts` holds each; -1 - (the next one given back or -1) for one given back"""
    filled: NDArray[np.int32]
    """(blocks,) points in each"""
    points: NDArray[np.float32]
    """(blocks, 3, 64) m, world"""
    voxel: NDArray[np.int8]
    """(blocks, 64) which voxel of the block each point lies in"""
    slot: NDArray[np.int8]
    """(blocks, 64) which point lies in each voxel, -1 for none"""
    weight: NDArray[np.float32]
    """(blocks, 64) hits that each point is the mean of"""
    trust: NDArray[np.int8]
    """(blocks, 64) scans that must see through each point before it goes"""
    seen: NDArray[np.float32]
    """(blocks, 64) s, when each was last hit or seen again"""


def empty(cell: float, cubes: int, blocks: int) -> Blocks:
    """Return no points in a window of so many coarse cubes along each axis, with room for so many blocks."""
    return Blocks(
        cell=cell,
        window=np.array([0, 0, 0, cubes]),
        pool=np.array([0, -1]),
        parts=np.full((cubes**3, VOXELS), -1, dtype=np.int32),
        active=np.zeros(cubes**3, dtype=np.int32),
        place=np.zeros((blocks, 3), dtype=np.int64),
        home=np.full(blocks, -1, dtype=np.int64),
        filled=np.zeros(blocks, dtype=np.int32),
        points=np.zeros((blocks, 3, VOXELS), dtype=np.float32),
        voxel=np.zeros((blocks, VOXELS), dtype=np.int8),
        slot=np.full((blocks, VOXELS), -1, dtype=np.int8),
        weight=np.zeros((blocks, VOXELS), dtype=np.float32),
        trust=np.zeros((blocks, VOXELS), dtype=np.int8),
        seen=np.zeros((blocks, VOXELS), dtype=np.float32),
    )


def grown(blocks: Blocks) -> Blocks:
    """Return the same with room for twice as many blocks."""
    more = empty(blocks.cell, 1, len(blocks.filled))
    names = ("place", "home", "filled", "points", "voxel", "slot", "weight", "trust", "seen")
    joined = {name: np.concatenate([getattr(blocks, name), getattr(more, name)]) for name in names}
    return Blocks(**{**blocks._asdict(), **joined})


@compiled
def frame(blocks: Blocks) -> Frame:
    """Return the lowest coarse cube of the window, and how many there are along each axis."""
    return int(blocks.window[0]), int(blocks.window[1]), int(blocks.window[2]), int(blocks.window[3])


@compiled
def coarse(window: Frame, i: int, j: int, k: int) -> int:
    """Return where `parts` holds a coarse cube; -1 outside the window."""
    n = window[3]
    a, b, c = i - window[0], j - window[1], k - window[2]
    if min(a, b, c) < 0 or max(a, b, c) >= n:
        return -1
    return ((i % n) * n + j % n) * n + k % n


@compiled
def fourth(i: int, j: int, k: int) -> int:
    """Return which part of its parent a cell is, of 4 x 4 x 4."""
    return int(((i & 3) * 4 + (j & 3)) * 4 + (k & 3))


@compiled
def take(blocks: Blocks, cube: int, part: int, place: Cell) -> int:
    """Return a new block in a part of a coarse cube; -1 when the pool is empty."""
    pool = blocks.pool
    if pool[1] >= 0:
        b = pool[1]
        pool[1] = -1 - blocks.home[b]
    elif pool[0] < len(blocks.filled):
        b = pool[0]
        pool[0] += 1
    else:
        return -1
    blocks.home[b] = cube * VOXELS + part
    blocks.place[b, 0], blocks.place[b, 1], blocks.place[b, 2] = place
    blocks.parts[cube, part] = b
    blocks.active[cube] += 1
    return int(b)


@compiled
def give_back(blocks: Blocks, b: int) -> None:
    """Empty a block and give it back to the pool."""
    cube, part = blocks.home[b] // VOXELS, blocks.home[b] % VOXELS
    blocks.parts[cube, part] = -1
    blocks.active[cube] -= 1
    for v in range(VOXELS):
        blocks.slot[b, v] = -1
    blocks.filled[b] = 0
    blocks.home[b] = -1 - blocks.pool[1]
    blocks.pool[1] = b


@compiled
def remove(blocks: Blocks, b: int, p: int) -> None:
    """Take a point out of a block; the last takes its place."""
    last = blocks.filled[b] - 1
    blocks.slot[b, blocks.voxel[b, p]] = -1
    if p != last:
        for axis in range(3):
            blocks.points[b, axis, p] = blocks.points[b, axis, last]
        blocks.voxel[b, p] = blocks.voxel[b, last]
        blocks.weight[b, p], blocks.trust[b, p] = blocks.weight[b, last], blocks.trust[b, last]
        blocks.seen[b, p] = blocks.seen[b, last]
        blocks.slot[b, blocks.voxel[b, p]] = p
    blocks.filled[b] = last


@compiled
def start_point(blocks: Blocks, b: int, voxel: int) -> int:
    """Return a new point of a block, for a voxel that has none; it has no weight yet."""
    p = int(blocks.filled[b])
    blocks.filled[b] = p + 1
    blocks.voxel[b, p], blocks.slot[b, voxel] = voxel, p
    blocks.weight[b, p], blocks.trust[b, p] = 0.0, 0
    return p


@compiled
def move(blocks: Blocks, x: float, y: float, z: float) -> None:
    """Move the window so that a point (m) is in its middle coarse cube; what falls out of it is forgotten."""
    window, edge = blocks.window, blocks.cell * SIDE
    half = window[3] // 2
    i, j, k = int(np.floor(x / edge)) - half, int(np.floor(y / edge)) - half, int(np.floor(z / edge)) - half
    if i == window[0] and j == window[1] and k == window[2]:
        return
    window[0], window[1], window[2] = i, j, k
    now = frame(blocks)
    for b in range(blocks.pool[0]):
        if blocks.filled[b] > 0:
            place = blocks.place
            if coarse(now, place[b, 0] >> 2, place[b, 1] >> 2, place[b, 2] >> 2) < 0:
                give_back(blocks, b)


@compiled
def gathered(blocks: Blocks) -> Array:
    """Return all points (n, 3), m."""
    total = 0
    for b in range(blocks.pool[0]):
        total += blocks.filled[b]
    out, at = np.empty((total, 3)), 0
    for b in range(blocks.pool[0]):
        for p in range(blocks.filled[b]):
            for axis in range(3):
                out[at, axis] = blocks.points[b, axis, p]
            at += 1
    return out
