"""Flights made without a simulator, of a vehicle that slides along a given curve; and short flights to run as tasks."""

import gc
import os
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

import crosstrack as ct
from crosstrack.campaign.grid import grid
from crosstrack.campaign.task import Task
from crosstrack.flight.effort import Effort
from crosstrack.flight.flight import Flight
from crosstrack.flight.plan import Plan
from crosstrack.flight.record import Record
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope, Outcome

# In the background of a shell Ctrl-C is ignored, and so it would be by all that the tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
# Compiling makes many objects, of which few are garbage: looking for it less often saves a tenth of the time.
gc.set_threshold(20_000, 20, 20)
# Compilation makes first examples slow; a shared machine runs the same examples every time.
settings.register_profile("crosstrack", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("crosstrack")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--fail-on-skip", action="store_true", help="let the run fail if any test was skipped")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter and session.config.getoption("fail_on_skip") and reporter.stats.get("skipped"):
        reporter.write_line("some tests were skipped, and --fail-on-skip was given", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@dataclass(frozen=True)
class Steady:
    """The same speed everywhere."""

    speed: float
    length: float

    @property
    def duration(self) -> float:
        return self.length / self.speed

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        return np.full(np.shape(s), self.speed if order == 0 else 0.0)


@dataclass(frozen=True)
class Room:
    """A world of given meshes."""

    obstacles: tuple[tuple[str, Array, Any], ...] = ()

    def meshes(self) -> list[tuple[str, Array, Any]]:
        return list(self.obstacles)


CUBE = (
    "box",
    np.array([[x, y, z] for x in (8.0, 12.0) for y in (8.0, 12.0) for z in (0.0, 8.0)]),
    np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
         [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    ),
)  # fmt: skip
EFFORT = Effort(flying=0.4, planning=0.02, decision=1e-4, decision_worst=2e-4)
SQUARE = np.array([[0, 0, 10], [20, 0, 10], [20, 20, 10], [0, 20, 10], [0, 0, 10]], dtype=float)


def make_plan(route: Array, name: str = "square", speed: float = 5.0, obstacles: Any = (CUBE,)) -> Plan:
    path = Polyline(route)
    envelope = Envelope(speed=12.0, speed_vertical=4.0, acceleration=8.0, acceleration_vertical=4.0, response_time=0.2)
    stand_in: Any = SimpleNamespace(world=Room(obstacles), traffic=None)
    none: Any = None
    return Plan(
        name=name,
        document={"name": name, "route": np.asarray(route).tolist(), "speed": speed, "seed": 1},
        route=path,
        course=Course(path, Steady(speed, path.length), envelope),
        vehicle=none,
        tracker=none,
        scenario=stand_in,
        timeout=300.0,
        files={"map.png": b"\x89PNG not really"},
    )


def make_record(time: Array, position: Array, progress: Array, rotors: int = 4, clearance: float = 4.0) -> Record:
    count = len(time)
    velocity = np.gradient(position, time, axis=0)
    acceleration = np.gradient(velocity, time, axis=0)
    tilt = np.clip(acceleration / 9.81, -0.5, 0.5) / 2
    attitude = np.column_stack([-tilt[:, 1], tilt[:, 0], np.zeros(count), np.ones(count)])
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    left_open = np.full((count, 3), np.nan)
    return Record(
        time=time,
        position=position,
        velocity=velocity,
        attitude=attitude,
        rate=np.zeros((count, 3)),
        rotor_speeds=600 + 20 * np.sin(time[:, None] * np.arange(1, rotors + 1)),
        estimate=position + 0.01 * np.sin(7 * time)[:, None],
        command_velocity=velocity,
        command_acceleration=left_open,
        command_attitude=np.full((count, 4), np.nan),
        command_rate=0.5 * acceleration,
        command_thrust=9.81 + acceleration[:, 2],
        aim=position + 0.3 * velocity,
        progress=progress,
        wind=np.tile([1.0, -0.5, 0.0], (count, 1)),
        clearance=np.full(count, clearance),
        separation=np.full(count, np.inf),
        interventions=np.zeros(count),
    )


def make_flight(duration: float = 16.0, rate: float = 50.0, name: str = "square", wiggle: float = 0.1) -> Flight:
    """Fly a 20 m square with a sideways swing (m)."""
    plan = make_plan(SQUARE, name)
    time = np.arange(round(duration * rate) + 1) / rate
    progress = plan.route.length * time / time[-1]
    position = plan.route(progress) + wiggle * np.sin(2 * time)[:, None] * np.array([0.5, 0.5, 0.7])
    return Flight(plan, Outcome.ARRIVED, make_record(time, position, progress), EFFORT)


@pytest.fixture
def flight() -> Flight:
    return make_flight()


@pytest.fixture
def fly_square() -> Callable[..., Flight]:
    return make_flight


@pytest.fixture
def fly_along() -> Callable[..., Flight]:
    """Return a way to make a flight of a route, times and positions."""

    def fly(route: Array, time: Array, position: Array, progress: Array, **options: Any) -> Flight:
        plan = make_plan(route, obstacles=())
        return Flight(plan, Outcome.ARRIVED, make_record(time, position, progress, **options), EFFORT)

    return fly


@pytest.fixture(scope="session")
def hop() -> ct.Mission:
    """Return a short mission, noisy so that seeds matter."""
    return ct.loads(
        "{name: hop, start: {position: [0, 0, 5]}, route: [[6, 0], [6, 6]], speed: 3, timing: {timeout: 30},"
        " noise: {position: 0.01}}"
    )


@pytest.fixture(scope="session")
def tasks(hop: ct.Mission) -> list[Task]:
    """Return flights of it in two winds, and of a mission with a file."""
    rooms = ct.load(Path(__file__).parents[1] / "examples" / "rooms.yaml", ["timing.timeout=3"])
    varied = grid([hop], ["mission", "carrot:lookahead=2"], ["calm", "1,0,0,light"], 2)
    return [*varied, *grid([rooms], ["carrot"], ["calm"])]
