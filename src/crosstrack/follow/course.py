"""From the route as asked for to the course as flown."""

import math

import numpy as np

from crosstrack.follow.speed import SpeedProfile, profile
from crosstrack.path.pieces import Pieces
from crosstrack.path.polyline import Polyline
from crosstrack.path.rounded import rounded
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope

CUSP = 0.5
"""of the tolerance, given to braking at a turn on the spot"""
SWING = 3.0
"""response times that the vehicle needs from full acceleration to full braking"""
RESERVE = 0.9
"""of the vehicle's acceleration, planned with; the rest is left to the tracker"""


def plan_course(
    route: Polyline, tolerance: float, cruise: float, envelope: Envelope, start: Array | None = None
) -> Course:
    """Round the corners of a route and give it a speed that the vehicle can hold within the tolerance.

    On an arc of radius r the speed is at most sqrt(a r), where a is the part of the vehicle's acceleration that is
    planned with. A vehicle that turns at once (acceleration inf) follows the route itself.

    Args:
        route: the path asked for
        tolerance: m, cross-track error to plan for
        cruise: m/s
        envelope: what the vehicle can do
        start: (3,) m, where a vehicle that is not at the beginning of the route joins it, at the closest point
    """
    speed = min(cruise, envelope.speed)
    if math.isinf(envelope.acceleration):
        path: Pieces = route
    else:
        path = rounded(route.points, tolerance, speed**2 / (RESERVE * envelope.acceleration))
    entry = 0.0 if start is None else path.project(start, 0.0, path.length)
    if not envelope.stops:
        constant = SpeedProfile(np.array([0.0, path.length]), np.array([speed, speed]))
        return Course(path, constant, envelope, entry, corners=route.points)
    accelerations = RESERVE * possible(path, envelope)
    with np.errstate(divide="ignore"):
        limits = np.minimum(speed, envelope.speed_vertical / steepness(path))
        limits = np.minimum(limits, np.sqrt(accelerations / path.curvatures))
    corners = cusp_speeds(path, accelerations, CUSP * tolerance)
    pace = profile(path.lengths, limits, corners, accelerations, SWING * envelope.response_time)
    return Course(path, pace, envelope, entry, corners=route.points)


def possible(path: Pieces, envelope: Envelope) -> Array:
    """Return the acceleration (pieces,) m/s² that the vehicle has in every direction in which a piece needs it."""
    with np.errstate(divide="ignore"):
        return np.minimum(envelope.acceleration, envelope.acceleration_vertical / steepness(path))


def steepness(path: Pieces) -> Array:
    """Return the greatest vertical part (pieces,) of a unit vector in the line or plane of each piece."""
    return np.hypot(path.tangents[:, 2], path.normals[:, 2])


def cusp_speeds(path: Pieces, accelerations: Array, tolerance: float) -> Array:
    """Return the speed bound (m/s) at the ends of each piece: sqrt(2 a ε) / sin(θ/2) where the path turns by θ at once.

    With an acceleration a along the bisector, begun and ended 2 v sin(θ/2) / (2 a) from the corner, the vehicle is
    within ε of it: the turn on the spot, θ = π, brakes within ε.
    """
    ends = path(path.knots[1:-1] - 1e-9, 1)
    sine = np.linalg.norm(path.tangents[1:] - ends, axis=1) / 2
    acceleration = np.minimum(accelerations[1:], accelerations[:-1])
    with np.errstate(divide="ignore"):
        speeds = np.where(sine > 1e-4, np.sqrt(2 * acceleration * tolerance) / sine, np.inf)
    return np.concatenate([[np.inf], speeds, [np.inf]])
