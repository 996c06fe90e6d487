"""QGroundControl's `.plan` files: missions in JSON with positions in WGS84.

A plan's items are MAVLink mission commands (tables MAV_CMD and MAV_FRAME of MAVLink's common messages).
Heights are taken over the home's altitude as they are, not over the tangent plane, which falls short of them
by d² over the Earth's diameter: 8 cm at 1 km.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.frames import Origin, geodetic_from_local, local_from_geodetic
from crosstrack.mission.text import MAX_BYTES
from crosstrack.types import Array

NAMES = {
    16: "waypoint", 17: "loiter", 18: "loiter turns", 19: "loiter time", 20: "return to launch", 21: "land",
    22: "takeoff", 31: "loiter to altitude", 82: "spline waypoint", 84: "VTOL takeoff", 85: "VTOL land",
    93: "delay", 112: "condition delay", 113: "condition change altitude", 114: "condition distance",
    115: "condition yaw", 177: "jump", 178: "change speed", 179: "set home", 183: "set servo",
    189: "land start", 195: "set region of interest", 197: "no region of interest",
    201: "set region of interest", 203: "control camera", 205: "control mount",
    206: "camera trigger distance", 211: "gripper", 530: "set camera mode", 531: "set camera zoom",
    1000: "gimbal pitch and yaw", 2000: "start taking pictures", 2001: "stop taking pictures",
    2500: "start video", 2501: "stop video", 3000: "VTOL transition",
}  # fmt: skip
"""what the commands are called in remarks"""
THROUGH = {16, 17, 18, 19, 31, 82}
RETURN, LAND, TAKEOFF, SPEED = {20}, {21, 85}, {22, 84}, {178}
SEA_LEVEL, RELATIVE, TERRAIN = {0, 5}, {3, 6}, {10, 11}
"""frames of an item's altitude"""


@dataclass(frozen=True)
class PlanFile:
    """What a `.plan` file holds of a mission."""

    points: Array
    """(n, 3) m, the route, ENU"""
    home: Origin
    """the planned home"""
    takeoff: bool
    """whether it takes off at the first point"""
    speed: float | None
    """m/s, the first speed it sets"""
    remarks: tuple[str, ...]
    """everything in the file that is not flown"""


def read_plan(name: str, content: bytes, origin: Origin | None = None) -> PlanFile:
    """Read a `.plan` file.

    Args:
        name: of the file, for messages
        content: of the file
        origin: where the local (0, 0, 0) lies; left out, at the planned home

    Raises:
        InputError: everything that is wrong with the file.
    """
    reader = _Reader()
    if len(content) > MAX_BYTES:
        raise InputError(name, [Problem("", f"is larger than {MAX_BYTES} bytes")])
    try:
        document = json.loads(content, parse_constant=lambda word: math.nan)
    except (RecursionError, ValueError) as error:
        raise InputError(name, [Problem("", f"not JSON: {error}")]) from None
    reader.read(document)
    if not reader.problems and not reader.route:
        reader.complain("mission.items", "holds no waypoint")
    if reader.problems:
        raise InputError(name, reader.problems)
    home = Origin(*reader.home)
    return PlanFile(
        local_from_plan(np.array(reader.route), origin or home),
        home,
        reader.takeoff,
        reader.speed,
        tuple(reader.remarks()),
    )


