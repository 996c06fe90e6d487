"""The seams between the roles. Whatever satisfies one of these plugs in by a line of the registry."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from crosstrack.types import ALONE, Air, Array, Command, Envelope, Limits, Mismatch, Noise, Others, Scan, State, Wind

Field = NDArray[np.float32]
"""distances at the points of a lattice: many"""


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

    def field(self, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
        """Return the distance at the points of a lattice, (counts) m: where it is below `reach`; `reach` elsewhere.

        Args:
            low: (3,) m, the first point
            cell: m, between two points along each axis
            counts: of points along each axis
            reach: m, above zero
        """

    def cast(self, origin: Array, directions: Array, reach: float) -> Array:
        """Return how far (n,) m rays go from a point (3,) along unit vectors (n, 3) until they hit an obstacle.

        inf where that is not within `reach` (m); 0 from inside an obstacle. The ground is no obstacle.
        """


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
    """What a planner is asked for: a trajectory that ends at rest."""

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
    motion: Array = field(default_factory=lambda: np.zeros((2, 3)))
    """(2, 3) m/s and m/s², velocity and acceleration to begin with; a planner that does not `replan` begins at rest"""


class Planner(Protocol):
    """A law that turns waypoints into a trajectory."""

    @property
    def replans(self) -> bool:
        """Whether it finds its own way between the waypoints, from any motion, so that it can be asked in flight."""

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
            Unreachable: obstacles leave no way to a waypoint.
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


@dataclass(frozen=True)
class Surroundings:
    """What a vehicle knows at one instant of what is around it."""

    obstacles: Map
    """what stands still: what it was told of the world, and what it has seen since; the unknown is free"""
    others: Others = ALONE
    """what moves, itself left out"""
    scans: Sequence[Scan] = ()
    """what its sensors have seen since the instant before; `obstacles` has it already"""
    index: int = 0
    """which it is of the vehicles that fly together"""
    count: int = 1
    """how many there are"""


class Deliberation(Protocol):
    """What an avoider remembers from step to step; the loop logs this."""

    @property
    def intervening(self) -> bool:
        """Whether it changed the last command by more than rounding."""


D = TypeVar("D", bound=Deliberation)


class Avoider(Protocol[D]):
    """A law that changes a command so that the vehicle does not hit anything; avoiders form a chain."""

    @property
    def guards(self) -> bool:
        """Whether it is there for safety alone: it takes any kind of command, and changes it only where it must."""

    def start(self, course: Course, around: Surroundings, state: State) -> D:
        """Return the memory to begin with, and to go on with on a new course; one that guards keeps its memory then."""

    def step(
        self, memory: D, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, D]:
        """Return the command to fly instead for the next `duration` (s), and the new memory.

        One that does not guard is only given a `Setpoint`.
        """


@runtime_checkable
class FromFiles(Protocol):
    """A tracker or an avoider that reads files of the mission."""

    @property
    def names(self) -> tuple[str, ...]:
        """The files."""

    def given(self, files: Mapping[str, bytes]) -> Any:
        """Return the part with its files read already.

        Raises:
            InputError: a file cannot be used.
        """

    def blind(self, sensors: "Sequence[Sensor]") -> str:
        """Say why it cannot see with the sensors of a mission; nothing where it can, or need not.

        Raises:
            InputError: a file cannot be used.
        """


class Sensor(Protocol):
    """A kind of sensor: what a mission says of it."""

    @property
    def rate(self) -> float:
        """Hz, scans a second"""

    @property
    def range(self) -> float:
        """m, farther than which it sees nothing"""

    def look(self, world: Map, state: State, random: np.random.Generator) -> Scan:
        """Return what it sees in a world from a true state; the ground of the world is seen too."""


class Traffic(Protocol):
    """Obstacles that move."""

    def at(self, time: float) -> Map:
        """Return them as they stand at a time (s)."""

    def others(self, time: float) -> Others:
        """Return balls that hold them at a time (s), and how they move."""

    def swept(self, start: Array, end: Array, before: float, after: float) -> float:
        """Return the least signed distance (m) to them of a point that goes straight from `start` to `end` (3,) m.

        It leaves at the time `before` and gets there at the time `after` (s).
        """


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
    sensors: Sequence[Sensor] = ()
    """what it sees with"""
    traffic: Traffic | None = None
    """what moves in the world; None where nothing does"""
    name: str = ""
    """of the vehicle, where several fly together"""


class Session(Protocol):
    """One vehicle in flight. It owns its clock, simulated or real."""

    def sense(self) -> State:
        """Return the state as the vehicle estimates it.

        Raises:
            LinkLost: the vehicle no longer answers.
        """

    def truth(self) -> State:
        """Return the true state where the vehicle knows it, the estimate otherwise."""

    def scans(self) -> Sequence[Scan]:
        """Return what its sensors have seen since this was last asked, in order of time."""

    def wind(self) -> Array:
        """Return the wind at the vehicle, (3,) m/s, NaN where not known."""

    def touched(self) -> bool:
        """Return whether the vehicle has hit the ground harder than a landing."""

    def begin(self, command: Command, duration: float) -> None:
        """Take note of the command that `advance` will fly next, so that vehicles with one clock fly theirs together.

        Raises:
            LinkLost: the vehicle no longer answers.
        """

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

    @property
    def stand_in(self) -> "Vehicle":
        """What flies in its place where nothing real may move: itself, where it is simulated."""

    def envelope(self, scenario: Scenario) -> Envelope:
        """Return what it can do in a scenario."""

    def launch(self, scenario: Scenario) -> Session:
        """Put it into the scenario, at rest, ready to be commanded."""

    def arrived(self, before: State, now: State, goal: Array, remaining: float) -> bool:
        """Judge arrival at the last point (3,) m from two states in a row and the path that remains (m)."""
