"""A speed along a path that honours acceleration limits and slows for corners."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

SETTLING = 5.0
"""1/s, distance to the end into speed, where a vehicle comes to rest"""
SETTLING_STEPS = np.array([1.0, 0.8, 0.6, 0.4, 0.2, 0.1])
"""of the settling distance: knots of the speed there"""


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speed by arc length: constant acceleration from knot to knot, so that v² is linear in s."""

    knots: Array
    """(n,) m, increasing"""
    speeds: Array
    """(n,) m/s at the knots"""

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (...): speed (m/s) or acceleration along the path (m/s²) for order 0, 1."""
        if isinstance(s, float):
            return np.asarray(at(s, order, self.knots, self.squares))
        if order == 0:
            return np.sqrt(np.interp(s, self.knots, self.squares))
        return np.asarray(self.accelerations[self.knots[1:-1].searchsorted(s, side="right")])

    @cached_property
    def squares(self) -> Array:
        """(n,) (m/s)²"""
        return self.speeds**2

    @cached_property
    def accelerations(self) -> Array:
        """(n - 1,) m/s², d(v²)/ds / 2"""
        return np.diff(self.squares) / np.diff(self.knots) / 2

    @cached_property
    def duration(self) -> float:
        """s, time from end to end"""
        return float(np.sum(2 * np.diff(self.knots) / (self.speeds[1:] + self.speeds[:-1])))


def profile(lengths: Array, limits: Array, corners: Array, accelerations: Array, swing: float = 0.0) -> SpeedProfile:
    """Make the fastest speed profile over the pieces of a path (Bobrow, Dubowsky, Gibson 1985, on a piecewise bound).

    It starts from rest and ends at rest; over the last a / SETTLING² metres, at most half of the way, the speed is
    at most SETTLING times the distance to the end, so that the vehicle settles there.

    Args:
        lengths: (n,) m, of the pieces
        limits: (n,) m/s, upper bound on each piece
        corners: (n + 1,) m/s, upper bound at the ends of the pieces
        accelerations: (n,) m/s², along each piece
        swing: s, from full acceleration to full braking; on a piece that has both, the top speed lasts as long
    """
    lengths, limits, bounds, accelerations = settling(lengths, limits, corners, accelerations)
    bounds[:-1] = np.minimum(bounds[:-1], limits)
    bounds[1:] = np.minimum(bounds[1:], limits)
    bounds[0] = bounds[-1] = 0.0
    reachable(bounds, lengths, accelerations)
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    first, last = bounds[:-1] ** 2, bounds[1:] ** 2
    # The top speed v of a short piece solves v²/a + v swing = l + (v₀² + v₁²) / 2a.
    reach = lengths + (first + last) / (2 * accelerations)
    top = accelerations / 2 * (np.sqrt(swing**2 + 4 * reach / accelerations) - swing)
    peak = np.minimum(limits**2, np.maximum(top**2, np.maximum(first, last)))
    rise, fall = (peak - first) / (2 * accelerations), (peak - last) / (2 * accelerations)
    knots = np.column_stack([starts[:-1], starts[:-1] + rise, starts[1:] - fall]).ravel()
    speeds = np.column_stack([bounds[:-1], np.sqrt(peak), np.sqrt(peak)]).ravel()
    knots, speeds = np.append(knots, starts[-1]), np.append(speeds, bounds[-1])
    keep = np.concatenate([[True], np.diff(knots) > 1e-9])
    keep[-1] = True
    if len(keep) > 1 and knots[-1] - knots[np.flatnonzero(keep[:-1])[-1]] <= 1e-9:
        keep[np.flatnonzero(keep[:-1])[-1]] = False
    return SpeedProfile(knots[keep], speeds[keep])


def settling(lengths: Array, limits: Array, corners: Array, accelerations: Array) -> tuple[Array, Array, Array, Array]:
    """Split the pieces where the speed falls with the distance to the end, and bound it there."""
    knots = np.concatenate([[0.0], np.cumsum(lengths)])
    end = knots[-1]
    distance = min(0.5 * end, accelerations[-1] / SETTLING**2)
    splits = np.union1d(knots, end - SETTLING_STEPS * distance)
    speeds = np.where(end - splits > 1.001 * distance, np.inf, SETTLING * (end - splits))
    which = knots[1:-1].searchsorted(splits[:-1], side="right")
    bounds = np.minimum(speeds, np.where(np.isin(splits, knots), corners[knots.searchsorted(splits)], np.inf))
    # From split to split v² is linear, which takes SETTLING² times the distance from the middle to the end.
    braking = np.where(np.isinf(speeds[:-1]), np.inf, SETTLING**2 * (end - (splits[1:] + splits[:-1]) / 2))
    return (
        np.diff(splits),
        np.minimum(limits[which], speeds[:-1]),
        bounds,
        np.minimum(accelerations[which], braking),
    )


@compiled
def at(s: float, order: int, knots: Array, squares: Array) -> float:
    """Return the speed (m/s) or the acceleration (m/s²) at an arc length (m), of a squared speed linear in between."""
    k = min(max(int(np.searchsorted(knots, s, side="right")) - 1, 0), knots.size - 2)
    slope = (squares[k + 1] - squares[k]) / (knots[k + 1] - knots[k])
    if order == 1:
        return float(0.5 * slope)
    square = squares[k] + slope * (min(max(s, knots[0]), knots[-1]) - knots[k])
    return math.sqrt(max(0.0, square))  # rounding may leave a rest below zero


@compiled
def reachable(bounds: Array, lengths: Array, accelerations: Array) -> None:
    """Lower the speeds at the ends of the pieces, in place, to what the accelerations can reach from either side."""
    for k in range(lengths.size):
        bounds[k + 1] = min(bounds[k + 1], np.sqrt(bounds[k] ** 2 + 2 * accelerations[k] * lengths[k]))
    for k in range(lengths.size - 1, -1, -1):
        bounds[k] = min(bounds[k], np.sqrt(bounds[k + 1] ** 2 + 2 * accelerations[k] * lengths[k]))
