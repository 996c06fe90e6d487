"""Corridors around straight legs, in space and from above."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crosstrack.show.traces import Figure, flat, points
from crosstrack.show.traces import packed as pack
from crosstrack.types import Array

SIDES = 24
"""of the polygon that stands for a circle"""
RINGS = 6
"""of each hemisphere"""
MOST_LEGS = 1500
"""legs that are drawn as solid tubes: more would slow the page down"""
COLOR = "#0f766e"


def tube(route: Array, radius: float) -> Figure:
    """Return all points within `radius` (m) of a polyline (n, 3) m in space: a capsule around each leg."""
    legs = [capsule(start, end, radius) for start, end in pairwise(route[: MOST_LEGS + 1])]
    count = len(legs[0][0])
    vertices = np.concatenate([leg[0] for leg in legs])
    triangles = np.concatenate([leg[1] + index * count for index, leg in enumerate(legs)])
    look = {"type": "mesh3d", "name": "corridor", "color": COLOR, "opacity": 0.1, "hoverinfo": "skip"}
    corners = {axis: pack(triangles[:, index]) for index, axis in enumerate("ijk")}
    return look | {"showlegend": True, "lighting": {"ambient": 1.0, "diffuse": 0.0}} | points(vertices) | corners


def capsule(start: Array, end: Array, radius: float) -> tuple[Array, NDArray[np.integer]]:
    """Return the surface of a capsule as vertices (n, 3) m and triangles: rings about its axis, from pole to pole."""
    along = end - start
    along = along / np.linalg.norm(along)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    aside = np.cross(along, across)
    turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    circle = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * aside
    rise = np.linspace(-np.pi / 2, 0, RINGS + 1)
    lower = start + radius * (np.cos(rise)[:, None, None] * circle + np.sin(rise)[:, None, None] * along)
    upper = end + radius * (np.cos(rise)[::-1, None, None] * circle - np.sin(rise)[::-1, None, None] * along)
    rings = np.concatenate([lower, upper])
    corner = np.arange(len(rings) * SIDES).reshape(len(rings), SIDES)
    a, b = corner[:-1].ravel(), np.roll(corner, -1, axis=1)[:-1].ravel()
    c, d = corner[1:].ravel(), np.roll(corner, -1, axis=1)[1:].ravel()
    return rings.reshape(-1, 3), np.concatenate([np.column_stack([a, b, c]), np.column_stack([b, d, c])])


def band(route: Array, radius: float) -> Figure:
    """Return all points within `radius` (m) of a polyline (n, 3) m from above, as one outline for each leg."""
    outlines = [stadium(start, end, radius) for start, end in pairwise(route[:, :2])]
    gap = np.full((1, 2), np.nan)
    corners = np.concatenate([part for outline in outlines for part in (outline, gap)][:-1])
    fill = {"fill": "toself", "fillcolor": "rgba(15, 118, 110, 0.15)", "line": {"width": 0}, "hoverinfo": "skip"}
    return {"type": "scatter", "mode": "lines", "name": "corridor", **fill, **flat(corners)}


def stadium(start: Array, end: Array, radius: float) -> Array:
    """Return the closed outline (n, 2) m, counter-clockwise, of the points within `radius` of a leg from above."""
    heading = np.arctan2(*(end - start)[::-1])
    half = np.linspace(-np.pi / 2, np.pi / 2, SIDES // 2 + 1)
    ahead, behind = heading + half, heading + np.pi + half
    front = end + radius * np.column_stack([np.cos(ahead), np.sin(ahead)])
    back = start + radius * np.column_stack([np.cos(behind), np.sin(behind)])
    return np.concatenate([front, back, front[:1]])
