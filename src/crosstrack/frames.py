"""Conversions between coordinate frames, for the edges of the library; all are vectorised over leading axes.

Inside, the world is ENU (x east, y north, z up), bodies are FLU (x forward, y left, z up), quaternions xyzw.
"""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import ArrayLike

from crosstrack.types import Array, Finite

EQUATOR_RADIUS = 6378137.0
"""m, semi-major axis of the WGS84 ellipsoid"""
FLATTENING = 1 / 298.257223563
"""of the WGS84 ellipsoid"""
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)


@dataclass(frozen=True)
class Origin:
    """Where the local frame's (0, 0, 0) lies on the Earth, WGS84."""

    latitude: Annotated[float, Ge(-90), Le(90)] = 47.641468
    """degrees north"""
    longitude: Annotated[float, Ge(-180), Le(180)] = -122.140165
    """degrees east"""
    altitude: Finite = 122.0
    """m"""


def enu_from_ned(vectors: ArrayLike) -> Array:
    """Convert vectors (..., 3) from north-east-down to east-north-up; its own inverse."""
    north, east, down = np.moveaxis(np.asarray(vectors, float), -1, 0)
    return np.stack([east, north, -down], axis=-1)


def ned_from_enu(vectors: ArrayLike) -> Array:
    """Convert vectors (..., 3) from east-north-up to north-east-down; its own inverse."""
    return enu_from_ned(vectors)


def flu_from_frd(vectors: ArrayLike) -> Array:
    """Convert vectors (..., 3) from forward-right-down to forward-left-up; its own inverse."""
    flipped: Array = np.asarray(vectors, float) * np.array([1.0, -1.0, -1.0])
    return flipped


def frd_from_flu(vectors: ArrayLike) -> Array:
    """Convert vectors (..., 3) from forward-left-up to forward-right-down; its own inverse."""
    return flu_from_frd(vectors)


def xyzw_from_wxyz(quaternions: ArrayLike) -> Array:
    """Move the scalar part of quaternions (..., 4) from first to last."""
    return np.roll(np.asarray(quaternions, float), -1, axis=-1)


def wxyz_from_xyzw(quaternions: ArrayLike) -> Array:
    """Move the scalar part of quaternions (..., 4) from last to first."""
    return np.roll(np.asarray(quaternions, float), 1, axis=-1)


def attitude_enu_from_ned(quaternions: ArrayLike) -> Array:
    """Convert attitudes xyzw (..., 4) from FRD body in NED world to FLU body in ENU world; its own inverse.

    q_enu = t q_ned b, with t the half turn about (1, 1, 0)/√2 that takes NED to ENU and b the half turn about
    the body's x axis; the common sign is chosen so that the two conversions undo each other exactly.
    """
    x, y, z, w = np.moveaxis(np.asarray(quaternions, float), -1, 0)
    return np.stack([x + y, x - y, w - z, w + z], axis=-1) * math.sqrt(0.5)


def attitude_ned_from_enu(quaternions: ArrayLike) -> Array:
    """Convert attitudes xyzw (..., 4) from FLU body in ENU world to FRD body in NED world."""
    return attitude_enu_from_ned(quaternions)


def yaw_from_heading(heading: ArrayLike) -> Array:
    """Convert a heading (rad, clockwise from north) to a yaw (rad, counter-clockwise from east), [-π, π)."""
    return (1.5 * np.pi - np.asarray(heading, float)) % (2 * np.pi) - np.pi


def heading_from_yaw(yaw: ArrayLike) -> Array:
    """Convert a yaw (rad, counter-clockwise from east) to a heading (rad, clockwise from north), [-π, π)."""
    return yaw_from_heading(yaw)


def ecef_from_geodetic(geodetic: ArrayLike) -> Array:
    """Convert WGS84 (latitude °, longitude °, altitude m), (..., 3), to Earth-centred, Earth-fixed m."""
    latitude, longitude, altitude = np.moveaxis(np.asarray(geodetic, float), -1, 0)
    sin, cos = np.sin(np.radians(latitude)), np.cos(np.radians(latitude))
    vertical = EQUATOR_RADIUS / np.sqrt(1 - ECCENTRICITY_SQUARED * sin**2)  # radius of curvature in the prime vertical
    across = (vertical + altitude) * cos
    meridian = np.radians(longitude)
    up = (vertical * (1 - ECCENTRICITY_SQUARED) + altitude) * sin
    return np.stack([across * np.cos(meridian), across * np.sin(meridian), up], axis=-1)


def geodetic_from_ecef(points: ArrayLike) -> Array:
    """Convert Earth-centred Earth-fixed (..., 3) m to WGS84 (latitude °, longitude °, altitude m), (..., 3).

    Bowring's iteration on the reduced latitude (Survey Review 23, 1976), until only rounding is left.
    """
    x, y, z = np.moveaxis(np.asarray(points, float), -1, 0)
    across = np.hypot(x, y)
    polar_radius = EQUATOR_RADIUS * (1 - FLATTENING)
    second = ECCENTRICITY_SQUARED / (1 - ECCENTRICITY_SQUARED)
    reduced = np.arctan2(z, (1 - FLATTENING) * across)
    for _ in range(3):
        latitude = np.arctan2(
            z + second * polar_radius * np.sin(reduced) ** 3,
            across - ECCENTRICITY_SQUARED * EQUATOR_RADIUS * np.cos(reduced) ** 3,
        )
        reduced = np.arctan2((1 - FLATTENING) * np.sin(latitude), np.cos(latitude))
    sin, cos = np.sin(latitude), np.cos(latitude)
    altitude = across * cos + z * sin - EQUATOR_RADIUS * np.sqrt(1 - ECCENTRICITY_SQUARED * sin**2)
    return np.stack([np.degrees(latitude), np.degrees(np.arctan2(y, x)), altitude], axis=-1)


def _axes(origin: Origin) -> Array:
    """Return the rows east, north, up of the tangent plane at an origin in ECEF, (3, 3)."""
    latitude, longitude = np.radians([origin.latitude, origin.longitude])
    sin_lat, cos_lat, sin_lon, cos_lon = (
        np.sin(latitude),
        np.cos(latitude),
        np.sin(longitude),
        np.cos(longitude),
    )
    return np.array(
        [
            [-sin_lon, cos_lon, 0.0],
            [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        ]
    )


def _centre(origin: Origin) -> Array:
    return ecef_from_geodetic([origin.latitude, origin.longitude, origin.altitude])


def local_from_geodetic(geodetic: ArrayLike, origin: Origin) -> Array:
    """Convert WGS84 (latitude °, longitude °, altitude m), (..., 3), to ENU m on the plane at an origin."""
    return (ecef_from_geodetic(geodetic) - _centre(origin)) @ _axes(origin).T


def geodetic_from_local(points: ArrayLike, origin: Origin) -> Array:
    """Convert ENU m on the plane at an origin, (..., 3), to WGS84 (latitude °, longitude °, altitude m)."""
    return geodetic_from_ecef(np.asarray(points, float) @ _axes(origin) + _centre(origin))
