"""The server as a whole: a simulator, its handlers, and the socket."""

import asyncio
import json
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Self

import numpy as np

from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.firmware.rows import ARMED, DISARMED
from crosstrack.airsim.scene.cameras.settings import IMAGE_TYPES
from crosstrack.airsim.scene.images import Kind
from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.server.clock import Clock
from crosstrack.airsim.server.dispatch import Dispatcher
from crosstrack.airsim.server.handlers import HANDLERS, recording
from crosstrack.airsim.server.settings import Settings, parse
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.transport import Listener
from crosstrack.airsim.structs import ImageRequest
from crosstrack.world.world import World

EVERY_SENSOR = {
    "Vehicles": {
        "Warm": {
            "VehicleType": "SimpleFlight",
            "Sensors": {"Ray": {"SensorType": 5, "Enabled": True}, "Rays": {"SensorType": 6, "Enabled": True}},
        }
    }
}
STARTING = 60.0
"""s that a server may take to start aside"""


def simulator_of(
    settings: Settings,
    world: World | None = None,
    *,
    clock_speed: float | None = None,
    lockstep: bool = False,
    ideal: bool = False,
    seed: int = 1,
    radius: float = RADIUS,
) -> Simulator:
    """Return what a server simulates.

    Args:
        settings: of AirSim
        world: to fly in; None for one of our own
        clock_speed: simulated over wall time; that of the settings by default
        lockstep: whether the clock advances only as clients ask
        ideal: whether to fly without AirSim's known mistakes
        seed: of the noise of sensors
        radius: m, of the ball that a vehicle is to others and to obstacles
    """
    wind = (settings.wind.x, settings.wind.y, settings.wind.z)
    clock = Clock(settings.clock_speed if clock_speed is None else clock_speed, lockstep)
    simulator = Simulator(Scene(world, radius), clock, settings.origin, wind, ideal, seed, settings)
    for name, vehicle in settings.fleet().items():
        armed = DISARMED if vehicle.default_vehicle_state == "Disarmed" else ARMED
        simulator.add_vehicle(name, vehicle.start, armed, vehicle)
    recording.prepare(simulator)
    return simulator


@cache
def warm_up() -> None:
    """Compile what a flight needs, once, in a simulation that is thrown away, so that no client waits for it."""
    simulator = simulator_of(parse(json.dumps(EVERY_SENSOR)), lockstep=True)
    simulator.idle(0.1)
    for kind in ("Imu", "Barometer", "Magnetometer", "Gps", "DistanceSensor", "Lidar"):
        HANDLERS[f"get{kind}Data"](simulator, "", "")
    requests = [
        ImageRequest("0", kind, kind not in {Kind.SCENE, Kind.SEGMENTATION}, False) for kind in range(IMAGE_TYPES)
    ]
    HANDLERS["simGetImages"](simulator, requests, "", False)
    world, here, there = simulator.scene.world, np.zeros(3), np.ones(3)  # what a first contact needs
    world.distance(here)
    world.gradient(here)
    world.swept(here, there)


async def serve(simulator: Simulator, host: str, port: int, ready: Callable[[int], None]) -> None:
    """Serve clients until cancelled; call `ready` with the port once they can connect.

    Raises:
        InputError: nothing can listen there.
    """
    listener = Listener(Dispatcher(simulator, HANDLERS).dispatch)
    ready(await listener.open(host, port))
    try:
        await simulator.run()
    finally:
        recording.stop(simulator)
        await listener.close()


class Server:
    """A server in a thread of its own, for as long as a `with` block lasts.

    Args:
        simulator: see `simulator_of`
        host: address to listen at
        port: 0 for a free one
    """

    def __init__(self, simulator: Simulator, host: str = "127.0.0.1", port: int = 0) -> None:
        self.simulator, self.host, self.port = simulator, host, port
        self.thread = threading.Thread(target=self.run, name="airsim server", daemon=True)
        self.started = threading.Event()
        self.failure: Exception | None = None

    def run(self) -> None:
        """Serve until stopped."""
        try:
            asyncio.run(self.main())
        except Exception as error:  # raised where the server was started
            self.failure = error
        finally:
            self.started.set()

    async def main(self) -> None:
        """Serve until stopped."""
        self.loop = asyncio.get_running_loop()
        self.serving = asyncio.ensure_future(serve(self.simulator, self.host, self.port, self.ready))
        with suppress(asyncio.CancelledError):
            await self.serving

    def ready(self, port: int) -> None:
        """Take down where it listens."""
        self.port = port
        self.started.set()

    def __enter__(self) -> Self:
        """Start, and return when clients can connect.

        Raises:
            InputError: nothing can listen there.
        """
        warm_up()
        self.thread.start()
        self.started.wait(STARTING)
        if self.failure is not None:
            raise self.failure
        return self

    def __exit__(self, *_: object) -> None:
        """Stop, and wait for the end."""
        if self.thread.is_alive():
            self.loop.call_soon_threadsafe(self.serving.cancel)
        self.thread.join()
        if self.failure is not None:
            raise self.failure
