"""The Earth as AirSim has it: a sphere with the magnetic field of a dipole."""

import math

import numpy as np

from crosstrack import frames
from crosstrack.frames import Origin
from crosstrack.types import Array

RADIUS = 6378137.0
"""m, of the sphere"""
POLE_LATITUDE = math.radians(80.31)
POLE_LONGITUDE = math.radians(-72.62)
MEAN_FIELD = 3.12e-5
"""T, of the dipole at its equator"""


def geodetic(position: Array, origin: Origin) -> tuple[float, float, float]:
    """Return latitude (degrees), longitude (degrees) and altitude (m) of a point (3,) m, NED from an origin.

    Along the great circle that leaves the origin towards the point, on a sphere (azimuthal equidistant projection).
    """
    north, east, down = (float(part) for part in position)
    far = math.hypot(north, east) / RADIUS
    altitude = origin.altitude - down
    if far < 1e-15:
        return origin.latitude, origin.longitude, altitude
    latitude, bearing = math.radians(origin.latitude), math.atan2(east, north)
    sine = math.sin(latitude) * math.cos(far) + math.cos(latitude) * math.sin(far) * math.cos(bearing)
    turned = math.atan2(
        math.sin(bearing) * math.sin(far),
        math.cos(far) * math.cos(latitude) - math.sin(far) * math.sin(latitude) * math.cos(bearing),
    )
    return math.degrees(math.asin(sine)), origin.longitude + math.degrees(turned), altitude


def local(latitude: float, longitude: float, altitude: float, origin: Origin) -> Array:
    """Return the point (3,) m, NED from an origin, of WGS84 coordinates (degrees, degrees, m)."""
    return frames.ned_from_enu(frames.local_from_geodetic([latitude, longitude, altitude], origin))


def magnetic_field(latitude: float, longitude: float, altitude: float) -> Array:
    """Return the magnetic field (3,) gauss, NED, of a dipole at WGS84 coordinates (degrees, degrees, m).

    AirSim takes the cosine of the magnetic colatitude to be cos φ cos φ_p + sin φ sin φ_p cos(λ - λ_p), in which sines
    and cosines of the latitudes have changed places; a script that expects its field gets that one here.
    """
    lat, east = math.radians(latitude), math.radians(longitude) - POLE_LONGITUDE
    cosine = math.cos(lat) * math.cos(POLE_LATITUDE) + math.sin(lat) * math.sin(POLE_LATITUDE) * math.cos(east)
    colatitude = math.acos(max(-1.0, min(1.0, cosine)))
    strength = MEAN_FIELD * (RADIUS / (RADIUS + altitude)) ** 3 * math.sqrt(1.0 + 3.0 * cosine * cosine)
    share = math.cos(POLE_LATITUDE) / max(math.sin(colatitude), 1e-12)
    beyond = cosine <= math.sin(POLE_LATITUDE) * math.sin(lat)
    sine = max(-1.0, min(1.0, (math.cos(east) if beyond else math.sin(east)) * share))
    declination, inclination = math.asin(sine), math.atan2(2.0 * cosine, math.sin(colatitude))
    flat = strength * math.cos(inclination)
    parts = [flat * math.cos(declination), flat * math.sin(declination), strength * math.sin(inclination)]
    return np.array(parts) * 1e4
