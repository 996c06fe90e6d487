"""The arc length of a curve given by time: cells in which velocity and speed are polynomials."""

from dataclasses import dataclass
from math import comb
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Trajectory
from crosstrack.types import Array

TOLERANCE = 1e-9
"""of its length, the error of position and arc length that a cell may have"""
NEGLIGIBLE = 1e-13
"""of the longest distance that the curve could go, an error that is none"""
TURN = 0.8
"""rad, the most that the tangent turns within a cell"""
POINTLIKE = 1e-8
"""of the same distance, the length of a cell that may turn as it likes"""
HALVINGS = 40
"""most times that a cell is halved"""
MOST = 1_000_000
"""cells halved at once; smooth curves need a few for each piece"""
AT_REST = 1e-8
"""of the highest Taylor term of a cell, a term that is none"""
SLOW = 0.01
"""of the top speed, below which a minimum of the speed counts as a stop"""
GRID = 16
"""samples of every piece, to find the stops"""

NODES = np.polynomial.legendre.leggauss(8)[0]
"""(8,) local times of the nodes of Gauss and Legendre"""
CHECKS = np.array([-0.999, -0.88, -0.66, -0.36, 0.0, 0.36, 0.66, 0.88, 0.999])
"""local times between the nodes, where a cell is judged"""
FIT = np.linalg.inv(np.vander(NODES, increasing=True))
"""(8, 8) ascending coefficients from values at the nodes"""
AT_CHECKS = np.vander(CHECKS, 8, increasing=True) @ FIT


@runtime_checkable
class Pieced(Protocol):
    """A curve that says where it is not smooth."""

    @property
    def knots(self) -> Array:
        """(n,) s, increasing from 0 to the duration"""


@dataclass(frozen=True, eq=False)
class Cells:
    """Stretches of a curve, each a polynomial of the local time w in [-1, 1]."""

    middles: Array
    """(cells,) s"""
    halves: Array
    """(cells,) s, half of how long each lasts"""
    velocities: Array
    """(cells, 8, 3) m/s, ascending powers of w"""
    speeds: Array
    """(cells, 8) m/s, ascending powers of w"""
    starts: Array
    """(cells, 3) m, where each begins"""


def split(trajectory: Trajectory) -> tuple[Cells, Array]:
    """Cut a curve into cells as short as the tolerance needs, and return them with the times of the stops (s).

    A cell holds the polynomials through velocity and speed at the eight nodes of Gauss and Legendre, so its length
    is their quadrature. It is halved until both agree with the curve between the nodes. Stops, where the speed is
    not smooth, are at the ends of cells; stretches at rest are in none.

    Raises:
        InputError: the curve is so rough that cells of it would fill the memory.
    """
    edges, stopped = with_stops(trajectory, edges_of(trajectory))
    low, high = edges[:-1], edges[1:]
    longest = float(top_speed(trajectory, edges)) * trajectory.duration
    done: list[Cells] = []
    for level in range(HALVINGS + 1):
        cells, fits = fitted(trajectory, low, high, longest)
        fits |= level == HALVINGS
        done.append(chosen(cells, fits))
        low, high = low[~fits], high[~fits]
        if not len(low):
            break
        if len(low) > MOST:
            raise InputError(
                "trajectory", [Problem("", f"its speed is not smooth at t = {low[0]:.6g} s and elsewhere")]
            )
        middle = 0.5 * (low + high)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    every = Cells(*(np.concatenate(parts) for parts in zip(*(vars(cells).values() for cells in done), strict=True)))
    every = chosen(every, np.argsort(every.middles))
    return chosen(every, lengths(every) > NEGLIGIBLE * longest), stopped


def edges_of(trajectory: Trajectory) -> Array:
    """Return the times (s) where a curve need not be smooth: its knots where it has any, an even few otherwise."""
    if isinstance(trajectory, Pieced):
        return np.asarray(trajectory.knots, float)
    return np.linspace(0.0, trajectory.duration, 9)


def fitted(trajectory: Trajectory, low: Array, high: Array, longest: float) -> tuple[Cells, NDArray[np.bool_]]:
    """Return a cell for each stretch from `low` to `high` (s, shape (n,)), and whether it is good enough."""
    middles, halves = 0.5 * (low + high), 0.5 * (high - low)
    at_nodes = trajectory(middles[:, None] + halves[:, None] * NODES, 1)
    at_checks = trajectory(middles[:, None] + halves[:, None] * CHECKS, 1)
    speeds, checks = np.linalg.norm(at_nodes, axis=2), np.linalg.norm(at_checks, axis=2)
    astray = np.linalg.norm(at_checks - AT_CHECKS @ at_nodes, axis=2).max(axis=1)
    error = halves * np.maximum(astray, np.abs(checks - speeds @ AT_CHECKS.T).max(axis=1))
    cells = Cells(middles, halves, FIT @ at_nodes, speeds @ FIT.T, trajectory(low))
    length = lengths(cells)
    straight = (turning(at_checks, checks) <= TURN) | (length <= POINTLIKE * longest)
    fits: NDArray[np.bool_] = straight & (error <= TOLERANCE * length + NEGLIGIBLE * longest)
    return cells, fits


