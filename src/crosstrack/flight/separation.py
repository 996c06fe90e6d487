"""How near several vehicles come to one another between two samples."""

from collections.abc import Sequence

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.flight.flying import Flying
from crosstrack.types import Array


def separations(vehicles: Sequence[Flying]) -> tuple[Array, Array]:
    """Return the least distance of each vehicle to the centre of another, and between their spheres, (n,) m each.

    Between the sample before and this one, all on straight lines; inf for one that is alone or no longer there.
    """
    apart, gaps = np.full(len(vehicles), np.inf), np.full(len(vehicles), np.inf)
    there = np.array([vehicle.index for vehicle in vehicles if vehicle.aloft], dtype=int)
    if len(there) > 1:
        before = np.array([vehicles[k].before.position for k in there])
        now = np.array([vehicles[k].now.position for k in there])
        radii = np.array([vehicles[k].plan.vehicle.radius for k in there], dtype=float)
        apart[there], gaps[there] = nearest(before, now, radii)
    return apart, gaps


@compiled
def nearest(before: Array, now: Array, radii: Array) -> tuple[Array, Array]:
    """Return the least distance between centres and between spheres of balls (n,) that move from place to place.

    The difference of two places is e + s f for s from 0 to 1, nearest to zero at s = -e·f / f·f.
    """
    count = len(radii)
    apart, gaps = np.full(count, np.inf), np.full(count, np.inf)
    for i in range(count):
        for j in range(i):
            e = before[i] - before[j]
            f = now[i] - now[j] - e
            square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2]
            along = e[0] * f[0] + e[1] * f[1] + e[2] * f[2]
            s = min(1.0, max(0.0, -along / square)) if square > 0.0 else 0.0
            x, y, z = e[0] + s * f[0], e[1] + s * f[1], e[2] + s * f[2]
            distance = np.sqrt(x * x + y * y + z * z)
            gap = distance - radii[i] - radii[j]
            apart[i], apart[j] = min(apart[i], distance), min(apart[j], distance)
            gaps[i], gaps[j] = min(gaps[i], gap), min(gaps[j], gap)
    return apart, gaps
