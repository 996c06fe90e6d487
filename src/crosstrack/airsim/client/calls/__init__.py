"""Every call of the protocol as a typed method: AirSim's names in small letters, without `sim`; world NED, body FRD."""

from crosstrack.airsim.client.calls.cameras import Cameras
from crosstrack.airsim.client.calls.markers import Markers
from crosstrack.airsim.client.calls.moves import Moves
from crosstrack.airsim.client.calls.objects import Objects
from crosstrack.airsim.client.calls.sensors import Sensors
from crosstrack.airsim.client.calls.server import Server
from crosstrack.airsim.client.calls.vehicles import Vehicles


class Calls(Server, Vehicles, Moves, Sensors, Cameras, Objects, Markers):
    """All calls of the protocol."""
