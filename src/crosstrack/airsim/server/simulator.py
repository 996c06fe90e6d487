"""The simulator behind the server: vehicles, the clock that drives them, and the scene that they fly in.

One thread and one asyncio loop serve clients and simulate: a handler is never interrupted by a step. Between two looks
of a move the vehicles fly in one compiled call, 21 ms at most; then contacts are looked for, as AirSim does when it
renders.
"""

import asyncio
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from crosstrack.airsim.firmware import rows as table
from crosstrack.airsim.firmware.kernel import fly
from crosstrack.airsim.firmware.quadrotor import Quadrotor
from crosstrack.airsim.firmware.rows import ARMED
from crosstrack.airsim.server.clock import Clock
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.task import NEVER
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import Pose
from crosstrack.frames import Origin
from crosstrack.types import Array

Ended = Callable[[bool | None, Exception | None], None]
"""told what a move answers, or what it raised"""
Watcher = Callable[[str, str, Sequence[Any]], Ended]
"""told the vehicle, the name and the arguments of a move that begins"""
BATCH = 7
"""steps flown at once: the first that reaches the 20 ms of a move's look"""
TURN = 5e-4
"""s of wall time, after which clients get their turn"""
ABSENT = (
    "Vehicle {kind} for '{name}' is not available. "
    "This could either because this is simulation-only API or this vehicle does not exist"
)