def turning(velocities: Array, speeds: Array) -> Array:
    """Return by how much the direction of velocities (n, m, 3) turns along the axis of length m, (n,) rad."""
    scale = np.maximum(speeds, 1e-12 * speeds.max(axis=1, keepdims=True))
    directions = velocities / np.where(scale > 0, scale, 1.0)[:, :, None]
    steps = np.linalg.norm(np.diff(directions, axis=1), axis=2)
    return np.asarray(2 * np.arcsin(np.minimum(1.0, 0.5 * steps)).sum(axis=1))


def chosen(cells: Cells, which: NDArray[np.bool_] | NDArray[np.intp]) -> Cells:
    """Return some of the cells, by index or mask."""
    return Cells(*(values[which] for values in vars(cells).values()))


def lengths(cells: Cells) -> Array:
    """Return the arc lengths (cells,) m."""
    even = np.arange(0, cells.speeds.shape[1], 2)
    return np.asarray(2 * cells.halves * (cells.speeds[:, even] / (even + 1)).sum(axis=1))


def top_speed(trajectory: Trajectory, edges: Array) -> float:
    """Return the greatest speed (m/s) on a grid between the edges (s)."""
    return float(np.linalg.norm(trajectory(grid(edges), 1), axis=1).max())


def grid(edges: Array) -> Array:
    """Return the edges (s) with the times that divide every stretch between them into equal parts."""
    inner = edges[:-1, None] + np.diff(edges)[:, None] * np.arange(GRID) / GRID
    return np.append(inner.ravel(), edges[-1])


def with_stops(trajectory: Trajectory, edges: Array) -> tuple[Array, Array]:
    """Add to the edges (s) the times between them where the speed has a deep minimum; and return all such times.

    The start counts where it is slow, the end does not.
    """
    times = grid(edges)
    speed = np.linalg.norm(trajectory(times, 1), axis=1)
    slow = SLOW * speed.max()
    left, right = np.append(np.inf, speed[:-1]), np.append(speed[1:], -np.inf)
    lowest = np.flatnonzero((speed <= left) & (speed <= right))
    at_edge = (lowest % GRID == 0) & (speed[lowest] < AT_REST * slow)
    fixed, loose = times[lowest[at_edge]], lowest[~at_edge & (lowest > 0)]
    found = least_speed(trajectory, times[loose - 1], times[loose + 1]) if len(loose) else np.empty(0)
    deep = found[np.linalg.norm(trajectory(found, 1), axis=1) < slow]
    begin = [0.0] if speed[0] < slow else []
    return np.union1d(edges, deep), np.union1d(np.append(fixed, begin), deep)


def least_speed(trajectory: Trajectory, low: Array, high: Array) -> Array:
    """Return the times (n,) of the least speed between `low` and `high` (n,), by golden section."""
    ratio = 0.5 * (np.sqrt(5.0) - 1)
    for _ in range(80):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        speeds = np.linalg.norm(trajectory(np.array([left, right]), 1), axis=2)
        falls = speeds[0] > speeds[1]
        low, high = np.where(falls, left, low), np.where(falls, high, right)
    return np.asarray(0.5 * (low + high))


def end_tangents(cells: Cells) -> Array:
    """Return the unit tangents at both ends of each cell, (cells, 2, 3), as limits where it begins or ends at rest."""
    degree = cells.velocities.shape[1] - 1
    out = np.empty((len(cells.halves), 2, 3))
    for end, sign in enumerate((-1.0, 1.0)):
        shift = np.array(
            [[comb(j, i) * sign ** (j - i) if j >= i else 0.0 for j in range(degree + 1)] for i in range(degree + 1)]
        )
        terms = shift @ cells.velocities
        sizes = np.linalg.norm(terms, axis=2)
        first = (sizes > AT_REST * sizes.max(axis=1, keepdims=True)).argmax(axis=1)
        rows = np.arange(len(first))
        facing = np.where((first % 2 == 1) & (sign > 0), -1.0, 1.0)
        out[:, end] = facing[:, None] * terms[rows, first] / sizes[rows, first][:, None]
    return out
