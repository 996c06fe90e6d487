"""Still air as AirSim models it: the standard atmosphere up to 11 km, colder and thinner bands above."""

import math

from crosstrack.compiled import compiled

EARTH_RADIUS = 6378137.0
"""m"""
SEA_LEVEL_PRESSURE = 101325.0
"""Pa"""
SEA_LEVEL_TEMPERATURE = 288.15
"""K"""
LAPSE = 0.0065
"""K/m, up to the tropopause"""
EXPONENT = 5.255877
"""g / (R L)"""
GAS_CONSTANT = 287.053
"""J/(kg K), of dry air"""
TROPOPAUSE = 11000.0
"""m"""
TROPOPAUSE_PRESSURE = 22632.06
"""Pa"""
TROPOPAUSE_TEMPERATURE = 216.65
"""K"""
SCALE = 0.1577e-3
"""1/m, by which the pressure falls off above the tropopause"""


@compiled
def geopotential(altitude: float) -> float:
    """Return the geopotential height (m) of an altitude (m)."""
    return EARTH_RADIUS * altitude / (EARTH_RADIUS + altitude)


@compiled
def temperature(altitude: float) -> float:
    """Return the temperature (K) at an altitude (m); constant above the tropopause."""
    height = geopotential(altitude)
    return SEA_LEVEL_TEMPERATURE - LAPSE * height if height <= TROPOPAUSE else TROPOPAUSE_TEMPERATURE


@compiled
def pressure(altitude: float) -> float:
    """Return the pressure (Pa) at an altitude (m)."""
    height = geopotential(altitude)
    if height > TROPOPAUSE:
        return TROPOPAUSE_PRESSURE * math.exp(-SCALE * (height - TROPOPAUSE))
    return SEA_LEVEL_PRESSURE * math.pow(1 - LAPSE / SEA_LEVEL_TEMPERATURE * height, EXPONENT)


@compiled
def density(altitude: float) -> float:
    """Return the density (kg/m³) at an altitude (m)."""
    return pressure(altitude) / (GAS_CONSTANT * temperature(altitude))


SEA_LEVEL_DENSITY = SEA_LEVEL_PRESSURE / (GAS_CONSTANT * SEA_LEVEL_TEMPERATURE)
"""kg/m³"""
