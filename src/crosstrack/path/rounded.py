"""Corners rounded by circular arcs within a tolerance."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.path.pieces import Pieces
from crosstrack.path.polyline import SHORTEST
from crosstrack.types import Array

STRAIGHT = 1e-6
"""rad, turns below are none"""
CUSP = np.radians(170)
"""rad, turns above stay sharp: an arc there would be tighter than the vehicle turns on the spot"""


def rounded(corners: Array, tolerance: float, radius: float) -> Pieces:
    """Round the corners of a polyline by at most `tolerance`.

    A corner of turn θ gets the arc of radius r = min(max(radius, 0.1 R), 0.9 R, l / tan θ/2), where
    R = tolerance / (sec θ/2 - 1) uses all of the tolerance and l is half of the shorter leg beside it: gentle turns
    become as smooth as costs next to nothing. Points that deviate by less than a tenth of the tolerance are dropped
    first (Douglas and Peucker 1973), so that noise on dense points makes no tight corners, unless all of them together
    make the smoother path, as on a circle.

    Args:
        corners: (n, 3) m, no two in a row the same
        tolerance: m
        radius: m, no corner needs more for the speed it is flown at
    """
    path = arcs(corners, tolerance, radius)
    kept = corners[simplified(corners, 0.1 * tolerance)]
    if len(kept) == len(corners) or np.linalg.norm(np.diff(kept, axis=0), axis=1).min() <= SHORTEST:
        return path
    return min(arcs(kept, tolerance, radius), path, key=bending)


def bending(path: Pieces) -> tuple[int, float]:
    """Return the number of turns on the spot, and the integral of the squared curvature (1/m)."""
    jumps = np.linalg.norm(path.tangents[1:] - path(path.knots[1:-1] - 1e-9, 1), axis=1)
    return int(np.count_nonzero(jumps > 1e-4)), float(path.curvatures**2 @ path.lengths)


def arcs(corners: Array, tolerance: float, radius: float) -> Pieces:
    """Round every corner of a polyline, see `rounded`."""
    legs = np.diff(corners, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    directions = legs / lengths[:, None]
    before, after = directions[:-1], directions[1:]
    turn = 2 * np.arctan2(np.linalg.norm(after - before, axis=1), np.linalg.norm(after + before, axis=1))
    soft = (turn > STRAIGHT) & (turn < CUSP)
    half_tangent = np.tan(np.where(soft, turn, 1.0) / 2)
    room = np.minimum(share(lengths)[0][1:], share(lengths)[1][:-1]) / half_tangent
    bulge = 1 / np.cos(np.where(soft, turn, 1.0) / 2) - 1
    widest = np.minimum(np.maximum(radius, 0.1 * tolerance / bulge), 0.9 * tolerance / bulge)
    radii = np.where(soft, np.minimum(widest, room), 0.0)
    return assemble(corners, directions, lengths, turn, radii, radii * half_tangent)


def share(lengths: Array) -> tuple[Array, Array]:
    """Return how much of each leg the arc at its start and the arc at its end may use: half, or all where alone."""
    at_start, at_end = lengths / 2, lengths / 2
    at_end = np.where(np.arange(len(lengths)) == 0, lengths * 0.999, at_end)
    at_start = np.where(np.arange(len(lengths)) == len(lengths) - 1, lengths * 0.999, at_start)
    return at_start, at_end


def assemble(corners: Array, directions: Array, lengths: Array, turn: Array, radii: Array, cut: Array) -> Pieces:
    """Lay lines and arcs end to end; `cut` (m) is how much of its legs each inner corner uses."""
    rows: list[tuple[Array, Array, Array, float, float]] = []
    zero = np.zeros(3)
    for k, direction in enumerate(directions):
        start = cut[k - 1] if k > 0 else 0.0
        end = cut[k] if k < len(cut) else 0.0
        straight = lengths[k] - start - end
        if straight > STRAIGHT:
            rows.append((corners[k] + start * direction, direction, zero, 0.0, straight))
        if k < len(cut) and radii[k] > 0:
            normal = directions[k + 1] - direction * (directions[k + 1] @ direction)
            normal /= np.linalg.norm(normal)
            origin = corners[k + 1] - cut[k] * direction
            rows.append((origin, direction, normal, 1 / radii[k], radii[k] * turn[k]))
    origins, tangents, normals, curvatures, arcs = zip(*rows, strict=True)
    return Pieces(np.array(origins), np.array(tangents), np.array(normals), np.array(curvatures), np.array(arcs))


@compiled
def simplified(corners: Array, tolerance: float) -> NDArray[np.bool_]:
    """Return which corners (n,) to keep so that none is farther than `tolerance` from the legs between the kept.

    Going back along a leg counts as distance too, so that legs flown to and fro are kept.
    """
    count = corners.shape[0]
    keep = np.zeros(count, np.bool_)
    keep[0] = keep[-1] = True
    stack = [(0, count - 1)]
    while len(stack) > 0:
        first, last = stack.pop()
        ax, ay, az = corners[first, 0], corners[first, 1], corners[first, 2]
        bx, by, bz = corners[last, 0] - ax, corners[last, 1] - ay, corners[last, 2] - az
        square = bx * bx + by * by + bz * bz
        worst, split = tolerance, -1
        furthest, turning = 0.0, first
        for i in range(first + 1, last):
            x, y, z = corners[i, 0] - ax, corners[i, 1] - ay, corners[i, 2] - az
            u = min(max((x * bx + y * by + z * bz) / square, 0.0), 1.0) if square > 0 else 0.0
            distance = np.sqrt((x - u * bx) ** 2 + (y - u * by) ** 2 + (z - u * bz) ** 2)
            if distance > worst:
                worst, split = distance, i
            along = (x * bx + y * by + z * bz) / np.sqrt(square) if square > 0 else 0.0
            if along > furthest:
                furthest, turning = along, i
            elif furthest - along > worst:
                worst, split = furthest - along, turning
        if split >= 0:
            keep[split] = True
            stack.append((first, split))
            stack.append((split, last))
    return keep
