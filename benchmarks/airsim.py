"""`crosstrack serve` against what it is meant to do: `python -m benchmarks.airsim`.

The server runs in lockstep in a process of its own, in the world of our own, and a client beside it: ours, and AirSim's
where `make .venv-airsim/installed` has been run. "aside" is what the server takes for the same call without the wire.
MuJoCo draws the same obstacles with the same camera where it finds a way to draw. Times are wall time, medians with the
spread from a tenth to nine tenths.
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from crosstrack.airsim import Client
from crosstrack.airsim.scene.blocks import blocks
from crosstrack.airsim.server.handlers import HANDLERS
from crosstrack.airsim.server.serve import simulator_of, warm_up
from crosstrack.airsim.server.settings import parse
from crosstrack.airsim.structs import ImageRequest

THEIRS = Path(__file__).parents[1] / ".venv-airsim" / "bin" / "python"
SETTINGS = json.dumps(
    {
        "Vehicles": {
            "Drone": {
                "VehicleType": "SimpleFlight",
                "Sensors": {
                    "Lidar": {
                        "SensorType": 6,
                        "Enabled": True,
                        "NumberOfChannels": 16,
                        "PointsPerSecond": 144_000,
                        "VerticalFOVUpper": 15,
                        "VerticalFOVLower": -15,
                        "DataFrame": "SensorLocalFrame",
                    }
                },
            }
        }
    }
)
STEP, STEPS, LONG = 0.02, 500, 120.0
"""s, of a short move; how many; s, of a long one"""
QUERIES, PICTURES, TURNS = 2000, 100, 100
SCENE, DEPTH = 0, 1
WIDTH, HEIGHT = 256, 144
REQUESTS = {
    "depth": ImageRequest("0", DEPTH, pixels_as_float=True, compress=False),
    "scene": ImageRequest("0", SCENE, pixels_as_float=False, compress=False),
    "scene as PNG": ImageRequest("0", SCENE, pixels_as_float=False, compress=True),
}
THEIR_SCRIPT = f"""
import json, sys, time
import airsim
client = airsim.MultirotorClient(port=int(sys.argv[1]))
client.enableApiControl(True)
client.armDisarm(True)
client.takeoffAsync().join()
def timed(call, times):
    taken = []
    for _ in range(times):
        began = time.perf_counter()
        call()
        taken.append(time.perf_counter() - began)
    return taken
