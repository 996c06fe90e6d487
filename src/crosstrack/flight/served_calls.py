"""What clients of a server called, and what vehicles touched."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from crosstrack.airsim.structs import YawMode
from crosstrack.types import Array

STREAM = 0.25
"""s, from one call to the next, up to which calls of the same move are one stream of them"""
CONTACT = 1.0
"""s, without touching it, after which touching the same thing is another collision"""
MOST = 10_000
"""calls, and collisions, that are kept; of those after them only the number"""
FOREVER = 1e30
"""s, a time-out that is none"""
ANSWERS = ("true", "false", "")
"""all others are errors, and end a stream"""
LONGEST = 200
"""letters of a text that are kept"""


@dataclass(frozen=True)
class Call:
    """A move, or a stream of calls of the same move."""

    vehicle: str
    """empty for a reset of all"""
    name: str
    arguments: str
    """without the vehicle; of the first call of a stream"""
    begins: float
    """s, since the session began"""
    ends: float = math.nan
    """s; NaN where it was under way when the session ended"""
    answer: str = ""
    """true, false, or what went wrong; of the last call of a stream"""
    count: int = 1
    """how many calls"""


@dataclass(frozen=True)
class Touch:
    """A collision: contact with one thing, until it is left alone for a while."""

    vehicle: str
    thing: str
    ground: bool
    """whether that is the ground, which every vehicle touches that stands"""
    position: Array
    """(3,) m, of the vehicle at first, world ENU"""
    begins: float
    """s, since the session began"""
    ends: float
    """s, last contact"""
    count: int = 1
    """contacts"""


class Calls:
    """The calls of a session, as they come."""

    def __init__(self) -> None:
        self.made: list[Call] = []
        self.passed = 0
        """calls that were not kept, as there were too many"""
        self._latest: dict[str, tuple[int, float]] = {}

    def begin(self, vehicle: str, name: str, arguments: Sequence[Any], time: float) -> Callable[[str, float], None]:
        """Take note of a call at a time (s); return what is to be told its answer, and when that came (s)."""
        place, before = self._latest.get(vehicle, (-1, -math.inf))
        if place >= 0 and self.made[place].name == name and time - before <= STREAM:
            self.made[place] = replace(self.made[place], count=self.made[place].count + 1)
        elif len(self.made) < MOST:
            self.made.append(Call(vehicle, name, described(arguments), time))
            place = len(self.made) - 1
        else:
            self.passed += 1
            return lambda answer, end: None
        self._latest[vehicle] = place, time
        began = time

        def end(answer: str, time: float) -> None:
            self.made[place] = replace(self.made[place], answer=clean(answer), ends=time)
            if answer not in ANSWERS and self._latest.get(vehicle) == (place, began):
                del self._latest[vehicle]

        return end

    def reset(self, time: float) -> None:
        """Take note of a reset at a time (s); it ends all streams."""
        self._latest.clear()
        self.begin("", "reset", (), time)("", time)


class Touches:
    """The collisions of a session, as they come."""

    def __init__(self) -> None:
        self.made: list[Touch] = []
        self.passed = 0
        """collisions that were not kept, as there were too many"""
        self._latest: dict[tuple[str, str], tuple[int, float]] = {}

    def add(self, vehicle: str, thing: str, ground: bool, position: Array, time: float) -> Touch | None:
        """Take note of a contact at a time (s); return the collision where it is a new one."""
        place, before = self._latest.get((vehicle, thing), (-1, -math.inf))
        if time - before <= CONTACT:
            self.made[place] = replace(self.made[place], ends=time, count=self.made[place].count + 1)
            self._latest[vehicle, thing] = place, time
            return None
        if len(self.made) >= MOST:
            self.passed += 1
            return None
        self._latest[vehicle, thing] = len(self.made), time
        self.made.append(Touch(vehicle, thing, ground, position, time, time))
        return self.made[-1]


def described(arguments: Sequence[Any]) -> str:
    """Return the arguments of a move as a short text."""
    return clean(", ".join(map(word, arguments)))


def word(argument: Any) -> str:
    """Return an argument as a short text."""
    match argument:
        case bool():
            return str(argument).lower()
        case float() | int():
            return "∞" if argument > FOREVER else f"{argument:.6g}"
        case YawMode():
            return f"yaw {argument.yaw_or_rate:.6g} {'°/s' if argument.is_rate else '°'}"
        case np.ndarray() if argument.ndim == 2:
            return "1 point" if len(argument) == 1 else f"{len(argument)} points"
        case list() | tuple() | np.ndarray():
            return f"[{', '.join(map(word, argument[:8]))}{', ...' if len(argument) > 8 else ''}]"
    return str(argument)


def clean(text: str) -> str:
    """Return a text that files can hold: no halves of letters, no zeros, not too long."""
    whole = text.encode("utf-8", "replace").decode().replace("\0", "")
    return whole if len(whole) <= LONGEST else whole[: LONGEST - 1] + "…"
