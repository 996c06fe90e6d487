"""Missions written as QGroundControl `.plan` files."""

import json
from pathlib import Path
from typing import Any

from crosstrack.mission.mission import Mission
from crosstrack.mission.qgroundcontrol import plan_from_local

WAYPOINT, TAKEOFF, CHANGE_SPEED = 16, 22, 178
HOME_FRAME, NO_FRAME = 3, 2


def plan_document(mission: Mission) -> dict[str, Any]:
    """Return a mission's route and speed as QGroundControl's plan format has it.

    The planned home is the mission's local (0, 0, 0), so that importing gives the same points again.
    """
    origin = mission.place
    climbs = mission.start.takeoff and mission.start.on_route
    points = mission.points[1:] if climbs else mission.points
    rows = plan_from_local(points, origin)
    items = [_item(CHANGE_SPEED, NO_FRAME, [1, mission.speed, -1, 0, 0, 0, 0])]
    for index, (latitude, longitude, altitude) in enumerate(rows.tolist()):
        command = TAKEOFF if climbs and index == 0 else WAYPOINT
        place = [round(latitude, 10), round(longitude, 10), round(altitude - origin.altitude, 6)]
        items.append(_item(command, HOME_FRAME, [0, 0, 0, None, *place]))
    for number, item in enumerate(items, start=1):
        item["doJumpId"] = number
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "Crosstrack",
        "geoFence": {"circles": [], "polygons": [], "version": 2},
        "rallyPoints": {"points": [], "version": 2},
        "mission": {
            "version": 2,
            "firmwareType": 12,  # PX4
            "vehicleType": 2,  # quadrotor
            "globalPlanAltitudeMode": 1,  # relative to home
            "cruiseSpeed": mission.speed,
            "hoverSpeed": mission.speed,
            "plannedHomePosition": [origin.latitude, origin.longitude, origin.altitude],
            "items": items,
        },
    }


def _item(command: int, frame: int, params: list[float | None]) -> dict[str, Any]:
    item: dict[str, Any] = {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": command,
        "frame": frame,
        "params": params,
    }
    if frame == HOME_FRAME:
        item |= {"Altitude": params[6], "AltitudeMode": 1, "AMSLAltAboveTerrain": None}
    return item


def export_plan(mission: Mission, path: str | Path) -> None:
    """Write a mission's route and speed as a `.plan` file.

    Raises:
        OSError: the file cannot be written.
    """
    Path(path).write_text(json.dumps(plan_document(mission), indent=4) + "\n", encoding="utf-8")
