"""What a served session leaves behind: where vehicles flew, what clients called and drew, what was hit."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from crosstrack import frames
from crosstrack.airsim.scene.markers import Marker, Trace
from crosstrack.airsim.scene.thing import Thing
from crosstrack.airsim.server.simulator import Ended, Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import CollisionInfo
from crosstrack.flight.scene import Scene
from crosstrack.flight.served_calls import MOST, Call, Calls, Touch, Touches, clean, described
from crosstrack.flight.served_log import COLLISIONS, MOVES, SessionLog
from crosstrack.flight.served_track import Rows, Track
from crosstrack.types import Array
from crosstrack.world.world import World

PERIOD = 50_000_000
"""ns of simulated time, between two rows of a track"""
MOST_ROWS = 720_000
"""of all tracks together: ten hours of flight, or an hour of ten vehicles"""
CHUNK = 1_000_000_000
"""ns of simulated time, after which rows are handed to the system: what a killed server loses at most"""
CHANGED = 10_000_000_000
"""ns of simulated time, between two looks at whether the obstacles have changed"""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Session:
    """All that is shown of a session."""

    duration: float
    """s, simulated"""
    tracks: dict[str, Track]
    """by vehicle"""
    calls: tuple[Call, ...]
    touches: tuple[Touch, ...]
    """contacts with things, and with the ground"""
    markers: tuple[Marker, ...]
    """whatever was drawn, for however short a time"""
    traces: dict[str, Trace]
    """by vehicle, how its way is drawn"""
    scene: Scene
    """the obstacles as they were at the end"""
    things: tuple[Thing, ...]
    """the same, by name"""
    notes: tuple[str, ...]
    """what is missing"""

    @property
    def collisions(self) -> list[Touch]:
        """Contacts with anything but the ground."""
        return [touch for touch in self.touches if not touch.ground]


class Recorder:
    """Record a session, from when it is made; the simulator calls it.

    Args:
        simulator: what clients act on
        path: of the log; None for none

    Raises:
        OSError: the log cannot be written.
    """

    def __init__(self, simulator: Simulator, path: Path | None = None) -> None:
        self.simulator, self.begins = simulator, simulator.now
        self.log = None if path is None else SessionLog(path, self.begins)
        self.calls, self.touches = Calls(), Touches()
        self.ended = ""
        """when the tracks ended before the session did; empty where they did not"""
        self._rows: dict[str, Rows] = {}
        self._count = 0
        self._unwritten: dict[str, list[Array]] = {}
        self._felt: dict[str, CollisionInfo] = {}
        self._drawn = 0
        self._world: World | None = None
        self._due = self._flush_due = self._world_due = self.begins
        simulator.observers.append(self.observe)
        simulator.watchers.append(self.watch)
        simulator.resetters.append(self.reset)
        self.observe()

    @property
    def time(self) -> float:
        """s, simulated, since the session began"""
        return (self.simulator.now - self.begins) / 1e9

    def observe(self) -> None:
        """Look at everything that has changed since the last time."""
        now = self.simulator.now
        for vehicle in self.simulator.vehicles.values():
            if vehicle.collision is not self._felt.get(vehicle.name):
                self._felt[vehicle.name] = vehicle.collision
                if vehicle.collision.has_collided:
                    self._touched(vehicle, vehicle.collision)
        if now >= self._due:
            self._due = now - (now - self.begins) % PERIOD + PERIOD
            self._look()
        if self.log is not None and now >= self._flush_due:
            self._flush_due = now + CHUNK
            self._flush()

    def watch(self, vehicle: str, name: str, arguments: Sequence[Any]) -> Ended:
        """Take note of a move."""
        begins = self.time
        end = self.calls.begin(clean(vehicle), name, arguments, begins)
        told = {"vehicle": clean(vehicle), "name": name, "arguments": described(arguments), "begins_s": begins}

        def ended(value: bool | None, error: Exception | None) -> None:
            answer = str(bool(value)).lower() if error is None else clean(str(error))
            end(answer, self.time)
            self._tell(MOVES, told | {"ends_s": self.time, "answer": answer})

        return ended

    def reset(self) -> None:
        """Take note of a reset."""
        time = self.time
        self.calls.reset(time)
        self._tell(MOVES, {"vehicle": "", "name": "reset", "arguments": "", "begins_s": time, "ends_s": time})

    def close(self) -> Session:
        """Write what is left, and return all of it."""
        self.simulator.observers.remove(self.observe)
        self.simulator.watchers.remove(self.watch)
        self.simulator.resetters.remove(self.reset)
        self._look()
        if self.log is not None:
            self._flush()
            self._show_objects()
            self.log.close({"ends": str(self.simulator.now)})
        return self._session()

    def _session(self) -> Session:
        scene = self.simulator.scene
        nothing = np.empty((0, 3))
        return Session(
            self.time,
            {name: rows.track() for name, rows in self._rows.items()},
            tuple(self.calls.made),
            tuple(self.touches.made),
            tuple(scene.markers.drawn),
            {clean(name): trace for name, trace in scene.markers.traces.items()},
            Scene(nothing, nothing, tuple(scene.world.meshes())),
            tuple(scene.things.values()),
            tuple(self._notes()),
        )

    def _notes(self) -> list[str]:
        found = [self.ended] if self.ended else []
        for passed, what in ((self.calls.passed, "calls of moves"), (self.touches.passed, "contacts")):
            if passed:
                found.append(f"The last {passed} {what} are not listed: there were more than {MOST}.")
        if self.simulator.scene.markers.dropped:
            found.append(
                f"The first {self.simulator.scene.markers.dropped} markers are not drawn: there were too many."
            )
        if self.log is not None and self.log.ended:
            found.append(f"The log ends early: {self.log.ended}.")
        return found

    def _look(self) -> None:
        """Take a row of every vehicle."""
        time = self.time
        for vehicle in self.simulator.vehicles.values():
            if self._count >= MOST_ROWS:
                self._end()
                return
            name, q = clean(vehicle.name), vehicle.quadrotor
            position = vehicle.start.position + q.position
            row = np.concatenate([[time], position, q.attitude, q.velocity, q.rate])
            kept = self._rows.setdefault(name, Rows()).add(row)
            self._count += len(kept)
            if kept and self.log is not None:
                self._unwritten.setdefault(name, []).extend(kept)

    def _end(self) -> None:
        if not self.ended:
            self.ended = f"Tracks end at {self.time:.1f} s: they hold {MOST_ROWS} samples, their limit."
            log.warning("%s", self.ended)

    def _touched(self, vehicle: ServedVehicle, contact: CollisionInfo) -> None:
        name, thing = clean(vehicle.name), clean(contact.object_name)
        ground = contact.object_name == self.simulator.scene.floor.name
        position = frames.enu_from_ned(vehicle.start.position + contact.position)
        if self.touches.add(name, thing, ground, position, self.time) is not None:
            at = position.round(4).tolist()
            self._tell(COLLISIONS, {"vehicle": name, "object": thing, "begins_s": self.time, "position_m": at})

    def _tell(self, topic: str, values: dict[str, Any]) -> None:
        if self.log is not None and self.log.open:
            self.log.told(topic, self.simulator.now, values)

    def _flush(self) -> None:
        """Hand rows and markers to the system, and the obstacles where they have changed."""
        assert self.log is not None
        for name, rows in self._unwritten.items():
            self.log.rows(name, rows)
        self._unwritten.clear()
        self.log.flush()
        markers = self.simulator.scene.markers
        fresh = min(len(markers.drawn) + markers.dropped - self._drawn, len(markers.drawn))
        if fresh:
            self.log.drawn(list(islice(reversed(markers.drawn), fresh))[::-1], self.simulator.now)
            self._drawn = len(markers.drawn) + markers.dropped
        if self.simulator.now >= self._world_due:
            self._world_due = self.simulator.now + CHANGED
            self._show_objects()

    def _show_objects(self) -> None:
        world = self.simulator.scene.world
        if self.log is not None and world is not self._world:
            self._world = world
            self.log.objects(world.meshes(), self.simulator.now)
