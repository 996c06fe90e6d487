"""AirSim's protocol: a client of its own, and a server on the embedded simulator."""

from typing import TYPE_CHECKING

from crosstrack.lazy import lazily

if TYPE_CHECKING:
    from crosstrack.airsim.client.aio import AsyncClient as AsyncClient
    from crosstrack.airsim.client.blocking import Client as Client
    from crosstrack.airsim.client.blocking import Pending as Pending
    from crosstrack.airsim.client.errors import RemoteError as RemoteError
    from crosstrack.airsim.server.serve import Server as Server
    from crosstrack.airsim.server.serve import simulator_of as simulator_of
    from crosstrack.airsim.server.settings import Settings as Settings
    from crosstrack.airsim.structs import GeoPoint as GeoPoint
    from crosstrack.airsim.structs import ImageRequest as ImageRequest
    from crosstrack.airsim.structs import KinematicsState as KinematicsState
    from crosstrack.airsim.structs import Pose as Pose
    from crosstrack.airsim.structs import RCData as RCData
    from crosstrack.airsim.structs import YawMode as YawMode

__all__ = [
    "AsyncClient",
    "Client",
    "GeoPoint",
    "ImageRequest",
    "KinematicsState",
    "Pending",
    "Pose",
    "RCData",
    "RemoteError",
    "Server",
    "Settings",
    "YawMode",
    "simulator_of",
]
STRUCTS = ["GeoPoint", "ImageRequest", "KinematicsState", "Pose", "RCData", "YawMode"]
"""those that a caller makes; the others are answers"""

__getattr__, __dir__ = lazily(
    __name__,
    {
        "AsyncClient": "client.aio",
        "Client": "client.blocking",
        "Pending": "client.blocking",
        "RemoteError": "client.errors",
        "Server": "server.serve",
        "Settings": "server.settings",
        "simulator_of": "server.serve",
        **dict.fromkeys(STRUCTS, "structs"),
    },
)
