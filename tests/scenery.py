"""A simulator whose calls are made directly, and what several tests put into it."""

from typing import Any

import numpy as np

from crosstrack.airsim.methods import METHODS
from crosstrack.airsim.scene.poses import from_angles
from crosstrack.airsim.server.handlers import HANDLERS
from crosstrack.airsim.server.serve import simulator_of
from crosstrack.airsim.server.settings import parse
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array
from crosstrack.world.shapes import Shape
from crosstrack.world.world import World


def simulated(*shapes: Shape, settings: str = "{}", seed: int = 1) -> Simulator:
    """Return a simulator of a world with some shapes over flat ground, ENU."""
    return simulator_of(parse(settings), World(shapes), lockstep=True, seed=seed)


def call(simulator: Simulator, name: str, *arguments: Any) -> Any:
    """Return what a call answers, once it has been made sure that it can be sent."""
    method = METHODS[name]
    assert len(arguments) == len(method.parameters)
    value = HANDLERS[name](simulator, *arguments)
    method.result.pack(value)
    return value


def at(north: float, east: float, down: float, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0) -> Pose:
    """Return a pose; angles in degrees."""
    return Pose(np.array([north, east, down], dtype=float), from_angles(yaw, pitch, roll))


def put(simulator: Simulator, pose: Pose, name: str = "") -> None:
    """Put a vehicle somewhere, world NED."""
    vehicle = simulator.vehicle(name)
    vehicle.place(Pose(pose.position - vehicle.start.position, pose.orientation))


def vector(*parts: float) -> Array:
    """Return a vector."""
    return np.array(parts, dtype=float)
