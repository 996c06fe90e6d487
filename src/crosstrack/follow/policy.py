"""Follow a path by a learned policy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.policy.flying import Asked, Learned
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
class Policy(Learned):
    """Follow a path as a policy learned to, at the rate and up to the speed it was trained with.

    Over the last 2 m the end of the course is asked for as a position: the policy was not taught to stop.
    """

    task = "follow"
    needs = ()

    file: str = "follow-ppo"
    """an .npz beside the mission, or the name alone of a policy that ships: see `crosstrack list`"""

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
