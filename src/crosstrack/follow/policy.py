"""Follow a path by a learned policy."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import PurePath

import numpy as np

from crosstrack.policy.file import ENDING, from_bytes, load
from crosstrack.policy.flying import Asked, Pilot
from crosstrack.policy.path import AHEAD, AIM, SIZE, write_points
from crosstrack.protocols import Course, Sensor
from crosstrack.types import Array, Command, Setpoint, State
from crosstrack.vectors import norm

REACH = np.array(AHEAD)
STOP = 2.0
"""m, from the end of the course, within which a policy that was not taught to stop is asked no more"""


@dataclass(frozen=True)
class PolicyMemory:
    """What following by a policy remembers."""

    progress: float
    """m, along the course"""
    aim: Array
    """(3,) m, the point that the way leads to"""
    asked: Asked


@dataclass(frozen=True)
class Policy:
    """Follow a path as a policy learned to, at the rate and up to the speed it was trained with.

    Over the last 2 m the end of the course is asked for as a position: the policy was not taught to stop.
    """

    needs = ()

    file: str = "follow-ppo"
    """an .npz beside the mission, or the name alone of a policy that ships: see `crosstrack list`"""

    @property
    def names(self) -> tuple[str, ...]:
        """The file, where it does not ship."""
        return (self.file,) if PurePath(self.file).suffix.lower() == ENDING else ()

    @cached_property
    def pilot(self) -> Pilot:
        """The policy.

        Raises:
            InputError: its file cannot be used.
        """
        return Pilot(self.file, load(self.file), "follow")

    def given(self, files: Mapping[str, bytes]) -> "Policy":
        """Return this with its file read already.

        Raises:
            InputError: its file cannot be used.
        """
        copy = replace(self)
        if self.file in files:
            vars(copy)["pilot"] = Pilot(self.file, from_bytes(self.file, files[self.file]), "follow")
        return copy

    def blind(self, sensors: Sequence[Sensor]) -> str:
        """Say nothing: it needs no sensors."""
        assert self.pilot
        return ""

    def start(self, course: Course, state: State) -> PolicyMemory:
        """Begin at the entry of the course."""
        return PolicyMemory(course.entry, course.path(course.entry), self.pilot.start(state))

    def step(self, memory: PolicyMemory, course: Course, state: State, duration: float) -> tuple[Command, PolicyMemory]:
        """Return the command for the next `duration` (s), and the new memory."""
        path = course.path
        s = path.project(state.position, memory.progress, norm(state.velocity) * duration + 1.0)
        end = path(path.length)
        if path.length - s < STOP:
            return Setpoint(position=end), replace(memory, progress=s, aim=end)
        asked = memory.asked
        points = path(np.minimum(s + REACH, path.length))
        if state.time > asked.due - 0.5 * duration:
            body = np.concatenate([state.position, state.velocity, state.attitude, state.rate])
            seen = np.empty(SIZE, np.float32)
            write_points(seen, 0, body, points)
            asked = self.pilot.decide(asked, state, seen, end)
        return asked.command, PolicyMemory(s, points[AIM], asked)
