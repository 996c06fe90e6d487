"""How much of space a drawing takes in."""

from collections.abc import Sequence

import numpy as np

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import Scene
from crosstrack.types import Array

MARGIN = 0.04
"""of the longest side, around everything"""
FLATTEST = 0.2
"""of the longest side, the shortest: a level flight is not drawn as a sheet of paper"""


def extent(flights: Sequence[Flight], drawn: Scene) -> Array:
    """Return the box `around` flights, their routes and obstacles."""
    return around([path for flight in flights for path in (flight.record.position, flight.plan.route.points)], drawn)


def around(paths: Sequence[Array], drawn: Scene) -> Array:
    """Return the lowest and the highest corner (2, 3) m of a box around paths (n, 3) m, route and obstacles.

    What is flatter than the box gets its room above it where there are obstacles: they stand on the box's floor.
    """
    clouds = [drawn.route, *paths, *(mesh[1] for mesh in drawn.meshes)]
    finite = [cloud[np.isfinite(cloud).all(axis=1)] for cloud in clouds]
    low = np.min([cloud.min(axis=0) for cloud in finite if len(cloud)], axis=0)
    high = np.max([cloud.max(axis=0) for cloud in finite if len(cloud)], axis=0)
    longest = max(float((high - low).max()), 1.0)
    half = np.maximum(high - low, FLATTEST * longest) / 2 + MARGIN * longest
    middle = (low + high) / 2
    if drawn.meshes:
        middle[2] = low[2] + half[2] - MARGIN * longest
    return np.array([middle - half, middle + half])
