"""Moving obstacles of a mission, as balls that are moved along in AirSim."""

from contextlib import suppress

import numpy as np

from crosstrack.airsim.client.blocking import Client
from crosstrack.airsim.client.errors import RemoteError
from crosstrack.airsim.structs import Pose
from crosstrack.errors import InputError, LinkLost, Problem
from crosstrack.frames import ned_from_enu
from crosstrack.protocols import Traffic
from crosstrack.types import Array
from crosstrack.vehicles.airsim.link import LEVEL

BALL, NAME = "Sphere", "crosstrack_ball"
"""the asset, of 1 m, and what the balls are called"""


class Balls:
    """The balls that hold the moving obstacles of one flight; of several vehicles the first one moves them.

    Args:
        client: connected to AirSim
        traffic: what moves
        alone: whether no other vehicle flies with this one, so that balls that are there were left by an earlier flight

    Raises:
        InputError: AirSim has no balls to put there.
    """

    def __init__(self, client: Client, traffic: Traffic | None, alone: bool) -> None:
        self.client, self.traffic = client, traffic
        self.names: list[str] = []
        left = client.list_scene_objects(f"{NAME}.*")
        for name in left if alone else ():
            client.destroy_object(name)
        if traffic is None or (left and not alone):
            return
        there = traffic.others(0.0)
        for k, (place, radius) in enumerate(zip(there.position, there.radius, strict=True)):
            self.names.append(self.put(f"{NAME}_{k}", place, float(radius)))

    def put(self, name: str, place: Array, radius: float) -> str:
        """Put a ball at a place (3,) m, and return its name there."""
        try:
            return self.client.spawn_object(name, BALL, Pose(ned_from_enu(place), LEVEL), np.full(3, 2.0 * radius))
        except RemoteError as error:
            raise InputError("vehicle airsim", [Problem("world.moving", f"AirSim has no {BALL}: {error}")]) from None

    def move(self, time: float) -> None:
        """Move the balls to where they are at a time (s)."""
        if self.traffic is None or not self.names:
            return
        places = ned_from_enu(self.traffic.others(time).position)
        for name, place in zip(self.names, places, strict=True):
            self.client.set_object_pose(name, Pose(place, LEVEL), True)

    def clear(self) -> None:
        """Take the balls away."""
        with suppress(LinkLost):
            for name in self.names:
                self.client.destroy_object(name)
