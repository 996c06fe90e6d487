"""Scripts in the style of AirSim's examples, run by AirSim's own client against the server in lockstep."""

import json
import subprocess
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from reference_client import SCRIPTS, needs_client, run
from served import serving

from crosstrack.airsim.server.serve import Server
from crosstrack.airsim.server.settings import parse

pytestmark = needs_client
PLAIN = (
    "hello_drone",
    "takeoff_land",
    "velocity_box",
    "path",
    "survey",
    "orbit",
    "reset_often",
    "wind",
    "pause_continue",
    "images",
    "objects",
    "detection",
    "cameras",
)
AHEAD = {"SensorType": 5, "Enabled": True, "MinDistance": 0.2, "MaxDistance": 40}
LIDAR = {"SensorType": 6, "Enabled": True}
SENSORS = {
    "Ahead": AHEAD,
    "Below": {**AHEAD, "Pitch": -90},
    "Above": {**AHEAD, "Pitch": 90},
    "Down": LIDAR,
    "Level": {
        **LIDAR,
        "NumberOfChannels": 1,
        "PointsPerSecond": 18_000,
        "VerticalFOVUpper": 0,
        "VerticalFOVLower": 0,
        "DataFrame": "SensorLocalFrame",
    },
}


def settings(**more: object) -> str:
    return json.dumps({"SettingsVersion": 1.2, "SimMode": "Multirotor", **more})


EQUIPPED = settings(Vehicles={"Drone": {"VehicleType": "SimpleFlight", "Sensors": SENSORS}})
PAIR = settings(
    Vehicles={
        "Drone1": {"VehicleType": "SimpleFlight", "X": 0, "Y": -4},
        "Drone2": {"VehicleType": "SimpleFlight", "X": 0, "Y": 4},
    }
)


@pytest.fixture(scope="module")
def plain() -> Iterator[Server]:
    """Serve with AirSim's defaults."""
    with serving(default=True) as server:
        yield server


@pytest.mark.parametrize("script", PLAIN)
def test_a_script_passes(script: str, plain: Server) -> None:
    run(script, plain.port)
