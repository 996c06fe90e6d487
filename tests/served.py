"""A server of AirSim's protocol for tests, in a thread beside them."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.server.serve import Server, simulator_of
from crosstrack.airsim.server.settings import Settings, parse
from crosstrack.mission.airsim import airsim_settings
from crosstrack.mission.mission import Mission
from crosstrack.world.world import World


@contextmanager
def serving(
    world: World | None = None,
    settings: Settings | None = None,
    *,
    lockstep: bool = True,
    ideal: bool = False,
    radius: float = RADIUS,
    clock_speed: float | None = None,
) -> Iterator[Server]:
    """Serve a world, by default without any obstacle, until the block ends."""
    simulator = simulator_of(
        settings or parse("{}"),
        world or World(),
        lockstep=lockstep,
        ideal=ideal,
        radius=radius,
        clock_speed=clock_speed,
    )
    with Server(simulator) as server:
        yield server


@contextmanager
def serving_mission(mission: Mission, *, lockstep: bool = True, clock_speed: float | None = None) -> Iterator[Server]:
    """Serve the world of a mission, with the vehicles that it needs."""
    settings, radius = parse(json.dumps(airsim_settings(mission))), mission.vehicle.radius
    with serving(mission.obstacles, settings, lockstep=lockstep, radius=radius, clock_speed=clock_speed) as server:
        yield server
