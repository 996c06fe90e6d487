"""Fly a point by potential fields among discs: what each term of the field adds.

python examples/potential_field.py            draws the pictures of docs/potential.md
python examples/potential_field.py --study 50  flies 50 maps of 20 and of 30 discs by every law, and prints the table
"""

import argparse
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.ndimage import label

from crosstrack.avoid.potential_escape import Escape, Side
from crosstrack.avoid.potential_field import Terms
from crosstrack.avoid.potential_published import published_path
from crosstrack.avoid.potential_run import Law, potential_path
from crosstrack.show.potential_picture import bell_picture, field_picture, sides_picture
from crosstrack.types import Array, Outcome
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

START, GOAL = np.zeros(2), np.array([80.0, 80.0])
SIDE = 100.0
"""of the map, in cells, as in the article"""
RADII = (4.0, 9.0)
CLEAR = 5.0
"""cells, free around start and goal"""
DEEP = 1000.0
"""cells, half the height of the discs, so that there is no way over them"""

PICTURED = 20_006
"""seed of the map of the picture"""
WALL = (Box((40.0, 18.0, -DEEP), (45.0, 56.0, DEEP)),)

ARTICLE = Terms(factor="obstacle", approach=True, near_goal=3.0, boost=3.0)
TURNED = Escape("rotate", share=0.6)
LAWS = {
    "classic, Khatib": Law(),
    "classic, to the lowest neighbour": Law(method="descent"),
    "times d(goal, obstacle)²": Law(Terms(factor="obstacle")),
    "times d(vehicle, goal)²": Law(Terms(factor="vehicle")),
    "d(goal, obstacle)², Kv, Kd, Ke": Law(ARTICLE),
    "... random walk": Law(ARTICLE, Escape("walk")),
    "... turned by +60°": Law(ARTICLE, Escape("rotate", side="left")),
    "... turned by -60°": Law(ARTICLE, Escape("rotate", side="right")),
    "... turned to the chosen side": Law(ARTICLE, TURNED),
    "... and brakes": Law(ARTICLE, TURNED, braking=True),
    "... and keeps the side": Law(ARTICLE, Escape("rotate", keep=True), braking=True),
    "the same with d(vehicle, goal)²": Law(
        Terms(factor="vehicle", approach=True, near_goal=3.0, boost=3.0), Escape("rotate", keep=True), braking=True
    ),
}


def discs(count: int, seed: int) -> World:
    """Return a map of discs on which there is a way with a clearance of one cell."""
    random = np.random.default_rng(seed)
    bounds = np.array([[0.0, 0.0, -DEEP], [SIDE, SIDE, DEEP]])
    while True:
        found: list[Cylinder] = []
        while len(found) < count:
            middle, radius = random.uniform(0, SIDE, 2), float(random.uniform(*RADII))
            if min(np.linalg.norm(middle - START), np.linalg.norm(middle - GOAL)) - radius > CLEAR:
                found.append(Cylinder((float(middle[0]), float(middle[1])), radius, (-DEEP, DEEP)))
        world = World(tuple(found), bounds=bounds)
        parts = label(cells(world) > 1.0)[0]
        if parts[0, 0] == parts[80, 80] != 0:
            return world


def cells(world: World) -> Array:
    """Return the distances at the middles of the cells of a map."""
    axis = np.arange(SIDE) + 0.5
    x, y = np.meshgrid(axis, axis, indexing="ij")
    return world.distance(np.stack([x, y, np.ones_like(x)], axis=-1))


def touches(world: World, path: Array) -> bool:
    """Return whether a path (n, 2) touches an obstacle."""
    points = np.column_stack([path, np.ones(len(path))])
    return any(world.swept(a, b) <= 0 for a, b in pairwise(points))


def study(maps: int, counts: list[int]) -> None:
    """Print on how many maps of so many discs each law arrives, and how else it ends."""
    for count in counts:
        worlds = [discs(count, 1000 * count + k) for k in range(maps)]
        paths = [published_path(cells(world) > 0, START, GOAL) for world in worlds]
        arrived = [float(np.linalg.norm(path[-1] - GOAL)) <= 2 for path in paths]
        clean = [done and not touches(world, path) for done, world, path in zip(arrived, worlds, paths, strict=True)]
        print(
            f"{count} discs | as published | arrived {sum(arrived)}, {sum(clean)} without touching a disc", flush=True
        )
        for name, law in LAWS.items():
            runs = [potential_path(world, START, GOAL, law) for world in worlds]
            ends = {end: sum(run.outcome is end for run in runs) for end in Outcome}
            length = [run.length for run in runs if run.outcome is Outcome.ARRIVED]
            words = ", ".join(f"{end.name.lower()} {number}" for end, number in ends.items() if number)
            share = np.median(length) / np.linalg.norm(GOAL - START) if length else np.nan
            print(f"{count} discs | {name} | {words} | length {share:.2f}", flush=True)


def main() -> None:
    """Draw the pictures, or print the study."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--study", type=int, metavar="MAPS", help="how many maps of each kind to fly")
    parser.add_argument("--discs", type=int, nargs="+", default=[20, 30], help="how many discs a map has")
    parser.add_argument("--out", type=Path, default=Path("docs/pictures"), help="folder of the pictures")
    given = parser.parse_args()
    if given.study:
        study(given.study, given.discs)
        return
    draw(given.out)


def draw(folder: Path) -> None:
    """Draw the pictures."""
    bell_picture(folder / "potential_bell.png")
    gentle = replace(ARTICLE, factor="none", influence=12.0)
    world = discs(20, PICTURED)
    laws = {
        "classic": Law(Terms(influence=12.0)),
        "everything": Law(gentle, Escape("rotate", keep=True), braking=True),
    }
    runs = {name: potential_path(world, START, GOAL, law) for name, law in laws.items()}
    field_picture(world, GOAL, laws["classic"], runs, folder / "potential_field.png")
    sides: dict[str, Side] = {"+60°": "left", "-60°": "right", "chosen side": "chosen"}
    wall = World(WALL, bounds=np.array([[0.0, 0.0, -DEEP], [SIDE, SIDE, DEEP]]))
    turned = {name: Law(gentle, Escape("rotate", side=side), braking=True) for name, side in sides.items()}
    runs = {name: potential_path(wall, START, GOAL, law) for name, law in turned.items()}
    sides_picture(wall, GOAL, runs, folder / "potential_sides.png")


if __name__ == "__main__":
    main()
