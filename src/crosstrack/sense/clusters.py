"""Points of surfaces put together into things: where each is, and how large."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

REACH = 0.5
"""m, closer than which points belong together"""
MOST = 600
"""points that are put together, evenly taken from those there are"""
FEWEST = 3
"""points of a thing"""
TALL = 1.6
"""height over width above which a thing is taken for an upright roll rather than a ball"""


@dataclass(frozen=True, eq=False)
class Blob:
    """One thing, of which a scan sees the side that faces it."""

    position: Array
    """(3,) m, of its middle"""
    radius: float
    """m"""
    rise: float
    """m, half of the height beyond that of a ball"""
    noise: float
    """m, standard deviation of the middle along each axis"""


def blobs_of(points: Array, origin: Array) -> list[Blob]:
    """Return the things that points (n, 3) m are seen of, from an origin (3,) m."""
    return [blob_of(group, origin) for group in groups_of(points) if len(group) >= FEWEST]


def groups_of(points: Array) -> list[Array]:
    """Return the points (n, 3) m, or some hundreds of them, in groups that hang together."""
    points = points[:: max(math.ceil(len(points) / MOST), 1)]
    group = _labels(points, REACH)
    return [points[group == g] for g in range(int(group.max(initial=-1)) + 1)]


@compiled
def _labels(points: Array, reach: float) -> NDArray[np.int64]:
    """Return for points (n, 3) in which group each is: (n,) from 0."""
    count, groups = len(points), 0
    label = np.full(count, -1)
    waiting = np.empty(count, dtype=np.int64)
    for first in range(count):
        if label[first] >= 0:
            continue
        label[first], waiting[0], left = groups, first, 1
        while left > 0:
            left -= 1
            i = waiting[left]
            for j in range(count):
                if label[j] < 0:
                    x, y, z = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
                    if x * x + y * y + z * z < reach * reach:
                        label[j], waiting[left] = groups, j
                        left += 1
        groups += 1
    return label


def blob_of(points: Array, origin: Array) -> Blob:
    """Return the ball, or the upright roll, whose side towards an origin (3,) m shows these points (n, 3) m.

    Rays hit the disc that a ball of radius r shows evenly: its points deviate by r/2 to every side, and their mean lies
    2r/3 before the middle. Those of a roll deviate by r/√3 to the sides, and their mean lies πr/4 before it.
    """
    mean = points.mean(axis=0)
    view = mean - origin
    view /= float(np.linalg.norm(view))
    aside = np.array([-view[1], view[0], 0.0])
    level = float(np.linalg.norm(aside))
    aside = aside / level if level > 1e-6 else np.array([1.0, 0.0, 0.0])
    up = np.cross(view, aside)
    width, height = ((points - mean) @ np.stack([aside, up], axis=1)).std(axis=0).tolist()
    noise = math.hypot(0.04, max(width, height) / math.sqrt(len(points)))
    if height > TALL * width and level > 0.5:
        radius = max(math.sqrt(3) * width, 0.1)
        return Blob(mean + math.pi / 4 * radius * view, radius, max(math.sqrt(3) * height - radius, 0.0), noise)
    radius = max(2 * max(width, height), 0.1)
    return Blob(mean + 2 / 3 * radius * view, radius, 0.0, noise)