class Simulator:
    """Everything that clients of one server act on.

    Args:
        scene: what is there
        clock: simulated time
        origin: the place on the earth of the world's origin
        wind: (3,) m/s, NED, the velocity of the air
        ideal: whether to fly without AirSim's known mistakes
        seed: of the noise of sensors
        settings: of the server, for handlers that tell of them
    """

    def __init__(
        self,
        scene: Any,
        clock: Clock | None = None,
        origin: Origin | None = None,
        wind: tuple[float, float, float] = (0.0, 0.0, 0.0),
        ideal: bool = False,
        seed: int = 0,
        settings: Any = None,
    ) -> None:
        self.scene, self.settings, self.ideal = scene, settings, ideal
        self.clock, self.origin = clock or Clock(), origin or Origin()
        self.wind: Array = np.array(wind, float)
        self.push: Array = np.zeros(3)
        """(3,) N, NED, a force on every vehicle"""
        self.rng = np.random.default_rng(seed)
        self.rows: Any = table.blank(0)
        self.vehicles: dict[str, ServedVehicle] = {}
        self.observers: list[Callable[[], None]] = []
        """called after every batch of steps"""
        self.resetters: list[Callable[[], None]] = []
        """called at a reset, once the vehicles are back at their starts"""
        self.watchers: list[Watcher] = []
        """called when a client's move begins; what they return, when it ends"""
        self._runs: list[asyncio.Future[None]] = []
        self._stirred: asyncio.Event | None = None

    @property
    def now(self) -> int:
        """ns, simulated"""
        return self.clock.now

    def add_vehicle(self, name: str, start: Pose, armed: int = ARMED, settings: Any = None) -> ServedVehicle:
        """Put one more vehicle at its start, world NED."""
        rows = table.blank(len(self.rows) + 1)
        rows[:-1] = self.rows
        rows["ideal"] = self.ideal
        self.rows = rows
        for index, vehicle in enumerate(self.vehicles.values()):
            vehicle.quadrotor.bind(rows, index)
        quadrotor = Quadrotor(rows, len(rows) - 1)
        vehicle = ServedVehicle(name, quadrotor, start, self.origin, self.clock, armed, settings)
        self.vehicles[name] = vehicle
        return vehicle

    def vehicle(self, name: str) -> ServedVehicle:
        """Return the vehicle of a name, the first one for no name.

        Raises:
            Refused: there is none of that name, in the words of the calls that fly.
        """
        return self._find(name, "API")

    def pawn(self, name: str) -> ServedVehicle:
        """Return the vehicle of a name, the first one for no name.

        Raises:
            Refused: there is none of that name, in the words of the calls that simulate.
        """
        return self._find(name, "Sim-API")

    def _find(self, name: str, kind: str) -> ServedVehicle:
        found = self.vehicles.get(name)
        if found is None and name == "":
            found = next(iter(self.vehicles.values()), None)
        if found is None:
            raise Refused(ABSENT.format(kind=kind, name=name))
        return found

    def begin(
        self, vehicle: ServedVehicle, move: Move, name: str = "", arguments: Sequence[Any] = ()
    ) -> "asyncio.Future[bool]":
        """Start a move in place of the one under way; return its answer to come."""
        answer: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        told = [watch(vehicle.name, name, arguments) for watch in self.watchers]

        def done(value: bool | None, error: Exception | None) -> None:
            for tell in told:
                tell(value, error)
            if answer.done():
                return
            if error is not None:
                answer.set_exception(error)
            else:
                answer.set_result(bool(value))

        vehicle.slot.begin(move, self.now, done)
        self._stir()
        return answer

    def reset(self) -> None:
        """Put every vehicle back to where it started, with whatever it does cancelled; the clock goes on."""
        for vehicle in self.vehicles.values():
            vehicle.reset()
        for call in self.resetters:
            call()

    def pause(self, on: bool) -> None:
        """Stop the clock, or let it run."""
        self.clock.pause(on)
        self._settle()
        self._stir()

    def run_for(self, seconds: float) -> "asyncio.Future[None]":
        """Let the clock run for a time and pause then; return when that is to come."""
        self.clock.run_for(seconds)
        done: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._runs.append(done)
        self._settle()
        self._stir()
        return done

    def fly(self, vehicle: ServedVehicle, move: Move) -> bool:
        """Fly a move to its end at once; return its answer."""
        answers: list[tuple[bool | None, Exception | None]] = []
        vehicle.slot.begin(move, self.now, lambda value, error: answers.append((value, error)))
        while not answers:
            self._batch(BATCH)
        value, error = answers[0]
        if error is not None:
            raise error
        return bool(value)

    def idle(self, seconds: float) -> None:
        """Fly on for a time (s) at once."""
        end = self.now + round(seconds * 1e9)
        while self.now < end:
            self._batch(min(BATCH, -(-(end - self.now) // self.clock.tick)))

    async def run(self) -> None:
        """Simulate for as long as the task lives, sharing the loop with the clients."""
        self._stirred = asyncio.Event()
        while True:
            self._stirred.clear()
            if not self.clock.running(self.waiting()):
                await self._stirred.wait()
                continue
            self._turn()
            await asyncio.sleep(self.clock.wait())

    def waiting(self) -> bool:
        """Return whether a long call waits for its answer."""
        return any(vehicle.slot.task is not None for vehicle in self.vehicles.values())

    def _turn(self) -> None:
        """Fly what is due, for no longer than a client may be kept waiting."""
        end = time.monotonic() + TURN
        while self.clock.running(self.waiting()) and (steps := self.clock.due(BATCH)):
            self._batch(steps)
            if time.monotonic() > end:
                break

    def _batch(self, most: int) -> None:
        """Fly at most so many steps, up to the next look of a move, and do what is to be done then."""
        clock = self.clock
        wake = min((vehicle.slot.wake for vehicle in self.vehicles.values()), default=NEVER)
        steps = max(min(most, -(-(wake - clock.now) // clock.tick)), 1)
        fly(self.rows, clock.now, clock.tick, steps, triple(self.wind), triple(self.push))
        clock.advance(steps)
        flown = list(self.vehicles.values())
        for vehicle in flown:
            vehicle.feel(self.scene, [other for other in flown if other is not vehicle])
        for observe in self.observers:
            observe()
        for vehicle in self.vehicles.values():
            vehicle.slot.wake_up(clock.now)
        self._settle()

    def _settle(self) -> None:
        """Answer those who waited for the clock to pause."""
        if self._runs and self.clock.paused:
            for done in self._runs:
                if not done.done():
                    done.set_result(None)
            self._runs.clear()

    def _stir(self) -> None:
        if self._stirred is not None:
            self._stirred.set()


def triple(vector: Array) -> tuple[float, float, float]:
    """Return a vector (3,) as floats."""
    x, y, z = vector.tolist()
    return x, y, z
