"""Worlds to learn in, packed into one table, so that compiled code looks into any of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.campaign.avoidance.families import FAMILIES, MARGIN, TOP, Arena, arena
from crosstrack.types import Array
from crosstrack.world.table import PRISM, RELIEF, VOXELS, Table
from crosstrack.world.world import World

WIDTH, LENGTH, END = 20.0, 40.0, 2.0
"""m, of the forest; from start to goal; beyond them"""
MANY = 10_000
"""seeds of one training, or of one measurement"""
TESTED, HELD_OUT = 500_000, 1_000_000
"""Seeds below HELD_OUT are never trained with; by those below TESTED trainings choose their best policy."""


class Pool(NamedTuple):
    """Arenas as one table."""

    table: Table
    """of all obstacles, without a tree"""
    first: NDArray[np.int64]
    """(arenas + 1,) first obstacle of each, and how many there are in all"""
    most: int
    """obstacles of one"""
    starts: Array
    """(arenas, 3) m"""
    goals: Array
    """(arenas, 3) m"""
    bounds: Array
    """(arenas, 6) m, lowest and highest corner"""


def seeds(seed: int, count: int, held_out: bool) -> range:
    """Return the seeds of the worlds of a training, or of those held out: at `seed` times MANY."""
    first = seed % (HELD_OUT // MANY) * MANY if held_out else HELD_OUT + seed % 1000 * MANY
    return range(first, first + count)


def forest(density: float, seed: int, spread: float = 0.0) -> Arena:
    """Return a forest of trunks of 0.2 to 0.5 m to be crossed for 40 m.

    Args:
        density: trees per m²
        seed: of the trunks, and of start and goal
        spread: m, by which start and goal may lie beside the middle
    """
    sideways = np.random.default_rng(seed).uniform(-spread, spread, size=2) + WIDTH / 2
    ends = ((END, float(sideways[0])), (END + LENGTH, float(sideways[1])))
    size = (LENGTH + 2 * END, WIDTH)
    trees = {"kind": "forest", "seed": seed, "density": density, "radius": [0.2, 0.5], "size": [*size, TOP]}
    clear = {"clear": [list(end) for end in ends], "clear_radius": MARGIN}
    return arena(f"forest-{density:g}", seed, *ends, (0.0, 0.0, *size), {"generate": trees | clear})


def arenas(family: str, density: float, seeds: Sequence[int], spread: float = 0.0) -> list[Arena]:
    """Return worlds of a family: `forest`, of a density, or one of the benchmark of avoidance."""
    if family == "forest":
        return [forest(density, seed, spread) for seed in seeds]
    return [FAMILIES[family](family, seed) for seed in seeds]


def pool(made: Sequence[Arena], worlds: Sequence[World]) -> Pool:
    """Return arenas, and the worlds that they are, as one table."""
    tables = [world.table for world in worlds]
    first = np.cumsum([0, *(0 if table is None else len(table.kinds) for table in tables)])
    bounds = [np.ravel(world.bounds) if world.bounds is not None else [-np.inf] * 3 + [np.inf] * 3 for world in worlds]
    return Pool(
        joined([table for table in tables if table is not None]),
        first,
        int(np.diff(first).max(initial=0)),
        np.array([one.start for one in made]),
        np.array([one.goal for one in made]),
        np.array(bounds, dtype=float),
    )


def joined(tables: Sequence[Table]) -> Table:
    """Return tables one after another; what their rows say of corners and grids is moved along."""
    moved, corners, cells = [], 0, 0
    for table in tables:
        numbers = table.numbers.copy()
        numbers[table.kinds == PRISM, 0] += corners
        numbers[(table.kinds == RELIEF) | (table.kinds == VOXELS), 0] += cells
        corners, cells = corners + len(table.corners), cells + len(table.values)
        moved.append(numbers)
    return Table(
        np.concatenate([np.empty(0, np.int64), *(table.kinds for table in tables)]),
        np.concatenate([np.empty((0, 8)), *moved]),
        np.concatenate([np.empty((0, 6)), *(table.boxes for table in tables)]),
        np.concatenate([np.empty((0, 2)), *(table.corners for table in tables)]),
        np.concatenate([np.empty(0), *(table.values for table in tables)]),
        np.concatenate([np.empty(0, bool), *(table.occupied for table in tables)]),
        np.empty((0, 6)),
        np.empty((0, 2), np.int64),
        np.empty(0, np.int64),
    )
