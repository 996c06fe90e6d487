"""A curve given by time, seen as a path by arc length."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.path.arc_length import edges_of, end_tangents, grid, lengths, split
from crosstrack.path.cells import clock, closest, evaluate, evaluated
from crosstrack.protocols import Trajectory
from crosstrack.types import Array

SAME_STOP = 1e-6
"""m, stops closer than this are one"""


@dataclass(frozen=True, eq=False)
class Traced:
    """The path that a trajectory traces: cell k is p(w), S(w) with the local time w in [-1, 1].

    Point and arc length are within 1e-9 of the length. Where the trajectory rests, the tangent is the one it leaves
    with, at the end the one it comes with, and the curvature is given as zero.
    """

    knots: Array
    """(cells + 1,) m, arc length where each cell starts, and the whole length"""
    arcs: Array
    """(cells, 9) m, arc length since the start of the cell, ascending powers of w"""
    points: Array
    """(cells, 9, 3) m, ascending powers of w"""
    velocities: Array
    """(cells, 8, 3) m/s, ascending powers of w"""
    tangents: Array
    """(cells, 2, 3) unit, at the ends of each cell"""
    middles: Array
    """(cells,) s, time at w = 0"""
    halves: Array
    """(cells,) s, time from w = 0 to w = 1"""
    stops: Array
    """(stops,) m, where the speed has a deep minimum: rests, turns on the spot; not the end"""

    @property
    def length(self) -> float:
        """m"""
        return float(self.knots[-1])

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (m, shape (...)): point, unit tangent or curvature vector for order 0, 1, 2."""
        if isinstance(s, float):
            return evaluated(s, order, *self.arrays)
        s = np.asarray(s, float)
        out = np.empty((s.size, 3))
        evaluate(s.ravel(), order, *self.arrays, out)
        return out.reshape((*s.shape, 3))

    def project(self, point: Array, near: float, reach: float) -> float:
        """Return the arc length in [near, near + reach] whose point is closest to `point` (3,), the first of equals."""
        return float(closest(point, near, near + reach, *self.arrays))

    def time(self, s: float | Array) -> Array:
        """Return when the trajectory is at arc length `s` (m, shape (...)), (...) s; of a rest, its end."""
        s = np.asarray(s, float)
        out = np.empty(s.size)
        clock(s.ravel(), self.knots, self.arcs, self.middles, self.halves, out)
        return out.reshape(s.shape)

    def at(self, t: float | Array) -> Array:
        """Return the arc length (m, shape (...)) at the time `t` (s)."""
        t = np.asarray(t, float)
        k = np.clip(np.searchsorted(self.middles - self.halves, t, side="right") - 1, 0, len(self.halves) - 1)
        w = np.clip((t - self.middles[k]) / self.halves[k], -1.0, 1.0)
        since = np.einsum("...i,...i->...", self.arcs[k], w[..., None] ** np.arange(self.arcs.shape[1]))
        return np.asarray(self.knots[k] + np.where(w > -1.0, np.maximum(since, 0.0), 0.0))

    @cached_property
    def arrays(self) -> tuple[Array, Array, Array, Array, Array, Array]:
        """The fields in the order the compiled functions take them"""
        return self.knots, self.arcs, self.points, self.velocities, self.tangents, self.halves


def traced(trajectory: Trajectory) -> Traced:
    """Return the path of a trajectory in space.

    Raises:
        InputError: the trajectory is not in space, not finite, or goes nowhere.
    """
    check(trajectory)
    cells, stopped = split(trajectory)
    if not len(cells.halves):
        raise InputError("trajectory", [Problem("", "it stands still: there is no path")])
    arcs = integrated(cells.speeds[:, :, None], cells.halves)[:, :, 0]
    points = integrated(cells.velocities, cells.halves)
    points[:, 0] += cells.starts
    path = Traced(
        knots=np.concatenate([[0.0], np.cumsum(lengths(cells))]),
        arcs=arcs,
        points=points,
        velocities=np.ascontiguousarray(cells.velocities),
        tangents=end_tangents(cells),
        middles=cells.middles,
        halves=cells.halves,
        stops=np.empty(0),
    )
    return replace(path, stops=at_knots(path, stopped))


def at_knots(path: Traced, times: Array) -> Array:
    """Return the arc lengths (m) of times (s) at the ends of cells, each once, less the end of the path."""
    k = np.unique(np.round(np.interp(path.at(times), path.knots, np.arange(len(path.knots)))).astype(int))
    stops = path.knots[k[k < len(path.knots) - 1]]
    return np.asarray(stops[np.diff(stops, append=np.inf) > SAME_STOP])


def check(trajectory: Trajectory) -> None:
    """Raise InputError unless the trajectory lasts a while, is three-dimensional and finite in every piece."""
    if not 0 < trajectory.duration < np.inf:
        raise InputError("trajectory", [Problem("duration", f"{trajectory.duration} s, must be positive and finite")])
    ends = trajectory(np.array([0.0, trajectory.duration]))
    if ends.shape != (2, 3):
        raise InputError("trajectory", [Problem("", f"{ends.shape[-1]} dimensions, a flight needs 3")])
    times = grid(edges_of(trajectory))
    wrong = np.flatnonzero(~np.isfinite(trajectory(times, 1) + trajectory(times)).all(axis=1))
    if wrong.size:
        raise InputError("trajectory", [Problem("", f"it is not finite at t = {times[wrong[0]]:.6g} s")])


def integrated(coefficients: Array, halves: Array) -> Array:
    """Return ∫ of polynomials (n, m, d) of w over time from w = -1, (n, m + 1, d)."""
    powers = np.arange(1, coefficients.shape[1] + 1)
    out = np.zeros((len(coefficients), len(powers) + 1, coefficients.shape[2]))
    out[:, 1:] = coefficients * halves[:, None, None] / powers[:, None]
    out[:, 0] = -(out[:, 1:] * ((-1.0) ** powers)[:, None]).sum(axis=1)
    return out
