"""What can be put into a scene: solids of 1 m, which a pose and a scale place.

A solid that stands upright is one of the world's shapes, exactly. Any other, a cone, or one that is tilted or squeezed,
is cut into cubes.
"""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack import frames
from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.structs import Pose
from crosstrack.types import Array
from crosstrack.world.grids import Voxels
from crosstrack.world.mesh import circle
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere

ASSETS = ("Cone", "Cube", "Cylinder", "Sphere")
OTHER_NAMES = {"1M_Cube": "Cube", "1M_Cube_Chamfer": "Cube"}
"""of AirSim's example world"""
COARSE, FINE, ACROSS = 32, 64, 8
"""cubes that a solid is cut into: at least and at most along its longest side, and across its shortest in between"""
SIDES = 32
"""of a cylinder that is squeezed"""
EXACT = 1e-6
"""how far the part of an axis may be from 1 for a solid to stand upright"""
LEAST, MOST = 1e-3, 1e5
"""m, sides of what can be placed"""


def place(asset: str, pose: Pose, scale: Array) -> Shape | Voxels:
    """Return a solid of the world (ENU) from its pose (NED) and its lengths (3,) m along its axes."""
    turn = matrix(pose.orientation)
    lengths = np.abs(scale)
    upright = np.flatnonzero(np.abs(turn[2]) > 1.0 - EXACT)
    if asset == "Sphere" and np.ptp(lengths) < EXACT:
        return Sphere(_triple(frames.enu_from_ned(pose.position)), float(lengths[0]) / 2)
    if asset == "Cube" and upright.size:
        return _block(pose.position, turn, lengths, int(upright[0]))
    if asset == "Cylinder" and upright.size and upright[0] == 2:
        return _column(pose.position, turn, lengths)
    return _cubes(asset, pose.position, turn, lengths)


def inside(asset: str, points: Array) -> NDArray[np.bool_]:
    """Return which points (n, 3) are in a solid of 1 m around the origin, its axes forward, right, down."""
    x, y, z = np.abs(points).T
    within: NDArray[np.bool_] = (x <= 0.5) & (y <= 0.5) & (z <= 0.5)
    if asset == "Sphere":
        within &= x * x + y * y + z * z <= 0.25
    if asset == "Cylinder":
        within &= x * x + y * y <= 0.25
    if asset == "Cone":  # its tip is up
        within &= np.hypot(x, y) <= 0.5 * (points[:, 2] + 0.5)
    return within


def _triple(point: Array) -> tuple[float, float, float]:
    x, y, z = (float(part) for part in point)
    return x, y, z


def _block(centre: Array, turn: Array, lengths: Array, up: int) -> Shape:
    """Return a box with one of its axes vertical."""
    half = np.abs(turn) @ (lengths / 2)
    if (np.abs(turn).max(axis=1) > 1.0 - EXACT).all():
        corners = frames.enu_from_ned(np.array([centre - half, centre + half]))
        return Box(_triple(corners.min(axis=0)), _triple(corners.max(axis=0)))
    a, b = (lengths[k] / 2 * turn[:, k] for k in range(3) if k != up)
    outline = frames.enu_from_ned(np.array([centre + a + b, centre - a + b, centre - a - b, centre + a - b]))
    return _prism(outline[:, :2], -float(centre[2]), float(lengths[up]) / 2)


def _column(centre: Array, turn: Array, lengths: Array) -> Shape:
    """Return an upright cylinder, round or squeezed."""
    up, half = -float(centre[2]), float(lengths[2]) / 2
    if abs(lengths[0] - lengths[1]) < EXACT:
        return Cylinder((float(centre[1]), float(centre[0])), float(lengths[0]) / 2, (up - half, up + half))
    rim = circle(SIDES) * lengths[:2] / 2 @ turn[:2, :2].T + centre[:2]
    return _prism(rim[:, ::-1], up, half)


def _prism(outline: Array, middle: float, half: float) -> Prism:
    return Prism(tuple((float(x), float(y)) for x, y in outline), (middle - half, middle + half))


def _cubes(asset: str, centre: Array, turn: Array, lengths: Array) -> Voxels:
    """Return the cubes whose middles are in a solid; one at least."""
    half, longest = np.abs(turn) @ (lengths / 2), float(lengths.max())
    size = min(max(float(lengths.min()) / ACROSS, longest / FINE), longest / COARSE)
    counts = [max(1, math.ceil(2.0 * h / size - 1e-9)) for h in frames.enu_from_ned(half) * (1, 1, -1)]
    low = frames.enu_from_ned(centre) - np.array(counts) * size / 2
    axes = (np.arange(count) + 0.5 for count in counts)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) * size + low
    local = (frames.ned_from_enu(grid) - centre) @ turn / lengths
    occupied = inside(asset, local).reshape(counts)
    occupied[tuple(count // 2 for count in counts)] = True
    return Voxels(occupied, _triple(low), size)
