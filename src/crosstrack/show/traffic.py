"""Moving obstacles as they are drawn: the tracks that they fly, and where they are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crosstrack.flight.flight import Flight
from crosstrack.flight.plan import Plan
from crosstrack.types import Array
from crosstrack.world.mesh import Mesh
from crosstrack.world.moving import Moving, MovingObstacles
from crosstrack.world.world import World

MOVERS = "moving obstacles"
"""what they are called in a legend"""
POINTS = 200
"""of a track, and instants looked at for where it came nearest"""


@dataclass(frozen=True)
class Track:
    """One moving obstacle in a drawing."""

    mover: Moving
    mesh: Mesh
    """its surface at time 0"""
    line: Array
    """(n, 3) m, way of its middle, NaN outside the drawing"""
    nearest: float
    """s, when it came nearest to a vehicle"""
    first: bool
    """whether it is the first of them, which stands for all in a legend"""

    @property
    def met(self) -> Array:
        """(n, 3) m, the vertices of its surface when it came nearest"""
        return self.mesh.vertices + self.mover.shift(self.nearest)

    def outline(self, vertices: Array) -> Array:
        """Return its outline from above, closed, (n, 2) m: the convex hull of vertices (n, 3) m."""
        from scipy.spatial import ConvexHull  # noqa: PLC0415 - takes long to import, and few drawings need it

        flat = vertices[:, :2]
        corners = ConvexHull(flat).vertices
        hull: Array = flat[np.append(corners, corners[0])]
        return hull


def movers(plan: Plan) -> tuple[Moving, ...]:
    """Return what moves in the world of a plan."""
    traffic = plan.scenario.traffic
    return traffic.movers if isinstance(traffic, MovingObstacles) else ()


def shifts(mover: Moving, times: Array) -> Array:
    """Return how far an obstacle has moved at times (n,) s, (n, 3) m."""
    return np.array([mover.shift(time) for time in times.tolist()])


def tracks(flights: Sequence[Flight], box: Array) -> list[Track]:
    """Return the moving obstacles around flights that were flown at once, within a box (2, 3) m."""
    start = min(float(flight.record.time[0]) for flight in flights)
    end = max(float(flight.record.time[-1]) for flight in flights)
    times = np.linspace(start, end, POINTS)
    return [track(mover, flights, box, times, number == 0) for number, mover in enumerate(movers(flights[0].plan))]


def track(mover: Moving, flights: Sequence[Flight], box: Array, times: Array, first: bool) -> Track:
    """Return one of them."""
    mesh = mover.shape.mesh()
    away = shifts(mover, times)
    line = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2 + away
    inside = ((line >= box[0]) & (line <= box[1])).all(axis=1)
    still = World((mover.shape,))
    gaps = np.min([still.distance(at(flight, times) - away) for flight in flights], axis=0)
    return Track(mover, mesh, np.where(inside[:, None], line, np.nan), float(times[np.argmin(gaps)]), first)


def at(flight: Flight, times: Array) -> Array:
    """Return where a vehicle was at times (n,) s, (n, 3) m; far away where that is not finite."""
    record = flight.record
    row = np.clip(np.searchsorted(record.time, times), 0, len(record.time) - 1)
    return np.nan_to_num(record.position[row], nan=1e9, posinf=1e9, neginf=1e9)
