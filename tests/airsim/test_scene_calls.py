"""Every call about the scene: whatever its arguments, it answers or refuses, and the server goes on."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenery import call, simulated, vector

from crosstrack.airsim.methods import METHODS
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers import cameras, environment, images, lenses, markers, objects, recording, sensing
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import GeoPoint, ImageRequest, Pose
from crosstrack.world.shapes import Box, Cylinder, Sphere

MODULES = cameras, environment, images, lenses, markers, objects, recording, sensing
NAMES = sorted(name for module in MODULES for name in module.HANDLERS)
NUMBERS = 0.0, 1.0, -1.0, 0.5, 90.0, 1e-30, 3e38, -3e38, math.inf, -math.inf, math.nan
WHOLE = 0, 1, -1, 3, 8, 9, 255, 256, 2**31 - 1, -(2**31)
WORDS = (
    "",
    "0",
    "V",
    "lidar",
    "Box_1",
    "Cube",
    "Cone",
    "SimpleFlight",
    "a.binvox",
    "../a.binvox",
    ".*",
    "(",
    "\0",
    "ü" * 300,
)


def number(random: np.random.Generator) -> float:
    """Return a number, most often a fit one."""
    return float(random.normal() * 10) if random.uniform() < 0.5 else NUMBERS[random.integers(len(NUMBERS))]


def vectors(random: np.random.Generator, size: int) -> Any:
    """Return a vector, most often a fit one."""
    if random.uniform() < 0.6:
        return random.normal(size=size)
    return np.array([number(random) for _ in range(size)])


def pose(random: np.random.Generator) -> Pose:
    """Return a pose."""
    return Pose(vectors(random, 3), vectors(random, 4))


def argument(name: str, random: np.random.Generator) -> Any:
    """Return an argument for a parameter of a name."""
    many = int(random.integers(0, 4))
    made: dict[str, Any] = {
        "poses": lambda: [pose(random) for _ in range(many)],
        "pose": lambda: pose(random),
        "requests": lambda: [
            ImageRequest(choice(WORDS, random), choice(WHOLE, random), random.uniform() < 0.5, random.uniform() < 0.5)
            for _ in range(many)
        ],
        "strings": lambda: [choice(WORDS, random) for _ in range(many)],
        "names": lambda: [choice(WORDS, random) for _ in range(many)],
        "wind": lambda: vectors(random, 3),
        "position": lambda: vectors(random, 3),
        "scale": lambda: vectors(random, 3),
    }
    if name in made:
        return made[name]()
    if name in ("point", "point1", "point2"):
        return GeoPoint(number(random), number(random), number(random))
    if name.startswith(("points", "positions")):
        return np.array([vectors(random, 3) for _ in range(many)]).reshape(-1, 3)
    if "color" in name:
        return np.array([number(random) for _ in range(4 if many else 3)], np.float32)
    return None


def choice(among: tuple[Any, ...], random: np.random.Generator) -> Any:
    """Return one of several."""
    return among[random.integers(len(among))]


def simple(kind: str, random: np.random.Generator) -> Any:
    """Return an argument of a simple type."""
    match kind:
        case "Flag" | "External":
            return bool(random.uniform() < 0.3)
        case "Text":
            return choice(WORDS, random)
        case "Single" | "Double":
            return float(np.float32(number(random)))
    return choice(WHOLE, random)


def arguments(name: str, random: np.random.Generator) -> list[Any]:
    """Return arguments of a call, of the right types."""
    found = []
    for key, codec in METHODS[name].parameters.items():
        value = argument(key, random)
        if value is None or (name in ("simPlotStrings", "simPlotTransforms") and key == "scale"):
            value = simple(type(codec).__name__, random)
        found.append(value)
    return found


def scene() -> Simulator:
    """Return a simulator with some of everything."""
    shapes = Box((-5, 8, 0), (5, 9, 6)), Cylinder((8, 0), 1.0, (0, 9)), Sphere((-6, -6, 3), 2.0)
    sensors = '{"lidar": {"SensorType": 6, "Enabled": true}, "d": {"SensorType": 5, "Enabled": true}}'
    text = '{"Vehicles": {"V": {"VehicleType": "SimpleFlight", "Sensors": %s}}}'
    return simulated(*shapes, settings=text.replace("%s", sensors))


@pytest.mark.parametrize("name", NAMES)
def test_any_arguments(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(images, "MOST_PIXELS", 1 << 17)
    simulator, random = scene(), np.random.default_rng(7)
    answered = 0
    for _ in range(40):
        try:
            call(simulator, name, *arguments(name, random))
            answered += 1
        except Refused as refused:
            assert str(refused)  # noqa: PT017 - either outcome is good, but never without words
    if not METHODS[name].parameters:
        assert answered == 40
    call(simulator, "stopRecording")
    simulator.idle(0.1)
    assert len(call(simulator, "simGetImage", "0", 0, "", False)) > 100
    assert call(simulator, "getImuData", "", "").time_stamp == simulator.now


def test_a_vehicle_that_is_nowhere_sees_the_sky() -> None:
    simulator = scene()
    for position in (vector(math.nan, 0, 0), vector(0, math.inf, 0), vector(1e200, 0, -1e200), vector(0, 0, 1e30)):
        simulator.vehicle("").quadrotor.position[:] = position
        for kind in range(8):
            call(simulator, "simGetImages", [ImageRequest("0", kind, False, False)], "", False)
        simulator.scene.equipment.carried["V"].suite.restart()
        call(simulator, "getDistanceSensorData", "", "")
