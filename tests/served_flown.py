"""A session that was flown on a server: two vehicles, a wall, moves of all kinds of ends, and markers."""

import json
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from crosstrack.airsim.client.blocking import Client
from crosstrack.airsim.client.errors import RemoteError
from crosstrack.airsim.server.serve import Server, simulator_of, warm_up
from crosstrack.airsim.server.settings import parse
from crosstrack.airsim.structs import CollisionInfo, MultirotorState, Pose
from crosstrack.flight.served import Recorder, Session
from crosstrack.types import Array
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

SECOND_START = (3.0, -8.0)
"""m, north and east"""
TWO = json.dumps(
    {
        "Vehicles": {
            "One": {"VehicleType": "SimpleFlight"},
            "Two": {"VehicleType": "SimpleFlight", "X": SECOND_START[0], "Y": SECOND_START[1]},
        }
    }
)
WALL = Box((-20.0, 20.0, 0.0), (20.0, 21.0, 10.0))
"""20 m north, ENU"""
PATH: Array = np.array([[8.0, 0.0, -5.0], [8.0, 8.0, -5.0]])
TURN: Array = np.array([0.0, 0.0, 0.5, np.sqrt(0.75)])
RED, SEEN_FOR = (1.0, 0.0, 0.0, 1.0), 2.5
"""colour of the points, and s"""


@dataclass(frozen=True)
class Flown:
    """What was recorded, and what the client knows of it."""

    session: Session
    log: Path
    unfinished: bytes
    """the log as it was before the session ended"""
    answers: dict[str, Any]
    moved: MultirotorState
    """of One after its path"""
    hit: CollisionInfo
    error: str


def drawn(client: Client) -> None:
    """Draw one of everything."""
    client.plot_points(list(PATH), RED, 20.0, SEEN_FOR, False)
    client.plot_line_strip(list(PATH), (0.0, 0.0, 1.0, 0.5), 5.0, -1.0, True)
    client.plot_arrows([PATH[0]], [PATH[1]], (1.0, 1.0, 1.0, 1.0), 5.0, 10.0, -1.0, True)
    client.plot_strings(["<b>here</b>"], [PATH[1]], 5.0, RED, 10.0)
    client.plot_transforms([Pose(PATH[0], TURN)], 100.0, 5.0, -1.0, True)
    client.set_trace_line((0.0, 0.5, 0.0, 1.0), 5.0, "One")


def fly(client: Client) -> tuple[dict[str, Any], MultirotorState, CollisionInfo, str]:
    """Fly both vehicles: along a path, into the wall, and once more after a reset."""
    for name in ("One", "Two"):
        client.enable_api_control(True, name)
    client.takeoff(vehicle="One").join()
    try:
        client.move_on_path(list(PATH), 3.0, lookahead=0.1, vehicle="One").join()
    except RemoteError as broken:
        error = str(broken)
    answers = {"path": client.move_on_path(list(PATH), 3.0, vehicle="One").join()}
    moved = client.get_multirotor_state("One")
    drawn(client)
    client.takeoff(vehicle="Two").join()
    client.pause(True)  # for the first to end at once whenever the second comes
    first = client.move_to_position(-50.0, 0.0, -5.0, 2.0, vehicle="Two")
    second = client.move_by_velocity(5.0, 0.0, 0.0, 5.0, vehicle="Two")
    client.pause(False)
    answers["by velocity"] = second.join()
    answers["superseded"] = first.join()
    hit = client.get_collision_info("Two")
    for _ in range(20):
        client.move_by_velocity(0.0, 1.0, -0.5, 0.1, vehicle="Two").join()
    client.reset()
    client.enable_api_control(True, "One")
    client.move_by_velocity(0.0, 2.0, -1.0, 2.0, vehicle="One").join()
    return answers, moved, hit, error


@cache
def flown() -> Flown:
    """Return the session; it is flown once."""
    warm_up()
    log = Path(tempfile.mkdtemp()) / "session.mcap"
    simulator = simulator_of(parse(TWO), World((WALL,)), lockstep=True)
    recorder = Recorder(simulator, log)
    with Server(simulator) as server, Client("127.0.0.1", server.port) as client:
        told = fly(client)
        unfinished = log.read_bytes()
    return Flown(recorder.close(), log, unfinished, *told)