@dataclass
class _Reader:
    """What is found while going through a plan."""

    home: tuple[float, float, float] = (0.0, 0.0, 0.0)
    route: list[tuple[float, float, float]] = field(default_factory=list)
    takeoff: bool = False
    speed: float | None = None
    problems: list[Problem] = field(default_factory=list)
    notes: dict[str, list[str]] = field(default_factory=dict)

    def complain(self, place: str, message: str) -> None:
        self.problems.append(Problem(place, message))

    def remarks(self) -> Iterator[str]:
        for note, places in self.notes.items():
            more = f" and {len(places) - 1} more" if len(places) > 1 else ""
            yield f"{places[0]}{more}: {note}"

    def note(self, place: str, message: str) -> None:
        self.notes.setdefault(message, []).append(place)

    def read(self, document: Any) -> None:
        if not isinstance(document, dict) or document.get("fileType") != "Plan":
            self.complain("fileType", "is not 'Plan': not a QGroundControl plan")
            return
        mission = document.get("mission")
        if not isinstance(mission, dict) or not isinstance(mission.get("items"), list):
            self.complain("mission.items", "is missing or no list")
            return
        home = mission.get("plannedHomePosition")
        if not isinstance(home, list) or not _is_position(home):
            self.complain("mission.plannedHomePosition", f"must be [latitude, longitude, altitude], found {home!r:.60}")
            return
        self.home = (float(home[0]), float(home[1]), float(home[2]))
        for place, item in self.simple_items(mission["items"]):
            self.item(place, item)
        for name, key, hint in (
            ("geoFence", "polygons", "; set world.bounds to fence the flight"),
            ("geoFence", "circles", "; set world.bounds to fence the flight"),
            ("rallyPoints", "points", ""),
        ):
            extra = document.get(name)
            if isinstance(extra, dict) and extra.get(key):
                self.note(f"{name}.{key}", f"not imported{hint}")

    def simple_items(self, items: list[Any]) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield the simple items, also those that a survey or a corridor scan was made into."""
        for index, item in enumerate(items):
            place = f"mission.items[{index}]"
            kind = item.get("type") if isinstance(item, dict) else None
            if kind == "SimpleItem":
                yield place, item
            elif kind == "ComplexItem":
                transects = item.get("TransectStyleComplexItem")
                inner = transects.get("Items") if isinstance(transects, dict) else None
                if not isinstance(inner, list):
                    self.note(
                        place,
                        f"{item.get('complexItemType', 'complex item')} without flight items is not flown",
                    )
                    continue
                for number, child in enumerate(inner):
                    yield f"{place}.Items[{number}]", child if isinstance(child, dict) else {}
            else:
                self.complain(place, "is neither a SimpleItem nor a ComplexItem")

    def item(self, place: str, item: dict[str, Any]) -> None:
        command, params = item.get("command"), item.get("params")
        if not isinstance(command, int) or not isinstance(params, list) or len(params) != 7:
            self.complain(place, "must have a command number and 7 params")
            return
        if command in THROUGH | LAND | TAKEOFF:
            self.fly_to(place, command, item, params)
        elif command in RETURN:
            self.come_down(self.home)
        elif command in SPEED and self.speed is None and _is_number(params[1]) and params[1] > 0:
            self.speed = float(params[1])
        else:
            self.note(place, f"{NAMES.get(command, 'command')} ({command}) is not flown")

    def fly_to(self, place: str, command: int, item: dict[str, Any], params: list[Any]) -> None:
        latitude, longitude, height = params[4:]
        if not _is_number(height):
            self.complain(place, f"altitude must be a number, found {height!r:.40}")
            return
        if command in TAKEOFF and not (latitude and longitude):
            latitude, longitude = (self.route[-1] if self.route else self.home)[:2]
        if not _is_position([latitude, longitude, height]):
            self.complain(place, f"must have a latitude and a longitude, found {latitude!r:.40}, {longitude!r:.40}")
            return
        altitude = self.altitude(place, item.get("frame"), float(height))
        if command in LAND:
            self.come_down((latitude, longitude, altitude))
            return
        self.takeoff = self.takeoff or (command in TAKEOFF and not self.route)
        self.route.append((latitude, longitude, altitude))
        if command in {17, 18, 19, 31}:
            self.note(place, f"{NAMES[command]} ({command}) is flown through, without circling or waiting")
        elif command in THROUGH and _is_number(params[0]) and params[0] > 0:
            self.note(place, f"the wait of {params[0]:g} s is not flown")

    def altitude(self, place: str, frame: Any, height: float) -> float:
        """Return metres above sea level."""
        frame = frame if isinstance(frame, int) else repr(frame)
        if frame in SEA_LEVEL:
            return height
        if frame in TERRAIN:
            self.note(place, "the terrain is taken to be flat, at the home's altitude")
        elif frame not in RELATIVE:
            self.complain(place, f"frame {frame!s:.20} is unknown; allowed: 0 (sea level), 3 (home), 10 (terrain)")
        return self.home[2] + height

    def come_down(self, where: tuple[float, float, float]) -> None:
        """Fly over a place at the height reached, and down to it."""
        over = max(self.route[-1][2], where[2]) if self.route else where[2]
        self.route += [(where[0], where[1], over), where]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e7


def _is_position(value: Any) -> bool:
    if not isinstance(value, list) or len(value) != 3 or not all(map(_is_number, value)):
        return False
    return bool(abs(value[0]) <= 90 and abs(value[1]) <= 180 and (value[0] or value[1]))


def local_from_plan(geodetic: Array, origin: Origin) -> Array:
    """Return ENU points (n, 3) of rows of latitude °, longitude °, altitude m; up is over the origin."""
    level = np.column_stack([geodetic[:, :2], np.full(len(geodetic), origin.altitude)])
    return np.column_stack([local_from_geodetic(level, origin)[:, :2], geodetic[:, 2] - origin.altitude])


def plan_from_local(points: Array, origin: Origin) -> Array:
    """Undo `local_from_plan`: find where the level of the origin's altitude has each point's x and y."""
    level = np.array(points, float)
    level[:, 2] = 0.0
    for _ in range(3):  # each time closer by (distance / Earth's radius)²
        geodetic = geodetic_from_local(level, origin)
        level[:, 2] -= geodetic[:, 2] - origin.altitude
    return np.column_stack([geodetic[:, :2], points[:, 2] + origin.altitude])
