"""A policy in flight: from what a vehicle knows of itself and has seen to a command."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import PurePath
from typing import Any, ClassVar, Self

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.policy import motion, path
from crosstrack.policy.action import KINDS, MOTION_LEVEL, steer
from crosstrack.policy.file import ENDING, from_bytes, load
from crosstrack.policy.network import Floats, Memory
from crosstrack.policy.policy import Policy
from crosstrack.registry import find
from crosstrack.types import Array, AttitudeSetpoint, Command, Scan, Setpoint, State

NEEDED = ("speed", "period", "action")
"""Options that must be on the card of such a policy."""


@dataclass(frozen=True)
class Asked:
    """What a policy in flight remembers."""

    command: Command
    """held until the next decision"""
    due: float
    """s, time of that"""
    asked: Array
    """(4,) see `crosstrack.policy.action`"""
    ranges: Floats
    """(beams,) over the range of the policy, as last seen; 1 where nothing is in the way"""
    network: Memory
    """of the network"""


class Pilot:
    """A policy with what its card says of seeing and acting."""

    def __init__(self, name: str, policy: Policy, task: str) -> None:
        """Check the card.

        Args:
            name: of the file, for messages
            policy: to fly
            task: that it must be trained for

        Raises:
            InputError: it was trained for another task, or its card lacks an option.
        """
        card, found = policy.card, list[Problem]()
        if card.task != task:
            found.append(Problem("task", f"must be {task} to be flown here, found {card.task}"))
        needed = NEEDED + (("sensor", "range") if task == "avoid" else ())
        found += [Problem(f"options.{word}", "is required") for word in needed if word not in card.options]
        if not found and card.options["action"] not in KINDS:
            found.append(Problem("options.action", f"must be one of {', '.join(KINDS)}"))
        if found:
            raise InputError(name, found)
        self.name, self.policy, self.options = name, policy, card.options
        self.kind = KINDS[card.options["action"]]
        self.speed, self.period = float(card.options["speed"]), float(card.options["period"])
        if self.seen != card.observation.size:
            message = f"must be {self.seen}, what is seen in flight; found {card.observation.size}"
            raise InputError(name, [Problem("observation.size", message)])

    @property
    def seen(self) -> int:
        """Numbers of an observation."""
        return motion.SIZE + (path.SIZE if self.policy.card.task == "follow" else len(self.beams))

    @cached_property
    def beams(self) -> Array:
        """(beams, 3) unit vectors in the body, along which it wants ranges."""
        if "sensor" not in self.options:
            return np.empty((0, 3))
        said = dict(self.options["sensor"])
        try:
            made: Any = find("sensor", said.pop("kind", ""))(**said)
            beams: Array = made.directions
        except (TypeError, ValueError, AttributeError) as error:
            raise InputError(self.name, [Problem("options.sensor", f"is no sensor: {error}")]) from None
        return beams

    @cached_property
    def apart(self) -> float:
        """Cosine of the half of the angle between two beams: as near another beam must be to stand for one."""
        if len(self.beams) < 2:
            return 0.0
        return math.cos(0.5 * math.acos(min(1.0, float(self.beams[0] @ self.beams[1]))) + 1e-3)

    def start(self, state: State) -> Asked:
        """Return the memory to begin with: at rest, seeing nothing."""
        _, _, z, w = state.attitude
        asked = np.array([0.0, 0.0, 0.0, 2 * math.atan2(z, w)])
        clear = np.ones(len(self.beams), np.float32)
        return Asked(Setpoint(velocity=np.zeros(3)), state.time, asked, clear, self.policy.start())

    def saw(self, memory: Asked, scans: Sequence[Scan]) -> Asked:
        """Return the memory with what scans show along the beams."""
        ranges = memory.ranges
        for scan in scans:
            if len(scan.directions) == 0:
                continue
            if scan.directions.shape == self.beams.shape and np.array_equal(scan.directions, self.beams):
                found = scan.ranges
            else:
                near = self.beams @ scan.directions.T
                best = near.argmax(axis=1)
                covered = near[np.arange(len(best)), best] >= self.apart
                if not covered.any():
                    continue
                found = np.where(covered, scan.ranges[best], np.inf)
            share = np.nan_to_num(found, nan=np.inf) / self.options["range"]
            ranges = np.minimum(share, 1.0).astype(np.float32)
        return memory if ranges is memory.ranges else replace(memory, ranges=ranges)

    def decide(self, memory: Asked, state: State, before: Floats, goal: Array) -> Asked:
        """Return the memory with the command of the next decision.

        Args:
            memory: from the step before
            state: as estimated
            before: what is seen beside the motion
            goal: (3,) m
        """
        body = np.concatenate([state.position, state.velocity, state.attitude, state.rate])
        observation = np.empty(self.seen, np.float32)
        observation[: len(before)] = before
        motion.write(observation, len(before), body, goal, memory.asked, self.speed)
        action, network = self.policy.decide(observation, memory.network)
        numbers = np.atleast_1d(np.asarray(action, dtype=float))
        asked, command = memory.asked.copy(), np.empty(11)
        level = steer(self.kind, numbers, body, self.speed, self.period, asked, command)
        told: Command
        if level == MOTION_LEVEL:
            told = Setpoint(velocity=command[3:6].copy(), yaw=float(command[9]))
        else:
            told = AttitudeSetpoint(command[:4].copy(), float(command[4]))
        return replace(memory, command=told, due=memory.due + self.period, asked=asked, network=network)


@dataclass(frozen=True)
class Learned:
    """A part of a mission that a policy flies."""

    task: ClassVar[str]
    """that the policy must be trained for"""

    file: str
    """an .npz beside the mission, or the name alone of a policy that ships"""

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
        return Pilot(self.file, load(self.file), self.task)

    def given(self, files: Mapping[str, bytes]) -> Self:
        """Return this with its file read already.

        Raises:
            InputError: its file cannot be used.
        """
        if self.file not in files:
            return self
        copy = replace(self)
        vars(copy)["pilot"] = Pilot(self.file, from_bytes(self.file, files[self.file]), self.task)
        return copy
