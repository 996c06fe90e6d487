"""A quadrotor of the AirSim server without any server, for tests: it is flown by moves at once."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.server.clock import Clock
from crosstrack.airsim.server.moves import path, vertical
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import Pose, YawMode
from crosstrack.types import Array
from crosstrack.world.world import World

NEVER = 3e38
"""s, a timeout"""
AS_IT_IS = YawMode(True, 0.0)
T, P, V, Q = 0, slice(1, 4), slice(4, 7), slice(7, 11)
"""columns of a log: time (s) since the move began, position, velocity, attitude xyzw"""


class Aloft(NamedTuple):
    """A simulator and its one vehicle."""

    simulator: Simulator
    vehicle: ServedVehicle

    def fly(self, move: Move) -> bool:
        """Fly a move to its end."""
        return self.simulator.fly(self.vehicle, move)

    def idle(self, seconds: float) -> None:
        """Fly on without any move."""
        self.simulator.idle(seconds)

    def logged(self, move: Callable[[ServedVehicle], Move], after: float = 0.0) -> tuple[Array, float, bool]:
        """Fly a move and on for a time (s); return the log, the time (s) that the move took, and its answer."""
        rows: list[Array] = []
        quadrotor, start = self.vehicle.quadrotor, self.simulator.now

        def note() -> None:
            now = 1e-9 * (self.simulator.now - start)
            rows.append(np.concatenate([[now], quadrotor.position, quadrotor.velocity, quadrotor.attitude]))

        note()
        self.simulator.observers.append(note)
        answer = self.fly(move(self.vehicle))
        took = 1e-9 * (self.simulator.now - start)
        self.idle(after)
        self.simulator.observers.remove(note)
        return np.array(rows), took, answer


def on_ground(world: World | None = None, *, ideal: bool = False) -> Aloft:
    """Return a vehicle that stands where it starts, the API in control."""
    simulator = Simulator(Scene(world or World()), Clock(lockstep=True), ideal=ideal)
    vehicle = simulator.add_vehicle("SimpleFlight", Pose())
    vehicle.quadrotor.take_control(True)
    simulator.idle(0.5)
    return Aloft(simulator, vehicle)


def hovering(z: float = -10.0, world: World | None = None, *, ideal: bool = False) -> Aloft:
    """Return a vehicle that has taken off, climbed to a height z (m, down), and come to rest."""
    found = on_ground(world, ideal=ideal)
    vehicle = found.vehicle
    found.fly(vertical.take_off(vehicle, 20.0))
    speed = 3.0 if z < -4.0 else 0.5  # a goal within the lookahead is not flown to
    found.fly(path.move_to_z(vehicle, z, speed, NEVER, AS_IT_IS, -1.0, 1.0))
    found.fly(vertical.hover(vehicle))
    found.idle(10.0)
    return found