steps = timed(lambda: client.moveByVelocityZAsync(1, 0, -3, {STEP}).join(), {STEPS})
states = timed(client.getMultirotorState, {QUERIES})
print("times", json.dumps([steps, states]))
"""


def timed(call: Callable[[], object], times: int, before: Callable[[], object] = lambda: None) -> list[float]:
    """Return how long calls took (s); what comes before each is not counted."""
    taken = []
    for _ in range(times):
        before()
        began = time.perf_counter()
        call()
        taken.append(time.perf_counter() - began)
    return taken


def spread(values: Any, unit: str = "") -> str:
    low, middle, high = np.quantile(values, [0.1, 0.5, 0.9])
    return f"{middle:8.3g}{unit} ({low:.3g} to {high:.3g})"


def rates(taken: list[float], gain: float = 1.0) -> str:
    return spread(gain / np.array(taken))


def ended(process: "subprocess.Popen[str]") -> None:
    """Wait for the end of a server, and make it end where that takes too long."""
    try:
        process.wait(30)
    except subprocess.TimeoutExpired:
        process.kill()
        print("the server did not end by itself")


@contextmanager
def server() -> Iterator[int]:
    """Serve until the block ends; give the port."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "settings.json"
        file.write_text(SETTINGS)
        command = [sys.executable, "-m", "crosstrack", "serve", "--lockstep", "--port", "0", "--settings", str(file)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
            try:
                assert process.stdout is not None
                found = next(filter(None, (re.search(r":(\d+),", line) for line in process.stdout)))
                yield int(found[1])
            finally:
                process.send_signal(signal.SIGINT)
                ended(process)


def clock(client: Client, step_rates: list[tuple[str, list[float]]]) -> None:
    """Print how much faster than real time moves are."""
    client.reset()
    client.enable_api_control()
    client.arm_disarm()
    client.takeoff().join()
    long = timed(lambda: client.move_by_velocity_z(1, 0, -30, LONG).join(), 5)
    print(f"a move of {LONG:g} s: {rates(long, LONG)} times real time, asked 50")

    def step() -> None:
        client.move_by_velocity_z(1, 0, -3, STEP).join()

    def step_and_look() -> None:
        step()
        client.get_ground_truth_kinematics()

    ours = [("our client", timed(step, STEPS)), ("our client, asking where it is", timed(step_and_look, STEPS))]
    for name, taken in ours + step_rates:
        print(f"moves of {STEP:g} s by {name}: {rates(taken, STEP)} times real time, asked 10")


def queries(taken: list[float], whose: str) -> None:
    """Print how long a state takes to come."""
    milliseconds = 1e3 * np.array(taken)
    print(f"state, by {whose}: {spread(milliseconds, ' ms')}, 99 % within {np.quantile(milliseconds, 0.99):.3g} ms")


def pictures(client: Client, theirs: dict[str, str]) -> None:
    """Print how many pictures and turns of a lidar there are in a second."""
    simulator = simulator_of(parse(SETTINGS), lockstep=True)
    simulator.idle(1.0)
    client.reset()
    for name, request in REQUESTS.items():
        aside = timed(lambda: HANDLERS["simGetImages"](simulator, [request], "", False), PICTURES)  # noqa: B023
        wire = timed(lambda: client.get_images([request]), PICTURES)  # noqa: B023 - called at once
        print(f"{name}, {WIDTH} x {HEIGHT}: {rates(wire)} a second, aside {rates(aside)}{theirs.get(name, '')}")
    aside = timed(lambda: HANDLERS["getLidarData"](simulator, "", ""), TURNS, lambda: simulator.idle(0.1))
    wire = timed(client.get_lidar_data, TURNS, lambda: client.continue_for_time(0.1))
    points = len(client.get_lidar_data().point_cloud) // 3
    print(f"lidar of 16 x 900: {rates(wire)} a second, aside {rates(aside)}; {points} points hit, asked 200")


def mujoco_pictures() -> dict[str, str]:
    """Return how fast MuJoCo draws, nothing where it cannot."""
    os.environ.setdefault("MUJOCO_GL", "egl")  # it needs no display
    try:
        import mujoco
    except ImportError:
        return {}
    geoms = []
    for thing in blocks():
        x, y, z, w = thing.pose.orientation
        half = " ".join(str(side / 2) for side in np.abs(thing.scale))
        kind = {"Cube": "box", "Sphere": "ellipsoid"}.get(thing.asset, "cylinder")
        north, east, down = thing.pose.position
        geoms.append(
            f'<geom type="{kind}" size="{half}" pos="{north} {-east} {-down}" quat="{w} {x} {-y} {-z}" rgba="1 0 0 1"/>'
        )
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><visual><global offwidth="{WIDTH}" offheight="{HEIGHT}"/></visual><worldbody>
        <light pos="0 0 50" dir="0.4 0 -1" directional="true"/><geom type="plane" size="100 100 1"/>{"".join(geoms)}
        <camera name="eye" pos="0 0 1.5" xyaxes="0 -1 0 0 0 1" fovy="58.7"/></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    try:
        renderer = mujoco.Renderer(model, HEIGHT, WIDTH)
    except Exception as error:  # whatever the library that should draw raises
        print(f"MuJoCo does not draw here: {error}")
        return {}
    drawn = {}
    for name, on in (("scene", renderer.disable_depth_rendering), ("depth", renderer.enable_depth_rendering)):
        on()
        renderer.update_scene(data, camera="eye")
        drawn[name] = f", MuJoCo {rates(timed(renderer.render, PICTURES))}"
    renderer.close()
    return drawn


def their_times(port: int) -> list[list[float]]:
    """Return how long moves and states take AirSim's own client, nothing where it is not there."""
    if not THEIRS.exists():
        return []
    done = subprocess.run([str(THEIRS), "-c", THEIR_SCRIPT, str(port)], capture_output=True, text=True, check=True)
    found: list[list[float]] = json.loads(done.stdout.split("times", 1)[1])
    return found


def main() -> None:
    warm_up()
    drawn = mujoco_pictures()
    with server() as port:
        theirs = their_times(port)
        with Client(port=port) as client:
            clock(client, [("AirSim's client", theirs[0])] if theirs else [])
            queries(timed(client.get_multirotor_state, QUERIES), "our client")
            if theirs:
                queries(theirs[1], "AirSim's client")
            pictures(client, drawn)


if __name__ == "__main__":
    main()
