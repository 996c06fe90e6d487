"""The seams between the roles. Whatever satisfies one of these plugs in by a line of the registry."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeVar

import numpy as np

from crosstrack.types import Air, Array, Command, Envelope, Limits, Mismatch, Noise, Scan, State, Wind


class Path(Protocol):
    """A curve in space by arc length."""

    @property
    def length(self) -> float:
        """m"""

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (m, shape (...)): point, unit tangent or curvature vector for order 0, 1, 2.

        Returns:
            shape (..., 3); m, 1 or 1/m. Outside [0, length] the ends answer.
        """

    def project(self, point: Array, near: float, reach: float) -> float:
        """Return the arc length in [near, near + reach] of the point of the path closest to `point`.

        Local and ahead only, so that crossing, closed and reversing paths do not jump.
        """


class Trajectory(Protocol):
    """A curve in space by time."""

    @property
    def duration(self) -> float:
        """s"""

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate at the time `t` (s, shape (...)): position or its derivative of an order.

        Returns:
            shape (..., 3); m/s^order. Outside [0, duration] the ends answer.
        """


class Map(Protocol):
    """What is in the way, as a signed distance."""

    @property
    def ground(self) -> float:
        """m, height of the ground, which is no obstacle"""

    @property
    def bounds(self) -> Array | None:
        """(2, 3) m, lowest and highest corner of the space that may be flown, which are no obstacle"""

    @property
    def optimism(self) -> float:
        """m, by which the distance may exceed the true one"""

    def distance(self, points: Array) -> Array:
        """Return the signed distance from `points` (..., 3) to the nearest obstacle, (...), m; inf without any.

        1-Lipschitz, negative inside.
        """

    def gradient(self, points: Array) -> Array:
        """Return the gradient of the distance, (..., 3): away from the nearest obstacle; zero without any."""

    def swept(self, start: Array, end: Array) -> float:
        """Return the least signed distance along the straight segment between two points (3,), m."""


class Speed(Protocol):
    """A speed for every point of a path."""

    @property
    def duration(self) -> float:
        """s, time of flight from end to end at this speed"""

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (...): speed (m/s) or acceleration along the path (m/s²) for order 0, 1."""


@dataclass(frozen=True)
class Course:
    """What a path follower follows: a smooth path, how fast to fly it, and what the vehicle can do."""

    path: Path
    speed: Speed
    envelope: Envelope
    entry: float = 0.0
    """m, arc length where the flight begins"""
    trajectory: Trajectory | None = None
    """the same as a function of time; None where only the path is planned"""
    corners: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the waypoints asked for, for laws that fly from one to the next"""


@dataclass(frozen=True)
class PlanningTask:
    """What a planner is asked for: a trajectory from rest to rest."""

    waypoints: Array
    """(n, 3) m, at least two, no two in a row the same: where it begins, what it leads through, where it ends"""
    speed: float
    """m/s, cruise: the fastest it may be"""
    tolerance: float
    """m, that the mission allows to either side of the straight legs"""
    envelope: Envelope
    """what the vehicle can do, less what is left to its tracker"""
    world: Map
    radius: float
    """m, of the vehicle"""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """contents of the files that the planner names"""


class Planner(Protocol):
    """A law that turns waypoints into a trajectory."""

    @property
    def names(self) -> tuple[str, ...]:
        """The files that it reads."""

    def allowed(self, tolerance: float) -> float | None:
        """Return how far (m) from the straight legs its trajectories may be at most; None where they may be anywhere.

        Args:
            tolerance: m, of the mission
        """

    def plan(self, task: PlanningTask) -> Trajectory:
        """Return the trajectory.

        Raises:
            InputError: a file of its own cannot be used.
            Infeasible: no trajectory keeps within what is asked for, with where and why.
        """


class Memory(Protocol):
    """What a tracker remembers from step to step; the loop logs these two."""

    @property
    def progress(self) -> float:
        """m, arc length along the course reached so far"""

    @property
    def aim(self) -> Array:
        """(3,) m, the point being chased"""


Need = Literal["trajectory", "attitude"]
M = TypeVar("M", bound=Memory)


class Tracker(Protocol[M]):
    """A law that turns where the vehicle is into what to command: parameters inside, memory passed."""

    @property
    def needs(self) -> Collection[Need]:
        """What must be there beyond a path: a trajectory to follow, a vehicle that takes attitudes and rates."""

    def start(self, course: Course, state: State) -> M:
        """Return the memory to begin with."""

    def step(self, memory: M, course: Course, state: State, duration: float) -> tuple[Command, M]:
        """Return the command to hold for the next `duration` (s), and the new memory."""


class Avoider(Protocol):
    """A law that changes a command so that the vehicle does not hit anything; avoiders form a chain."""

    def start(self, course: Course, known: Map, state: State) -> Any:
        """Return the memory to begin with; `known` is what the vehicle is told of the world before it flies."""

    def step(
        self, memory: Any, command: Command, state: State, scan: Scan | None, duration: float
    ) -> tuple[Command, Any]:
        """Return the command to fly instead, and the new memory."""


EXACT = Mismatch()


@dataclass(frozen=True)
class Scenario:
    """What a vehicle is put into when it is launched."""

    position: Array
    """(3,) m, world; where it starts, at rest"""
    yaw: float
    """rad"""
    world: Map
    cruise: float
    """m/s, the speed the mission asks for"""
    limits: Limits
    wind: Wind
    air: Air
    noise: Noise
    period: float
    """s, between two commands"""
    seed: int
    mismatch: Mismatch = EXACT


class Session(Protocol):
    """One vehicle in flight. It owns its clock, simulated or real."""

    def sense(self) -> State:
        """Return the state as the vehicle estimates it.

        Raises:
            LinkLost: the vehicle no longer answers.
        """

    def truth(self) -> State:
        """Return the true state where the vehicle knows it, the estimate otherwise."""

    def wind(self) -> Array:
        """Return the wind at the vehicle, (3,) m/s, NaN where not known."""

    def touched(self) -> bool:
        """Return whether the vehicle has hit the ground harder than a landing."""

    def advance(self, command: Command, duration: float) -> None:
        """Fly a command for a time (s).

        Raises:
            LinkLost: the vehicle no longer answers.
        """

    def close(self) -> None:
        """Leave the vehicle safe."""


class Vehicle(Protocol):
    """A kind of vehicle: what a mission says of it."""

    @property
    def radius(self) -> float:
        """m, of the sphere that must stay free"""

    def envelope(self, scenario: Scenario) -> Envelope:
        """Return what it can do in a scenario."""

    def launch(self, scenario: Scenario) -> Session:
        """Put it into the scenario, at rest, ready to be commanded."""

    def arrived(self, before: State, now: State, goal: Array, remaining: float) -> bool:
        """Judge arrival at the last point (3,) m from two states in a row and the path that remains (m)."""
