"""What `crosstrack serve` does."""

import asyncio
import json
import logging
from pathlib import Path

from crosstrack import mission as missions
from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.server import settings as airsim
from crosstrack.airsim.server.serve import serve as served
from crosstrack.airsim.server.serve import simulator_of, warm_up
from crosstrack.cli.verbs import announce
from crosstrack.cli.watch import say
from crosstrack.errors import InputError, Problem
from crosstrack.mission.airsim import airsim_settings

SLOWEST, FASTEST = 0.01, 1000.0
"""times real time"""


def serve(
    settings: Path | None,
    world: Path | None,
    host: str | None,
    port: int | None,
    clock_speed: float | None,
    lockstep: bool,
    ideal: bool,
    seed: int,
) -> int:
    """Serve AirSim's protocol until interrupted."""
    check(port, clock_speed, seed)
    mission = missions.load(world) if world is not None else None
    given = read(settings, mission)
    obstacles = None if mission is None else mission.obstacles
    announce("Getting ready", "airsim")
    warm_up(obstacles)
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
    address = host or given.address
    number = given.api_server_port if port is None else port

    def ready(found: int) -> None:
        names = ", ".join(simulator.vehicles)
        pace = "in lockstep with its clients" if lockstep else f"at {simulator.clock.speed:g} times real time"
        say(f"Serving AirSim's API at {address}:{found}, {pace}: {names}. Ctrl-C ends it.")

    asyncio.run(served(simulator, address, number, ready))
    return 0


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
