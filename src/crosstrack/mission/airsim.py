"""AirSim's settings.json for a mission: its vehicles, where they start, and what they see with."""

import math
from typing import Any

from crosstrack.frames import heading_from_yaw, ned_from_enu
from crosstrack.mission.mission import Mission
from crosstrack.vehicles.airsim.settings import sensors_of

ALONE = "SimpleFlight"
"""what AirSim calls the vehicle where settings name none"""


def airsim_settings(mission: Mission) -> dict[str, Any]:
    """Return the settings with which AirSim, or `crosstrack serve`, has the vehicles of a mission.

    They stand on the ground below where they start.
    """
    vehicles = {}
    for member in mission.members:
        name = member.name if mission.vehicles else ALONE
        north, east, down = ned_from_enu([*member.launch[:2], member.obstacles.ground]).tolist()
        vehicles[name] = {
            "VehicleType": "SimpleFlight",
            "X": north,
            "Y": east,
            "Z": down,
            "Yaw": math.degrees(float(heading_from_yaw(member.enu.start.yaw))),
            **{group: given for group, given in sensors_of(member.sensors).items() if given},
        }
    place = mission.place
    return {
        "SettingsVersion": 1.2,
        "SimMode": "Multirotor",
        "OriginGeopoint": {"Latitude": place.latitude, "Longitude": place.longitude, "Altitude": place.altitude},
        "Vehicles": vehicles,
    }
