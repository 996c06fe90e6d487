"""The tracks of a served session, as they grow and as they are when it is over."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crosstrack import frames
from crosstrack.types import Array

COLUMNS = 14
"""time, position, attitude, velocity, rate"""
BLOCK = 1024
"""rows that room is made for at once"""
JUMP = 1.0
"""m, beyond what its speed explains, from which on a vehicle was moved and did not fly"""


@dataclass(frozen=True)
class Track:
    """How a vehicle moved, world ENU, body FLU."""

    time: Array
    """(n,) s, simulated, since the session began"""
    position: Array
    """(n, 3) m"""
    attitude: Array
    """(n, 4) xyzw"""
    velocity: Array
    """(n, 3) m/s"""
    rate: Array
    """(n, 3) rad/s, body"""

    @cached_property
    def jumps(self) -> NDArray[np.int_]:
        """(k,) the rows to which it was moved without flying there, as a reset does"""
        if len(self.time) < 2:
            return np.empty(0, dtype=int)
        speed = np.linalg.norm(self.velocity, axis=1)
        steps = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        explained = 2.0 * np.maximum(speed[1:], speed[:-1]) * np.diff(self.time)
        return np.flatnonzero(steps > JUMP + explained) + 1

    @property
    def length(self) -> float:
        """m, flown"""
        steps = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        steps[self.jumps - 1] = 0.0
        return float(np.nansum(steps))


def track(rows: Array) -> Track:
    """Return rows (n, 14) of a vehicle, world NED and body FRD, as a track."""
    time, position, attitude, velocity, rate = np.split(rows, [1, 4, 8, 11], axis=1)
    return Track(
        time[:, 0],
        frames.enu_from_ned(position),
        frames.attitude_enu_from_ned(attitude),
        frames.enu_from_ned(velocity),
        frames.flu_from_frd(rate),
    )


class Rows:
    """The rows of one vehicle; of a time that it stands still only the first and the last are kept."""

    def __init__(self) -> None:
        self.count = 0
        self._blocks: list[Array] = []
        self._held: Array | None = None

    def add(self, row: Array) -> list[Array]:
        """Take in a row (14,); return those that are kept now."""
        if self.count and np.array_equal(row[1:], self._last[1:]):
            self._held = row
            return []
        kept = [row] if self._held is None else [self._held, row]
        self._held = None
        for each in kept:
            self._keep(each)
        return kept

    def _keep(self, row: Array) -> None:
        place = self.count % BLOCK
        if place == 0:
            self._blocks.append(np.empty((BLOCK, COLUMNS)))
        self._blocks[-1][place] = row
        self._last = row
        self.count += 1

    def track(self) -> Track:
        """Return all of it."""
        held = np.empty((0, COLUMNS)) if self._held is None else self._held[None]
        whole = np.concatenate([np.empty((0, COLUMNS)), *self._blocks])[: self.count]
        return track(np.concatenate([whole, held]))
