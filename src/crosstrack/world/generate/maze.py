"""A maze with exactly one way between any two of its cells."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Positive
from crosstrack.world.generate.common import MOST_SHAPES, Corner, Seed, Size, check, wall
from crosstrack.world.shapes import Shape

Passages = NDArray[np.bool_]


@dataclass(frozen=True)
class Maze:
    """Walls along the edges of square cells, which form one tree of corridors.

    As many whole cells as fit into `size` are laid from `origin`. The first cell is open to the west at the
    lowest corner, the last to the east at the highest.
    """

    seed: Seed = 0
    size: Size = (20.0, 20.0, 3.0)
    """m, along x and y, and the height of the walls"""
    cell: Positive = 2.0
    """m, from the middle of a wall to the middle of the next"""
    wall: Positive = 0.2
    """m, thickness of the walls"""
    origin: Corner = (0.0, 0.0)
    """m, lowest corner"""

    def __post_init__(self) -> None:
        columns, rows = self.size[0] / self.cell, self.size[1] / self.cell
        check(
            (
                f"size {list(self.size[:2])} must hold at least one cell of {self.cell} m"
                if min(columns, rows) < 1
                else "",
                f"size / cell gives {columns * rows:.6g} cells; at most {MOST_SHAPES}"
                if columns * rows > MOST_SHAPES
                else "",
                f"wall is {self.wall}: it must be below cell, {self.cell}" if self.wall >= self.cell else "",
            )
        )

    @property
    def cells(self) -> tuple[int, int]:
        """Cells along x and y."""
        return int(self.size[0] / self.cell + 1e-9), int(self.size[1] / self.cell + 1e-9)

    def shapes(self, ground: float = 0.0) -> tuple[Shape, ...]:
        """Return the walls, those in line as one box."""
        east, north = carve(*self.cells, np.random.default_rng(self.seed))
        across = np.pad(~east, ((1, 1), (0, 0)), constant_values=True)
        across[0, 0] = across[-1, -1] = False
        along = np.pad(~north, ((0, 0), (1, 1)), constant_values=True).T
        lines = [((i, a), (i, b)) for i, row in enumerate(across) for a, b in runs(row)]
        lines += [((a, j), (b, j)) for j, row in enumerate(along) for a, b in runs(row)]
        z = (ground, ground + self.size[2])
        return tuple(wall(self._place(a), self._place(b), self.wall, *z) for a, b in lines)

    def _place(self, corner: tuple[int, int]) -> Corner:
        """Return where a corner of the cells lies."""
        return self.origin[0] + corner[0] * self.cell, self.origin[1] + corner[1] * self.cell


def carve(columns: int, rows: int, rng: np.random.Generator) -> tuple[Passages, Passages]:
    """Join all cells by a depth-first walk that backs out of dead ends.

    Returns:
        whether a cell opens to the east (columns - 1, rows) and to the north (columns, rows - 1)
    """
    east, north = np.zeros((columns - 1, rows), dtype=bool), np.zeros((columns, rows - 1), dtype=bool)
    seen, way = {(0, 0)}, [(0, 0)]
    while way:
        i, j = way[-1]
        around = [(i + 1, j), (i, j + 1), (i - 1, j), (i, j - 1)]
        fresh = [(a, b) for a, b in around if 0 <= a < columns and 0 <= b < rows and (a, b) not in seen]
        if not fresh:
            way.pop()
            continue
        a, b = fresh[rng.integers(len(fresh))]
        passage = east if a != i else north
        passage[min(i, a), min(j, b)] = True
        seen.add((a, b))
        way.append((a, b))
    return east, north


def runs(row: Passages) -> list[tuple[int, int]]:
    """Return first and one past the last of each run of set entries."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]])))
    return [(int(a), int(b)) for a, b in list(pairwise(edges))[::2]]
