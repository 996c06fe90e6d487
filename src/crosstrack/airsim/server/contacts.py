"""What a served vehicle hits: the ground as a point does, everything else, other vehicles too, as a ball does."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from crosstrack import frames
from crosstrack.airsim.firmware.quadrotor import Quadrotor
from crosstrack.airsim.scene.names import first_number
from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.structs import CollisionInfo
from crosstrack.types import Array

SKIN = 1e-4
"""m, to which the instant of a contact is found"""
UP = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True)
class Hit:
    """Where and what a vehicle hit."""

    position: Array
    """(3,) m, of the vehicle then, world NED"""
    normal: Array
    """(3,) away from what was hit, world NED"""
    reach: float
    """m, from the vehicle to the point of contact"""
    depth: float
    """m, by which it is inside"""
    name: str
    number: int
    """in segmentation pictures"""


class Feeler:
    """Finds what one vehicle hits; remembers how far it may fly before it needs to look again."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Look again the next time, wherever the vehicle is."""
        self._scene: object = None
        self._free = 0.0
        self._last: Array | None = None

    def feel(self, scene: Scene, position: Array, grounded: bool, solid: bool = True) -> Hit | None:
        """Return what a vehicle has hit on its way to a position (3,) m, world NED; only the ground where not solid."""
        last = position if self._last is None else self._last
        self._last = position
        if grounded:
            return None
        floor = -scene.ground
        found = ground_hit(scene, last, position, floor) if position[2] > floor else None
        if found is None and solid:
            found = self._obstacle(scene, last, position)
        if found is not None:
            self._last = found.position  # it got no farther, whatever its body thinks
        return found

    def _obstacle(self, scene: Scene, last: Array, position: Array) -> Hit | None:
        flown = math.dist(last, position)
        self._free -= flown
        if scene.world is self._scene and self._free > 0:
            return None
        self._scene = scene.world
        before, now = frames.enu_from_ned(last), frames.enu_from_ned(position)
        here = float(scene.world.distance(now))
        self._free = here - scene.radius
        if here >= scene.radius + flown or scene.world.swept(before, now) >= scene.radius:
            return None
        self._free = 0.0
        return ball_hit(scene, before, now)


def vehicle_hit(radius: float, position: Array, others: Iterable[tuple[str, Array]]) -> Hit | None:
    """Return the first of other vehicles that one at a position (3,) m, world NED, has hit: all are balls of a radius.

    Args:
        radius: m
        position: of the vehicle
        others: their names and positions
    """
    for name, other in others:
        apart = position - other
        distance = float(np.linalg.norm(apart))
        if 0.0 < distance < 2.0 * radius:
            depth = 2.0 * radius - distance
            return Hit(position, apart / distance, radius - 0.5 * depth, depth, name, first_number(name))
    return None


def ground_hit(scene: Scene, last: Array, position: Array, floor: float) -> Hit:
    """Return where the way from one position to the next meets the ground."""
    share = 0.0
    if position[2] > floor > last[2]:
        share = (position[2] - floor) / (position[2] - last[2])
    touch = position - share * (position - last)
    return Hit(np.array([touch[0], touch[1], floor]), UP, 0.0, 0.0, scene.floor.name, scene.floor.number)


def ball_hit(scene: Scene, before: Array, now: Array) -> Hit | None:
    """Return where a ball that goes from one point to the next, ENU, first touches an obstacle."""
    length = math.dist(before, now)
    way = (now - before) / max(length, 1e-12)
    gone, gap = 0.0, float(scene.world.distance(before)) - scene.radius
    while gap > SKIN and gone < length:
        gone = min(gone + gap, length)
        gap = float(scene.world.distance(before + gone * way)) - scene.radius
    if gap > SKIN:
        return None
    at = before + gone * way
    normal = scene.world.gradient(at)
    size = float(np.linalg.norm(normal))
    if size == 0 or (gone == 0 and way @ normal > 0):
        return None
    normal = normal / size
    sighting = scene.eye.look(at, -normal[None], 10 * scene.radius)
    thing = scene.eye.things[int(sighting.seen[0])]
    depth = max(-gap, 0.0)
    reach = gap + scene.radius
    return Hit(frames.ned_from_enu(at), frames.ned_from_enu(normal), reach, depth, thing.name, thing.number)


def touch(quadrotor: Quadrotor, hit: Hit, start: Array, now: int) -> CollisionInfo:
    """Tell the rigid body of a hit at a time (ns); return what the API says of it, relative to the start (3,) m."""
    position = hit.position - start
    point = position - hit.reach * hit.normal
    quadrotor["contact_normal"], quadrotor["contact_position"] = hit.normal, position
    quadrotor["contact_point"], quadrotor["contact_depth"] = point, hit.depth
    quadrotor["touched"] = True
    return CollisionInfo(True, hit.depth, now, hit.normal, point, position, hit.name, hit.number)
