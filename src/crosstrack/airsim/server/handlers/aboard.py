"""What vehicles carry: cameras and sensors; made when they are first asked for, or when the vehicle is first seen."""

from typing import Any, Protocol

from crosstrack.airsim.scene.cameras.camera import Cameras
from crosstrack.airsim.scene.scene import Eye
from crosstrack.airsim.scene.sensors.sensor import Moment
from crosstrack.airsim.scene.sensors.suite import Suite
from crosstrack.airsim.server.settings import Settings, VehicleSettings
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle

ADDED = VehicleSettings(vehicle_type="SimpleFlight")
"""of a vehicle that settings.json does not know"""


class Observer(Protocol):
    """A recording under way."""

    def observe(self) -> None:
        """Record where it is time to."""

    def close(self) -> None:
        """End the recording."""


class Aboard:
    """What one vehicle carries."""

    def __init__(self, simulator: Simulator, vehicle: ServedVehicle) -> None:
        every, own = settings_of(simulator), vehicle.settings or ADDED
        self.vehicle, self.simulator = vehicle, simulator
        self.cameras = Cameras(own.cameras, every.camera_defaults, aboard=True)
        self.suite = Suite(every.sensors(own), simulator.rng.spawn(1)[0])

    def observe(self) -> None:
        """Show the sensors the present state of the vehicle."""
        self.suite.observe(self.simulator.now, self.vehicle.kinematics())

    def moment(self) -> Moment:
        """Return what the sensors know now."""
        self.observe()
        eye = eye_of(self.simulator, self.vehicle)
        return self.suite.moment(self.vehicle.start.position, self.simulator.origin, eye)


class Equipment:
    """What all vehicles of a simulator carry, and the cameras that stand in the world."""

    def __init__(self, simulator: Simulator) -> None:
        settings = settings_of(simulator)
        self.simulator = simulator
        self.external = Cameras(settings.external_cameras, settings.camera_defaults, aboard=False)
        self.carried: dict[str, Aboard] = {}
        self.recorder: Observer | None = None
        simulator.observers.append(self.observe)
        simulator.resetters.append(self.restart)

    def aboard(self, vehicle: ServedVehicle) -> Aboard:
        """Return what a vehicle carries."""
        if vehicle.name not in self.carried:
            self.carried[vehicle.name] = Aboard(self.simulator, vehicle)
        return self.carried[vehicle.name]

    def observe(self) -> None:
        """Show all sensors the present states of their vehicles, and have them recorded."""
        for vehicle in self.simulator.vehicles.values():
            self.aboard(vehicle).observe()
        if self.recorder is not None:
            self.recorder.observe()

    def restart(self) -> None:
        """Start all sensors anew."""
        for aboard in self.carried.values():
            aboard.suite.restart()


def settings_of(simulator: Simulator) -> Settings:
    """Return the settings of a simulator, AirSim's defaults where it has none."""
    found: Any = simulator.settings
    return found if isinstance(found, Settings) else Settings()


def equipment(simulator: Simulator) -> Equipment:
    """Return what the vehicles of a simulator carry; call it before it runs, so that sensors do from the start."""
    found: Equipment | None = simulator.scene.equipment
    if found is None or found.simulator is not simulator:
        found = simulator.scene.equipment = Equipment(simulator)
        found.observe()
    return found


def eye_of(simulator: Simulator, vehicle: ServedVehicle | None) -> Eye:
    """Return what a vehicle can see: all but itself; with none, what can be seen from outside."""
    others = (one for one in simulator.vehicles.values() if one is not vehicle)
    eye: Eye = simulator.scene.eye_among((one.name, one.pose().position) for one in others)
    return eye
