"""Avoid obstacles by a learned policy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from crosstrack.policy.flying import Asked, Learned
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import Command, NonNegative, Positive, State
from crosstrack.vectors import norm


@dataclass(frozen=True)
class PolicyMemory:
    """What avoidance by a policy remembers."""

    intervening: bool
    course: Course
    progress: float
    """m, along the course"""
    asked: Asked


@dataclass(frozen=True)
class Policy(Learned):
    """Fly what a policy learned to do with what is seen; the course says where to.

    The policy decides at the rate it was trained with. It is led to the point of the course `ahead` from the closest
    one. Within `handover` of its end, the command of the tracker is flown.
    """

    task = "avoid"
    guards = False

    file: str = "avoid-ppo"
    """an .npz beside the mission, or the name alone of a policy that ships: see `crosstrack list`"""
    ahead: Positive = 45.0
    """m, along the course, of the point that the policy is led to"""
    handover: NonNegative = 1.5
    """m, from the end of the course"""

    def blind(self, sensors: Sequence[Any]) -> str:
        """Say why it cannot see with some sensors; nothing where it can."""
        pilot = self.pilot
        for sensor in sensors:
            if ((pilot.beams @ sensor.directions.T).max(axis=1) >= pilot.apart).all():
                return ""
        said = ", ".join(f"{name}: {value}" for name, value in pilot.options["sensor"].items())
        return f"no sensor has the beams that {self.file} was trained with: add {{{said}}}, or a finer one"

    def start(self, course: Course, around: Surroundings, state: State) -> PolicyMemory:
        """Begin at the entry of the course."""
        return PolicyMemory(False, course, course.entry, self.pilot.start(state))

    def step(
        self, memory: PolicyMemory, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, PolicyMemory]:
        """Return the command of the policy for the next `duration` (s), and the new memory."""
        course, pilot = memory.course, self.pilot
        progress = course.path.project(state.position, memory.progress, norm(state.velocity) * duration + 0.5)
        memory = replace(memory, progress=progress, asked=pilot.saw(memory.asked, around.scans))
        if norm(course.path(course.path.length) - state.position) < self.handover:
            return command, replace(memory, intervening=False, asked=replace(memory.asked, due=state.time))
        if state.time > memory.asked.due - 0.5 * duration:
            goal = course.path(min(progress + self.ahead, course.path.length))
            memory = replace(memory, asked=pilot.decide(memory.asked, state, memory.asked.ranges, goal))
        return memory.asked.command, replace(memory, intervening=True)
