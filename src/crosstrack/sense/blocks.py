"""Points of surfaces by the small cube of space that they lie in: at most one a voxel, in a window that moves along.

Three levels: coarse cubes of 4 x 4 x 4 blocks of 4 x 4 x 4 voxels. The coarse cubes of the window form a ring buffer
along each axis, so that moving the window moves nothing; blocks are taken from a pool as surfaces are seen and given
back when they empty or leave. The points of all blocks lie side by side, without gaps, so that what is done with every
point reads memory in order; a block knows which are its own.

Functions that are called for every point take numbers, not arrays: numba counts the references to arrays passed on, and
that takes longer than what is done with them.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

Integers = NDArray[np.int64]
Cell = tuple[int, int, int]
Frame = tuple[int, int, int, int, int, int, int]
"""lowest coarse cube of the window, how many there are along each axis, and where the ring begins along each"""

VOXELS = 64
"""in a block, and blocks in a coarse cube"""
USUAL = 10
"""points of a block, for which there is room"""
SIDE = 16
"""voxels along the edge of a coarse cube"""
MOST_HITS = 4
"""hits that a point is the mean of, at most: later ones count for more, so that it stays on the side last seen"""
MOST_TRUST = 3
"""scans compared with a point, in a row, that must see through it before it goes"""
FORGOTTEN = 32
"""blocks left by the window that are emptied with a scan, or an eighth of them where these are more"""

OUTSIDE, FULL = -1, -2
"""instead of a row: a place is outside the window, or there is no room for another point"""


class Blocks(NamedTuple):
    """A pool of blocks and where to find them."""

    cell: float
    """m, edge of a voxel"""
    window: Integers
    """(4,) lowest coarse cube of the window, and how many there are along each axis"""
    pool: Integers
    """(5,) blocks that were ever taken, the first of those given back or -1, how many points there are, the first of
    the blocks that the window has left or -1, and how many these are"""
    parts: NDArray[np.int32]
    """(coarse cubes, 64) the block in each part of a coarse cube, -1 for none"""
    active: NDArray[np.int32]
    """(coarse cubes,) blocks in each"""
    place: Integers
    """(blocks, 3) in blocks from the origin of the world"""
    home: Integers
    """(blocks,) where `parts` holds each; -2 - (the next such block or -1) for one given back or left"""
    filled: NDArray[np.int32]
    """(blocks,) points in each"""
    members: NDArray[np.int32]
    """(blocks, 64) the points of each, as rows of `points`"""
    voxel: NDArray[np.int8]
    """(blocks, 64) which voxel of the block each of its points lies in"""
    slot: NDArray[np.int8]
    """(blocks, 64) which of its points lies in each voxel, -1 for none"""
    points: NDArray[np.float32]
    """(points, 4) m, world, and s, when each was last hit or seen again"""
    worth: NDArray[np.int8]
    """(points, 2) hits that each is the mean of, and scans that must see through it before it goes"""
    owner: NDArray[np.int32]
    """(points,) 64 times the block of each, and which of its points it is"""


def empty(cell: float, cubes: int, blocks: int) -> Blocks:
    """Return no points in a window of so many coarse cubes along each axis, with room for so many blocks."""
    points = blocks * USUAL
    return Blocks(
        cell=cell,
        window=np.array([0, 0, 0, cubes]),
        pool=np.array([0, -1, 0, -1, 0]),
        parts=np.full((cubes**3, VOXELS), -1, dtype=np.int32),
        active=np.zeros(cubes**3, dtype=np.int32),
        place=np.zeros((blocks, 3), dtype=np.int64),
        home=np.full(blocks, -1, dtype=np.int64),
        filled=np.zeros(blocks, dtype=np.int32),
        members=np.zeros((blocks, VOXELS), dtype=np.int32),
        voxel=np.zeros((blocks, VOXELS), dtype=np.int8),
        slot=np.full((blocks, VOXELS), -1, dtype=np.int8),
        points=np.zeros((points, 4), dtype=np.float32),
        worth=np.zeros((points, 2), dtype=np.int8),
        owner=np.zeros(points, dtype=np.int32),
    )


def grown(blocks: Blocks) -> Blocks:
    """Return the same with room for twice as many blocks and points."""
    more = empty(blocks.cell, 1, len(blocks.filled))
    names = ("place", "home", "filled", "members", "voxel", "slot", "points", "worth", "owner")
    joined = {name: np.concatenate([getattr(blocks, name), getattr(more, name)]) for name in names}
    return Blocks(**{**blocks._asdict(), **joined})


@compiled
def frame(blocks: Blocks) -> Frame:
    """Return where the window is, with what would else be divided for every point."""
    i, j, k, n = int(blocks.window[0]), int(blocks.window[1]), int(blocks.window[2]), int(blocks.window[3])
    return i, j, k, n, i % n, j % n, k % n


@compiled
def coarse(window: Frame, i: int, j: int, k: int) -> int:
    """Return where `parts` holds a coarse cube; -1 outside the window."""
    n = window[3]
    a, b, c = i - window[0], j - window[1], k - window[2]
    if min(a, b, c) < 0 or max(a, b, c) >= n:
        return -1
    a, b, c = a + window[4], b + window[5], c + window[6]
    return ((a - n if a >= n else a) * n + (b - n if b >= n else b)) * n + (c - n if c >= n else c)


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
        pool[1] = -2 - blocks.home[b]
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
    unlink(blocks, b)
    drain(blocks, b)


@compiled
def unlink(blocks: Blocks, b: int) -> None:
    """Have a block be found no more."""
    cube, part = blocks.home[b] // VOXELS, blocks.home[b] % VOXELS
    blocks.parts[cube, part] = -1
    blocks.active[cube] -= 1


@compiled
def drain(blocks: Blocks, b: int) -> None:
    """Empty a block that is found no more, and put it with those given back."""
    for p in range(blocks.filled[b] - 1, -1, -1):
        remove(blocks, b, p)
    blocks.home[b] = -2 - blocks.pool[1]
    blocks.pool[1] = b


@compiled
def remove(blocks: Blocks, b: int, p: int) -> None:
    """Take a point out of a block; the last of the block takes its place there, and the last of all its row."""
    members, voxel, slot, points, worth, owner = (
        blocks.members,
        blocks.voxel,
        blocks.slot,
        blocks.points,
        blocks.worth,
        blocks.owner,
    )
    row, final, last = members[b, p], blocks.filled[b] - 1, blocks.pool[2] - 1
    slot[b, voxel[b, p]] = -1
    if p != final:
        members[b, p], voxel[b, p] = members[b, final], voxel[b, final]
        slot[b, voxel[b, p]] = p
        owner[members[b, p]] = b * VOXELS + p
    if row != last:
        for k in range(4):
            points[row, k] = points[last, k]
        worth[row, 0], worth[row, 1], owner[row] = worth[last, 0], worth[last, 1], owner[last]
        members[owner[row] // VOXELS, owner[row] % VOXELS] = row
    blocks.filled[b], blocks.pool[2] = final, last


@compiled
def start_point(blocks: Blocks, b: int, voxel: int) -> int:
    """Return the row of a new point of a block, for a voxel that has none; it is the mean of no hits yet."""
    p, row = int(blocks.filled[b]), int(blocks.pool[2])
    blocks.filled[b], blocks.pool[2] = p + 1, row + 1
    blocks.members[b, p], blocks.voxel[b, p], blocks.slot[b, voxel] = row, voxel, p
    blocks.owner[row] = b * VOXELS + p
    for k in range(3):
        blocks.points[row, k] = 0.0
    blocks.worth[row, 0], blocks.worth[row, 1] = 0, 0
    return row


@compiled
def row_at(blocks: Blocks, window: Frame, x: float, y: float, z: float) -> int:
    """Return the row of the point of the voxel at a place (m), a new one where it has none; OUTSIDE, or FULL."""
    cell = blocks.cell
    i, j, k = math.floor(x / cell), math.floor(y / cell), math.floor(z / cell)
    cube = coarse(window, i >> 4, j >> 4, k >> 4)
    if cube < 0:
        return OUTSIDE
    part, voxel = fourth(i >> 2, j >> 2, k >> 2), fourth(i, j, k)
    b = int(blocks.parts[cube, part])
    if b < 0:
        b = take(blocks, cube, part, (i >> 2, j >> 2, k >> 2))
        if b < 0:
            return FULL
    p = blocks.slot[b, voxel]
    if p >= 0:
        return int(blocks.members[b, p])
    return FULL if blocks.pool[2] == len(blocks.points) else start_point(blocks, b, voxel)


@compiled
def move(blocks: Blocks, x: float, y: float, z: float) -> None:
    """Move the window so that a point (m) is in its middle coarse cube; what falls out of it is found no more."""
    window, edge, pool = blocks.window, blocks.cell * SIDE, blocks.pool
    half = window[3] // 2
    i, j, k = int(np.floor(x / edge)) - half, int(np.floor(y / edge)) - half, int(np.floor(z / edge)) - half
    if i == window[0] and j == window[1] and k == window[2]:
        return
    window[0], window[1], window[2] = i, j, k
    now = frame(blocks)
    for b in range(pool[0]):
        if blocks.home[b] >= 0:
            place = blocks.place
            if coarse(now, place[b, 0] >> 2, place[b, 1] >> 2, place[b, 2] >> 2) < 0:
                unlink(blocks, b)
                blocks.home[b] = -2 - pool[3]
                pool[3], pool[4] = b, pool[4] + 1


@compiled
def forget(blocks: Blocks) -> None:
    """Take away some of the points that the window has left: all at once would take longer than a decision may."""
    pool = blocks.pool
    for _ in range(max(min(pool[4], FORGOTTEN), pool[4] // 8)):
        b = pool[3]
        pool[3], pool[4] = -2 - blocks.home[b], pool[4] - 1
        drain(blocks, b)


def gathered(blocks: Blocks) -> Array:
    """Return all points (n, 3) of the window, m."""
    count = blocks.pool[2]
    inside = blocks.home[blocks.owner[:count] // VOXELS] >= 0
    return blocks.points[:count, :3][inside].astype(float)
