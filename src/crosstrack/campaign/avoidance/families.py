"""Families of worlds from seeds, each with a start and a goal: what avoidance is measured in.

All obstacles are upright and as high as the space, so that the shortest way is known exactly, see `optimum`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from crosstrack.errors import InputError, Problem

TOP = 3.0
"""m, height of the space and of everything in it"""
HEIGHT = 1.5
"""m, of start and goal"""
MARGIN = 1.5
"""m, that stays free around start and goal in forests and among discs"""
THIN = 0.2
"""m, of walls"""


@dataclass(frozen=True)
class Arena:
    """A world to fly in, from one place to another."""

    family: str
    seed: int
    start: tuple[float, float, float]
    """m"""
    goal: tuple[float, float, float]
    """m"""
    world: Mapping[str, Any]
    """as a mission has it"""

    @property
    def name(self) -> str:
        """Family and seed."""
        return f"{self.family}-{self.seed}"


def forest(density: float, family: str, seed: int) -> Arena:
    """Return trunks of 0.2 to 0.5 m, so many per m², on 40 x 20 m, to be crossed the long way."""
    ends = ((1.0, 10.0), (39.0, 10.0))
    trees = {"kind": "forest", "seed": seed, "density": density, "radius": [0.2, 0.5], "size": [40.0, 20.0, TOP]}
    clear = {"clear": [list(end) for end in ends], "clear_radius": MARGIN}
    return arena(family, seed, *ends, (-1.0, 0.0, 41.0, 20.0), {"generate": trees | clear})


def discs(count: int, family: str, seed: int) -> Arena:
    """Return round obstacles on a square field, to be crossed from its lowest corner towards the highest.

    The field of the article is 100 cells wide, and crossed from (0, 0) to (80, 80); a cell is 0.4 m here, and the
    radii are 3 to 8 cells.
    """
    ends, side = ((1.0, 1.0), (33.0, 33.0)), 40.0
    many = {"kind": "forest", "seed": seed, "density": count / side**2, "radius": [1.2, 3.2], "size": [side, side, TOP]}
    clear = {"clear": [list(end) for end in ends], "clear_radius": MARGIN}
    return arena(family, seed, *ends, (-1.0, -1.0, side + 1, side + 1), {"generate": many | clear})


def maze(family: str, seed: int) -> Arena:
    """Return a maze of 7 x 7 cells of 2 m, to be crossed from its entrance to its exit."""
    side = 14.0
    walls = {"kind": "maze", "seed": seed, "cell": 2.0, "wall": THIN, "size": [side, side, TOP]}
    return arena(family, seed, (-1.0, 1.0), (side + 1, side - 1), (-2.0, 0.0, side + 2, side), {"generate": walls})


def trap(family: str, seed: int) -> Arena:
    """Return a U that is open towards the start, with the goal behind its back."""
    draw = np.random.default_rng(seed)
    long, wide = draw.uniform((4.0, 4.0), (9.0, 9.0))
    walls = {"kind": "trap", "seed": seed, "size": [float(long), float(wide), TOP], "wall": THIN}
    place = {"origin": [5.0, float(10.0 - wide * draw.uniform(0.3, 0.7))]}
    return arena(family, seed, (0.0, 10.0), (18.0, 10.0), (-2.0, 0.0, 20.0, 20.0), {"generate": walls | place})


def gap(family: str, seed: int) -> Arena:
    """Return a wall with one gap of 0.52 to 1.2 m."""
    draw = np.random.default_rng(seed)
    width = float(draw.uniform(0.52, 1.2))
    walls = {
        "kind": "gap",
        "seed": seed,
        "width": width,
        "wall": float(draw.uniform(0.1, 0.6)),
        "size": [20.0, 10.0, TOP],
    }
    start, goal = ((end, float(draw.uniform(1.0, 9.0))) for end in (1.0, 19.0))
    return arena(family, seed, start, goal, (-1.0, 0.0, 21.0, 10.0), {"generate": walls})


def beside(family: str, seed: int) -> Arena:
    """Return a corner of two walls with the goal inside it, 0.3 to 0.6 m from both, turned any quarter way round."""
    draw = np.random.default_rng(seed)
    near = draw.uniform(0.3, 0.6, size=2)
    long = draw.uniform(1.0, 5.0, size=2)
    goal, turn = np.array([12.0, 8.0]), int(draw.integers(4))
    walls = [(-near[0] - THIN, -near[1] - THIN, -near[0], long[1]), (-near[0], -near[1] - THIN, long[0], -near[1])]
    shapes = [{"box": box(*(goal + turned(corner, turn) for corner in (wall[:2], wall[2:])))} for wall in walls]
    return arena(family, seed, (1.0, 8.0), (12.0, 8.0), (-1.0, 0.0, 20.0, 16.0), {"shapes": shapes})


def closed(family: str, seed: int) -> Arena:
    """Return a goal that cannot be reached: inside a disc, or within four walls."""
    draw = np.random.default_rng(seed)
    goal, half = np.array([12.0, 8.0]), float(draw.uniform(0.8, 3.0))
    if draw.uniform() < 0.5:
        shapes = [{"cylinder": {"center": goal.tolist(), "radius": half, "z": [0.0, TOP]}}]
    else:
        sides = [((-half - THIN, -half - THIN), (half + THIN, -half)) for _ in range(4)]
        shapes = [{"box": box(*(goal + turned(corner, k) for corner in side))} for k, side in enumerate(sides)]
    return arena(family, seed, (1.0, 8.0), (12.0, 8.0), (-1.0, 0.0, 20.0, 16.0), {"shapes": shapes})


def arena(
    family: str,
    seed: int,
    start: tuple[float, float],
    goal: tuple[float, float],
    around: tuple[float, float, float, float],
    world: Mapping[str, Any],
) -> Arena:
    """Return an arena between bounds around it: lowest x and y, highest x and y (m)."""
    bounds = [[around[0], around[1], 0.0], [around[2], around[3], TOP]]
    return Arena(family, seed, (*start, HEIGHT), (*goal, HEIGHT), {"bounds": bounds, **world})


def turned(point: Sequence[float], quarters: int) -> Any:
    """Return a point (2,) turned counter-clockwise about the origin by quarters of a full turn."""
    x, y = point
    for _ in range(quarters):
        x, y = -y, x
    return np.array([x, y])


def box(one: Any, other: Any) -> dict[str, list[float]]:
    """Return the box as high as the space between two opposite corners (2,) m, as a mission has it."""
    low, high = np.minimum(one, other), np.maximum(one, other)
    return {"min": [*low.tolist(), 0.0], "max": [*high.tolist(), TOP]}


FAMILIES: dict[str, Callable[[str, int], Arena]] = {
    **{f"forest-{density}": partial(forest, density) for density in (0.1, 0.2, 0.3, 0.4)},
    **{f"discs-{count}": partial(discs, count) for count in (20, 30)},
    "maze": maze,
    "trap": trap,
    "gap": gap,
    "beside": beside,
    "closed": closed,
}


def families(words: Sequence[str]) -> list[str]:
    """Return the families that words name, all of them without any; `forest` names all forests.

    Raises:
        InputError: a word names none.
    """
    unknown = [word for word in words if not any(named(word, name) for name in FAMILIES)]
    if unknown:
        known = f"known: {', '.join(FAMILIES)}"
        raise InputError("families", [Problem(word, f"there is no such family; {known}") for word in unknown])
    return [name for name in FAMILIES if not words or any(named(word, name) for word in words)]


def named(word: str, family: str) -> bool:
    """Return whether a word names a family, or the group it is of."""
    return word in {family, family.partition("-")[0]}


def arenas(family: str, count: int, seed: int) -> list[Arena]:
    """Return so many worlds of a family, from a seed on."""
    return [FAMILIES[family](family, seed + k) for k in range(count)]
