"""Calls about the world as a whole: wind, weather, light, levels, materials, and vehicles that are added."""

import logging

import numpy as np

from crosstrack.airsim.scene.names import LONGEST
from crosstrack.airsim.scene.poses import usable
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.aboard import equipment, settings_of
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array

log = logging.getLogger(__name__)
WEATHER = 8
"""parameters of the weather, and one that turns it on"""
GREATEST_WIND = 300.0
"""m/s"""
MOST_VEHICLES = 100
LEVELS = (logging.INFO, logging.WARNING, logging.ERROR, logging.INFO, logging.DEBUG)
"""of the log, by AirSim's severity"""


def set_wind(simulator: Simulator, wind: Array) -> None:
    """Set the velocity of the air (3,) m/s, world NED."""
    if not (np.abs(wind) <= GREATEST_WIND).all():
        raise Refused(f"a wind of {[float(part) for part in wind]} m/s; each part must be within {GREATEST_WIND}")
    simulator.wind = np.array(wind, dtype=float)


def enable_weather(simulator: Simulator, enable: bool) -> None:
    """Take note; there is no weather."""
    log.info("weather is turned %s: it has no effect here", "on" if enable else "off")


def set_weather(simulator: Simulator, parameter: int, value: float) -> None:
    """Take note; there is no weather."""
    if not 0 <= parameter <= WEATHER:
        raise Refused(f"weather parameter {parameter}; there are 0 to {WEATHER}")
    log.info("weather parameter %d is %g: it has no effect here", parameter, value)


def set_time_of_day(
    simulator: Simulator, enable: bool, start: str, summer: bool, speed: float, interval: float, move_sun: bool
) -> None:
    """Take note, as AirSim does in a world without its sky; the sun stands still."""
    if enable:
        log.info("the time of day is %r: it has no effect here", start)


def run_console_command(simulator: Simulator, command: str) -> bool:
    """Return false: there is no console."""
    log.info("console command %r: there is no console here", command)
    return False


def print_message(simulator: Simulator, message: str, parameter: str, severity: int) -> None:
    """Write a message to the log of the server."""
    log.log(LEVELS[severity] if 0 <= severity < len(LEVELS) else logging.INFO, "%r %r", message, parameter)


def load_level(simulator: Simulator, name: str) -> bool:
    """Return false, as AirSim does for a level that it does not find."""
    log.info("level %r: there are no levels here", name)
    return False


def set_light(simulator: Simulator, name: str, intensity: float) -> bool:
    """Return false, as AirSim does for a light that it does not find."""
    return False


def swap_textures(simulator: Simulator, tags: str, texture: int, component: int, material: int) -> list[str]:
    """Return no names, as AirSim does where no thing has the tags."""
    return []


def set_material(simulator: Simulator, name: str, material: str, component: int) -> bool:
    """Return false, as AirSim does for a material that it does not find."""
    return False


def settings_text(simulator: Simulator) -> str:
    """Return settings.json as it was read."""
    return settings_of(simulator).text


def add_vehicle(simulator: Simulator, name: str, kind: str, pose: Pose, pawn: str) -> bool:
    """Add a vehicle with the usual cameras and sensors; return whether it is of a kind that is flown here.

    Raises:
        Refused: the name is taken or unfit, there are too many vehicles, or the pose is not finite.
    """
    if kind.lower() != "simpleflight":
        log.warning("vehicle type %s is not flown here", kind)
        return False
    if not 0 < len(name) <= LONGEST or name in simulator.vehicles:
        raise Refused(f"a vehicle called {name!r}; the name must be new, and have 1 to {LONGEST} characters")
    if len(simulator.vehicles) >= MOST_VEHICLES:
        raise Refused(f"there are {MOST_VEHICLES} vehicles; no more are added")
    if not usable(pose):
        raise Refused("the pose of the vehicle is not finite, or turns by nothing")
    vehicle = simulator.add_vehicle(name, pose)
    equipment(simulator).aboard(vehicle).observe()
    return True


HANDLERS = {
    "simSetWind": set_wind,
    "simEnableWeather": enable_weather,
    "simSetWeatherParameter": set_weather,
    "simSetTimeOfDay": set_time_of_day,
    "simRunConsoleCommand": run_console_command,
    "simPrintLogMessage": print_message,
    "simLoadLevel": load_level,
    "simSetLightIntensity": set_light,
    "simSwapTextures": swap_textures,
    "simSetObjectMaterial": set_material,
    "simSetObjectMaterialFromTexture": set_material,
    "getSettingsString": settings_text,
    "simAddVehicle": add_vehicle,
}
