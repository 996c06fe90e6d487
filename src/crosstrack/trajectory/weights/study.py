"""The trade-off between smooth and near: trajectories for several weights of the guide, measured."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.trajectory.arguments import as_numbers
from crosstrack.trajectory.certified.extremes import largest_norm
from crosstrack.trajectory.certified.polyline_distance import largest_deviation
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

SAMPLES = 64
"""of a piece, for the mean of the deviation"""


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """One trajectory of a study; what is the most is certified for every instant."""

    weight: float
    """λ"""
    curve: PiecewisePolynomial
    max_deviation: float
    """m, from the line through the waypoints"""
    rms_deviation: float
    """m, root mean square over time"""
    max_speed: float
    """m/s"""
    max_acceleration: float
    """m/s²"""
    cost: float
    """∫ ‖p⁽ˢ⁾‖² dt"""
    guide_error: float
    """m² s, ∫ ‖p - chord‖² dt"""


@dataclass(frozen=True, eq=False)
class Study:
    """What several weights make of the same waypoints."""

    waypoints: Array
    """(n, d) m"""
    times: Array
    """(n,) s"""
    derivative: int
    rows: tuple[Tradeoff, ...]
    """by rising weight"""
    corridor: float | None = None
    """m, half width of the boxes about the inner waypoints; None where they are met"""


@reported_by("study")
def study(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int = 3,
    *,
    weights: Sequence[float] = (0.0, 1e2, 1e3, 1e4, 1e5),
    corridor: float | None = None,
) -> Study:
    """Return the trajectories for several weights of the chords, and how near, fast and rough each is.

    Args:
        waypoints: (n, d) m
        times: (n,) s, increasing
        derivative: s, the derivative that is minimised
        weights: λ of all segments, 0 or more
        corridor: m, see `minimum`

    Raises:
        InputError: all that is wrong with the arguments.

    Example:
        >>> from crosstrack.trajectory import study
        >>> found = study([[0, 0], [1, 2], [3, 2]], [0, 1, 2], weights=[0, 100])
        >>> found.rows[0].max_deviation > found.rows[1].max_deviation
        True
    """
    given = as_numbers(weights)
    if given.ndim != 1 or not given.size or not ((given >= 0) & np.isfinite(given)).all():
        raise InputError("study", [Problem("weights", f"must be numbers of 0 or more, found {weights!r:.60}")])
    rows = []
    for weight in sorted(given.tolist()):
        curve = minimum(waypoints, times, derivative, guide=weight, corridor=corridor)
        rows.append(measured(curve, np.asarray(waypoints, float), weight, derivative))
    return Study(np.array(waypoints, float), np.array(times, float), derivative, tuple(rows), corridor)


def measured(curve: PiecewisePolynomial, points: Array, weight: float, derivative: int) -> Tradeoff:
    """Return the numbers of one trajectory for waypoints (n, d) m."""
    t = curve.knots[:-1, None] + curve.durations[:, None] * (np.arange(SAMPLES) + 0.5) / SAMPLES
    squares = distance(curve(t), points) ** 2
    mean = (squares.mean(axis=1) * curve.durations).sum() / curve.duration
    return Tradeoff(
        weight=weight,
        curve=curve,
        max_deviation=largest_deviation(curve, points).value,
        rms_deviation=float(np.sqrt(mean)),
        max_speed=largest_norm(curve, 1).value,
        max_acceleration=largest_norm(curve, 2).value,
        cost=curve.cost(derivative),
        guide_error=Guide(chord(points, curve.durations)).error(curve),
    )


def distance(positions: Array, points: Array) -> Array:
    """Return the distance (...) m of positions (..., d) from the line through points (n, d)."""
    nearest = np.full(positions.shape[:-1], np.inf)
    for start, end in pairwise(points):
        leg = end - start
        share = np.clip((positions - start) @ leg / max(float(leg @ leg), np.finfo(float).tiny), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(positions - start - share[..., None] * leg, axis=-1))
    return nearest
