"""The scene: named things over a world, and what looks at them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from crosstrack import frames
from crosstrack.airsim.firmware import airframe
from crosstrack.airsim.scene import trace
from crosstrack.airsim.scene.blocks import blocks
from crosstrack.airsim.scene.markers import Markers
from crosstrack.airsim.scene.names import first_number
from crosstrack.airsim.scene.thing import Thing, flat, standing
from crosstrack.airsim.scene.trace import Numbers
from crosstrack.types import Array
from crosstrack.world.grids import Relief, Voxels
from crosstrack.world.shapes import Sphere
from crosstrack.world.table import Table, tabulate
from crosstrack.world.world import World

SPECK = Sphere((0.0, 0.0, -1e9), 1e-3)
"""stands for the obstacles of a world without any"""
MOST_THINGS = 10_000
MOST_CELLS = 1 << 24
"""of all things that clients have cut into cubes"""


@dataclass(frozen=True, eq=False)
class Sighting:
    """What rays from a point hit."""

    ranges: Array
    """(n,) m, inf for the sky"""
    seen: Numbers
    """(n,) which thing, by its place in `Eye.things`"""
    rows: Numbers
    """(n,) which obstacle of the table, -1 for the sky, the ground and vehicles"""


@dataclass(frozen=True, eq=False)
class Eye:
    """What can be seen at one instant, by one vehicle or from outside."""

    table: Table
    owners: Numbers
    """(rows,) the thing that each obstacle belongs to"""
    things: tuple[Thing, ...]
    """sky, ground, things of the scene, other vehicles"""
    balls: Array
    """(k, 4) m, centres and radii of the other vehicles, ENU"""
    ground: float
    """m, ENU"""

    @property
    def numbers(self) -> Numbers:
        """(things,) in segmentation pictures"""
        return np.array([thing.number for thing in self.things], dtype=np.int64)

    def look(self, origin: Array, directions: Array, reach: float) -> Sighting:
        """Return what rays from a point (3,) m along unit vectors (n, 3) hit within a reach (m), ENU.

        Only sky from a point that is not finite: compiled code would look it up outside its tables.
        """
        if not (np.isfinite(origin).all() and np.isfinite(directions).all()):
            count = len(directions)
            return Sighting(np.full(count, np.inf), np.full(count, trace.SKY), np.full(count, -1))
        return Sighting(*trace.look(self.table, self.owners, self.balls, origin, directions, reach, self.ground))

    def cast(self, origin: Array, directions: Array, reach: float) -> tuple[Array, Numbers]:
        """Return how far rays go (n,) m, inf for the sky, and the segmentation number (n,) of what they hit; NED."""
        start = np.ascontiguousarray(frames.enu_from_ned(origin))
        sighting = self.look(start, np.ascontiguousarray(frames.enu_from_ned(directions)), reach)
        return sighting.ranges, self.numbers[sighting.seen]

    def normals(self, origin: Array, directions: Array, sighting: Sighting) -> Array:
        """Return the unit vectors (n, 3) out of what rays have hit, ENU; zero for the sky."""
        after, found = len(self.things) - len(self.balls), sighting
        return trace.normals(self.table, self.balls, after, origin, directions, found.ranges, found.seen, found.rows)


class Scene:
    """Named things over a world; the world is made anew when a thing changes.

    Args:
        world: with obstacles that have no names; None for a world of our own
        radius: m, of the ball that a vehicle is to others and to obstacles
    """

    def __init__(self, world: World | None = None, radius: float = airframe.RADIUS) -> None:
        self.radius = radius
        self.sky = flat("SkySphere", first_number("SkySphere"))
        self.floor = flat("Ground", first_number("Ground"))
        self.things: dict[str, Thing] = {}
        self.ground = 0.0 if world is None else world.ground
        """m, ENU"""
        self.bounds = None if world is None else world.bounds
        self.markers = Markers()
        self.numbers: dict[str, int] = {}
        """in segmentation pictures, of vehicles whose number was changed"""
        self.equipment: Any = None
        """what vehicles carry, kept here for who handles calls"""
        for thing in blocks() if world is None else numbered_things(world):
            self.things[thing.name] = thing

    @cached_property
    def world(self) -> World:
        """The obstacles as a map, ENU."""
        solids = [thing.solid for thing in self.things.values()]
        grids = tuple(solid for solid in solids if isinstance(solid, Relief | Voxels))
        shapes = tuple(solid for solid in solids if solid is not None and not isinstance(solid, Relief | Voxels))
        return World(shapes, grids, self.bounds, self.ground)

    @cached_property
    def eye(self) -> Eye:
        """What can be seen without any vehicle."""
        things = tuple(self.things.values())
        gridded = np.array([isinstance(thing.solid, Relief | Voxels) for thing in things], dtype=bool)
        places = np.concatenate([np.flatnonzero(~gridded), np.flatnonzero(gridded)])
        table = self.world.table or tabulate([SPECK], [])
        assert table is not None
        owners = trace.GROUND + 1 + places if len(places) else np.array([trace.SKY])
        return Eye(table, owners[table.places], (self.sky, self.floor, *things), np.empty((0, 4)), self.ground)

    def eye_among(self, vehicles: Iterable[tuple[str, Array]]) -> Eye:
        """Return what can be seen among vehicles, given by their names and where they are (3,) m, NED."""
        found = list(vehicles)
        if not found:
            return self.eye
        centres = frames.enu_from_ned(np.array([position for _, position in found]))
        balls = np.column_stack([centres, np.full(len(found), self.radius)])
        ghosts = (flat(name, self.number_of(name)) for name, _ in found)
        return replace(self.eye, things=(*self.eye.things, *ghosts), balls=balls)

    def put(self, thing: Thing) -> None:
        """Add a thing, or replace the one of the same name.

        Raises:
            ValueError: there are too many things, or too many cubes that they are cut into.
        """
        others = [one for one in self.things.values() if one.name != thing.name]
        if len(others) >= MOST_THINGS:
            raise ValueError(f"there are {MOST_THINGS} things; no more are added")
        if thing.cells and thing.cells + sum(one.cells for one in others) > MOST_CELLS:
            raise ValueError(f"things are cut into {MOST_CELLS} cubes; no more are added that do not stand upright")
        self.things[thing.name] = thing
        self.changed()

    def remove(self, name: str) -> None:
        """Take a thing away."""
        del self.things[name]
        self.changed()

    def changed(self) -> None:
        """Have the world and what is seen made anew."""
        for made in ("world", "eye"):
            self.__dict__.pop(made, None)

    def all(self) -> Sequence[Thing]:
        """Return the sky, the ground, and the things."""
        return [self.sky, self.floor, *self.things.values()]

    def number_of(self, vehicle: str) -> int:
        """Return the number of a vehicle in segmentation pictures."""
        return self.numbers.get(vehicle, first_number(vehicle))

    def renumber(self, names: Iterable[str], number: int) -> None:
        """Give things, or vehicles, a number in segmentation pictures."""
        for name in names:
            if name == self.sky.name:
                self.sky = replace(self.sky, number=number)
            elif name == self.floor.name:
                self.floor = replace(self.floor, number=number)
            elif name in self.things:
                self.things[name] = replace(self.things[name], number=number)
            else:
                self.numbers[name] = number
        self.__dict__.pop("eye", None)


def numbered_things(world: World) -> list[Thing]:
    """Return the obstacles of a world as things, named by their kind and a number."""
    things, counts = [], dict[str, int]()
    for solid in (*world.shapes, *(grid for grid in world.grids if grid.occupied.any())):
        kind = {"Relief": "Walls", "Voxels": "Cloud"}.get(type(solid).__name__, type(solid).__name__)
        counts[kind] = counts.get(kind, 0) + 1
        name = f"{kind}_{counts[kind]}"
        things.append(standing(name, first_number(name), solid))
    return things
