"""One vehicle of the server: body, firmware, task, and what the API tells of it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crosstrack.airsim.firmware import air, airframe
from crosstrack.airsim.firmware.quadrotor import Quadrotor
from crosstrack.airsim.scene.earth import geodetic
from crosstrack.airsim.server.clock import Clock
from crosstrack.airsim.server.contacts import Feeler, touch, vehicle_hit
from crosstrack.airsim.server.task import Slot
from crosstrack.airsim.structs import (
    CollisionInfo,
    EnvironmentState,
    GeoPoint,
    KinematicsState,
    Pose,
    RCData,
    RotorState,
    RotorStates,
)
from crosstrack.frames import Origin
from crosstrack.types import GRAVITY, Array


def heading_of(orientation: Array) -> Array:
    """Return the level attitude (4,) xyzw of the same heading."""
    x, y, z, w = orientation
    half = 0.5 * np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.array([0.0, 0.0, np.sin(half), np.cos(half)])


class ServedVehicle:
    """A quadrotor that clients fly.

    Args:
        name: of the vehicle
        quadrotor: its row
        start: where it starts, world NED; level whatever it says
        home: the place of the world's origin on the earth
        clock: of the simulator
        armed: what its sticks may do when it is switched on, of `firmware.rows`
        settings: of the vehicle, for who needs more of them
    """

    def __init__(
        self, name: str, quadrotor: Quadrotor, start: Pose, home: Origin, clock: Clock, armed: int, settings: Any
    ) -> None:
        self.name, self.quadrotor, self.clock, self.settings = name, quadrotor, clock, settings
        self.start = Pose(np.array(start.position, float), heading_of(start.orientation))
        self.home = GeoPoint(*geodetic(self.start.position, home))
        self.origin = Origin(self.home.latitude, self.home.longitude, self.home.altitude)
        self.armed = armed
        self.slot, self.feeler = Slot(), Feeler()
        quadrotor["altitude"] = self.home.altitude
        self.reset()

    @property
    def now(self) -> int:
        """ns, the simulator's clock"""
        return self.clock.now

    @property
    def ideal(self) -> bool:
        """Whether it flies without AirSim's known mistakes."""
        return bool(self.quadrotor["ideal"])

    @property
    def open_to_api(self) -> bool:
        """Whether the API may take control: always, or by a switch of the sticks."""
        always = getattr(self.settings, "allow_api_always", True)
        return bool(always or (self.quadrotor["connected"] and self.quadrotor["channels"][5] > 0))

    def reset(self) -> None:
        """Put it back to where it started; whatever it does is cancelled, and the API loses control."""
        self.slot.cancel(self.now)
        self.quadrotor.reset(self.now // 1_000_000, self.armed)
        self.quadrotor.attitude[:] = self.start.orientation
        self.collision, self.rc_data = CollisionInfo(), RCData()
        self.feeler.forget()

    def kinematics(self) -> KinematicsState:
        """Return how it moves, relative to where it started."""
        q = self.quadrotor
        parts = (q.position, q.attitude, q.velocity, q.rate, q.acceleration, q.spin_up)
        return KinematicsState(*(part.copy() for part in parts))

    def local_pose(self) -> Pose:
        """Return where it is relative to where it started, NED."""
        return Pose(self.quadrotor.position.copy(), self.quadrotor.attitude.copy())

    def pose(self) -> Pose:
        """Return where it is, world NED."""
        return Pose(self.start.position + self.quadrotor.position, self.quadrotor.attitude.copy())

    def place(self, pose: Pose) -> None:
        """Put it somewhere else, relative to where it started; it keeps its motion."""
        self.quadrotor.position[:], self.quadrotor.attitude[:] = pose.position, pose.orientation
        self.quadrotor["grounded"] = False
        self.feeler.forget()

    def set_kinematics(self, state: KinematicsState) -> None:
        """Give it another motion, relative to where it started."""
        self.place(Pose(state.position, state.orientation))
        q = self.quadrotor
        q.velocity[:], q.rate[:] = state.linear_velocity, state.angular_velocity
        q.acceleration[:], q.spin_up[:] = state.linear_acceleration, state.angular_acceleration

    def location(self) -> GeoPoint:
        """Return where it is on the earth."""
        return GeoPoint(*geodetic(self.quadrotor.position, self.origin))

    def environment(self) -> EnvironmentState:
        """Return the air and the gravity where it is."""
        place = self.location()
        height = place.altitude
        return EnvironmentState(
            self.quadrotor.position.copy(),
            place,
            np.array([0.0, 0.0, GRAVITY]),
            air.pressure(height),
            air.temperature(height),
            air.density(height),
        )

    def rotors(self) -> RotorStates:
        """Return how its rotors turn, as at sea level."""
        states = tuple(
            RotorState(
                airframe.THRUST_MAX * out,
                airframe.TORQUE_MAX * out * sense,
                airframe.ROTOR_SPEED_MAX * max(out, 0.0) ** 0.5,
            )
            for out, sense in zip(self.quadrotor.output.tolist(), airframe.SPIN, strict=True)
        )
        return RotorStates(states, self.now)

    def feel(self, scene: Any, others: Sequence["ServedVehicle"]) -> None:
        """Find out whether it has hit something, or one of other vehicles, since it was last asked."""
        position = self.start.position + self.quadrotor.position
        solid, grounded = getattr(self.settings, "enable_collisions", True), bool(self.quadrotor["grounded"])
        hit = self.feeler.feel(scene, position, grounded, solid)
        if hit is None and others and solid and not grounded:
            there = ((other.name, other.start.position + other.quadrotor.position) for other in others)
            hit = vehicle_hit(scene.radius, position, there)
        if hit is not None:
            self.collision = touch(self.quadrotor, hit, self.start.position, self.now)
