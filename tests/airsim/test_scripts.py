"""Scripts in the style of AirSim's examples, run by AirSim's own client against the server in lockstep."""

import json
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from reference_client import needs_client, run

from crosstrack.airsim.server.serve import Server, simulator_of, warm_up
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


PAIR = {name: {"VehicleType": "SimpleFlight", "Y": east} for name, east in (("Drone1", -4), ("Drone2", 4))}


@contextmanager
def blocks(**settings: Any) -> Iterator[Server]:
    """Serve the world of our own."""
    warm_up()
    document = {"SettingsVersion": 1.2, "SimMode": "Multirotor", **settings}
    with Server(simulator_of(parse(json.dumps(document)), lockstep=True)) as server:
        yield server


def equipped() -> Any:
    return blocks(Vehicles={"Drone": {"VehicleType": "SimpleFlight", "Sensors": SENSORS}})


@pytest.fixture(scope="module")
def plain() -> Iterator[Server]:
    with blocks() as server:
        yield server


@pytest.mark.parametrize("script", PLAIN)
def test_a_script_runs_to_its_end(script: str, plain: Server) -> None:
    run(script, plain.port)


def test_sensors_and_lidars_repeat_bit_for_bit() -> None:
    traces = []
    for _ in range(2):
        with equipped() as server:
            traces.append([run(script, server.port) for script in ("sensors", "lidar")])
    assert traces[0] == traces[1]
    assert all(len(trace.splitlines()) >= 4 for trace in traces[0])


def test_drones_that_fly_at_once_repeat_bit_for_bit() -> None:
    traces = []
    for _ in range(2):
        with blocks(Vehicles=PAIR) as server:
            traces.append(run("two_drones", server.port))
    assert traces[0] == traces[1]


def test_a_recording_is_written(tmp_path: Path) -> None:
    with blocks(Recording={"Folder": str(tmp_path), "RecordInterval": 0.05}) as server:
        run("recording", server.port, tmp_path)


def test_what_is_drawn_is_kept() -> None:
    with blocks() as server:
        run("markers", server.port)
        markers = server.simulator.scene.markers
        kinds = Counter(marker.kind for marker in markers.drawn)
        trace = next(iter(markers.traces.values()))
    assert kinds == {"points": 1, "lines": 2, "arrows": 1, "strings": 1, "transforms": 2}
    assert trace.color == (0.0, 0.0, 1.0, 0.5)
    assert trace.thickness == 4.0
