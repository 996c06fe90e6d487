"""What `crosstrack serve` does."""

import asyncio
import json
import logging
import os
import signal
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from types import FrameType

from crosstrack import mission as missions
from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.server import settings as airsim
from crosstrack.airsim.server.serve import serve as served
from crosstrack.airsim.server.serve import simulator_of, warm_up
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.cli.codes import DONE, INTERRUPTED
from crosstrack.cli.verbs import announce, made
from crosstrack.cli.watch import say
from crosstrack.errors import InputError, Problem
from crosstrack.flight.served import Recorder
from crosstrack.mission.airsim import airsim_settings

SLOWEST, FASTEST = 0.01, 1000.0
"""times real time"""
LOG, REPORT = "session.mcap", "report.html"
ENDINGS = (signal.SIGINT, signal.SIGTERM)


def serve(
    settings: Path | None,
    world: Path | None,
    host: str | None,
    port: int | None,
    clock_speed: float | None,
    lockstep: bool,
    ideal: bool,
    seed: int,
    out: Path | None,
) -> int:
    """Serve AirSim's protocol until told to end, and write what the session leaves behind."""
    check(port, clock_speed, seed)
    mission = missions.load(world) if world is not None else None
    given = read(settings, mission)
    obstacles = None if mission is None else mission.obstacles
    announce("Getting ready", "airsim")
    warm_up()
    simulator = simulator_of(
        given,
        obstacles,
        clock_speed=clock_speed,
        lockstep=lockstep,
        ideal=ideal,
        seed=seed,
        radius=RADIUS if mission is None else mission.vehicle.radius,
    )
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    number = given.api_server_port if port is None else port
    title = "AirSim session" if mission is None else f"AirSim session in {mission.name}"
    with Ending() as ending, ExitStack() as recording:

        def begin() -> None:
            if out is not None:
                recorder = Recorder(simulator, emptied(out) / LOG)
                recording.callback(write, recorder, out, title)

        asyncio.run(until(ending, simulator, host or given.address, number, begin))
    return DONE


def emptied(folder: Path) -> Path:
    """Make a folder, without the results of an earlier session."""
    made(folder)
    for name in (LOG, REPORT):
        (folder / name).unlink(missing_ok=True)
    return folder


def write(recorder: Recorder, folder: Path, title: str) -> None:
    """Write the end of the log, and the report."""
    from crosstrack.show.served_page import served_page

    session = recorder.close()
    served_page(session, folder / REPORT, title)
    for note in session.notes:
        say(f"note: {note}")
    say(f"{folder / LOG} and {folder / REPORT} are written.")


async def until(ending: "Ending", simulator: Simulator, host: str, port: int, begin: Callable[[], None]) -> None:
    """Serve until told to end; `begin` is called once clients can connect."""

    def ready(found: int) -> None:
        begin()
        clock, names = simulator.clock, ", ".join(simulator.vehicles)
        pace = "in lockstep with its clients" if clock.lockstep else f"at {clock.speed:g} times real time"
        say(f"Serving AirSim's API at {host}:{found}, {pace}: {names}. Ctrl-C ends it.")

    serving = asyncio.ensure_future(served(simulator, host, port, ready))
    ending.then(asyncio.get_running_loop(), serving)
    with suppress(asyncio.CancelledError):
        await serving


class Ending:
    """End the server at the first Ctrl-C or SIGTERM, and the process at the second."""

    def __init__(self) -> None:
        self.asked = False
        self.stop: Callable[[], object] | None = None

    def __enter__(self) -> "Ending":
        self.previous = [signal.signal(number, self.note) for number in ENDINGS]
        return self

    def __exit__(self, *reason: object) -> None:
        for number, handler in zip(ENDINGS, self.previous, strict=True):
            signal.signal(number, handler)

    def then(self, loop: asyncio.AbstractEventLoop, serving: "asyncio.Future[None]") -> None:
        """Say what to end."""
        self.stop = lambda: loop.call_soon_threadsafe(serving.cancel)
        if self.asked:
            serving.cancel()

    def note(self, number: int, frame: FrameType | None) -> None:
        """End the server, or break off."""
        if self.asked:
            say("interrupted")
            os._exit(INTERRUPTED)
        self.asked = True
        say("Ending ...")
        if self.stop is not None:
            self.stop()


def check(port: int | None, clock_speed: float | None, seed: int) -> None:
    """Check the flags.

    Raises:
        InputError: everything that is wrong with them.
    """
    problems = []
    if port is not None and not 0 <= port <= 65535:
        problems.append(Problem("--port", f"must be from 0, any free one, to 65535; found {port}"))
    if clock_speed is not None and not SLOWEST <= clock_speed <= FASTEST:
        problems.append(Problem("--clock-speed", f"must be from {SLOWEST} to {FASTEST:g}; found {clock_speed:g}"))
    if seed < 0:
        problems.append(Problem("--seed", f"must not be negative; found {seed}"))
    if problems:
        raise InputError("serve", problems)


def read(settings: Path | None, mission: missions.Mission | None) -> airsim.Settings:
    """Return the settings of a file, else those that a mission needs, else AirSim's own."""
    if settings is not None:
        return airsim.read(settings)
    if mission is not None:
        return airsim.parse(json.dumps(airsim_settings(mission), indent=2), mission.name)
    return airsim.parse("{}")
