"""Many trajectories of one shape in one call."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.arguments import as_numbers
from crosstrack.trajectory.banded import COLUMNS, GUIDES, kernel
from crosstrack.trajectory.closed_form import LOST
from crosstrack.trajectory.conditions import order_faults
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.types import Array

TOGETHER = 512
"""trajectories that are solved for in one call, few enough to stay in the processor's cache"""


def minimum_batch(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int = 3,
    *,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
) -> Array:
    """Return the coefficients of many minimum-derivative trajectories, each as `minimum` makes it without guides.

    Args:
        waypoints: (m, n, d) m, of m trajectories
        times: (m, n) s, increasing along each
        derivative: s, 2 for acceleration, 3 for jerk, 4 for snap
        start: (m, k, d) or (k, d) velocity, acceleration, ... at the first waypoints, k < s; rows of NaN are free, rows
            that are not there are zero
        end: likewise at the last

    Returns:
        shape (m, n - 1, 2 s, d), ascending powers of the local time of each segment.

    Raises:
        InputError: all that is wrong with the arguments, or one trajectory is undetermined.
    """
    points, moments = as_numbers(waypoints), as_numbers(times)
    found = _faults(points, moments, derivative)
    if found:
        raise InputError("minimum_batch", found)
    count, length, dimensions = points.shape
    ends = np.zeros((count, 2, derivative - 1, dimensions))
    found += [*_fill("start", start, ends[:, 0]), *_fill("end", end, ends[:, 1])]
    if found:
        raise InputError("minimum_batch", found)
    out = np.empty((count, length - 1, 2 * derivative, dimensions))
    bad = np.zeros(count, dtype=bool)
    for first in range(0, count, TOGETHER):
        part = slice(first, first + TOGETHER)
        bad[part] = _solve(points[part], np.diff(moments[part], axis=1), ends[part], out[part])
    for k in np.flatnonzero(bad):
        try:
            single = minimum(points[k], moments[k], derivative, start=ends[k, 0], end=ends[k, 1])
        except InputError as error:
            problems = [Problem(f"{problem.place}[{k}]", problem.message) for problem in error.problems]
            raise InputError("minimum_batch", problems) from None
        out[k] = single.coefficients
    return out


def _solve(points: Array, durations: Array, ends: Array, out: Array) -> NDArray[np.bool_]:
    """Fill in the coefficients of some trajectories; return which (m,) have lost too many digits or all."""
    count, length, dimensions = points.shape
    s, nothing = out.shape[2] // 2, (np.empty((0, GUIDES)), np.empty((0, out.shape[2], COLUMNS)))
    coefficients, least = np.empty((count * (length - 1), 2 * s, COLUMNS)), np.empty(count)
    for first in range(0, dimensions, COLUMNS):
        axes = slice(first, min(first + COLUMNS, dimensions))
        width = axes.stop - first
        knots = np.full((count, length, s, COLUMNS), np.nan)
        knots[:, :, 0, :width] = points[:, :, axes] - points[:, :1, axes]
        knots[:, [0, -1], 1:, :width] = ends[..., axes]
        knots[..., width:] = 0.0
        kernel(s)(durations.ravel(), knots.reshape(-1, s, COLUMNS), *nothing, coefficients, least)
        out[..., axes] = coefficients[:, :, :width].reshape(*out.shape[:3], width)
    out[:, :, 0] += points[:, :1]
    return np.asarray(~(least > LOST) | ~np.isfinite(out[:, :, -1]).all(axis=(1, 2)))


def _faults(points: Array, moments: Array, derivative: int) -> list[Problem]:
    """Return what is wrong with waypoints and times."""
    found = order_faults(derivative)
    if points.ndim != 3 or points.shape[1] < 2 or points.size == 0:
        found.append(Problem("waypoints", f"must have the shape (m, n, d) with n of at least 2, found {points.shape}"))
    elif moments.shape != points.shape[:2]:
        found.append(Problem("times", f"must have the shape {points.shape[:2]}, found {moments.shape}"))
    for name, array in (("waypoints", points), ("times", moments)):
        if array.ndim and not np.isfinite(array).all():
            where = np.argwhere(~np.isfinite(array))[0].tolist()
            found.append(Problem(f"{name}{where}", f"must be a finite number, found {array[tuple(where)]}"))
    if not found and not (rising := np.diff(moments, axis=1) > 0).all():
        trajectory, k = np.argwhere(~rising)[0]
        before, after = moments[trajectory, k : k + 2]
        found.append(Problem(f"times[{trajectory}, {k + 1}]", f"must be after {before:g} s, found {after:g} s"))
    return found


def _fill(name: str, value: ArrayLike | None, knot: Array) -> list[Problem]:
    """Write the derivatives given at one end into (m, s - 1, d)."""
    count, most, dimensions = knot.shape
    if value is None:
        return []
    rows = as_numbers(value)
    if rows.ndim not in {2, 3} or rows.shape[-1] != dimensions or rows.shape[-2] > most:
        allowed = f"(k, {dimensions}) or ({count}, k, {dimensions}) with k of at most {most}"
        return [Problem(name, f"must have the shape {allowed}, found {rows.shape}")]
    if rows.ndim == 3 and len(rows) != count:
        return [Problem(name, f"must be one for each of the {count} trajectories, found {len(rows)}")]
    missing = np.isnan(rows)
    if np.isinf(rows).any() or (missing.any(axis=-1) & ~missing.all(axis=-1)).any():
        return [Problem(name, "must have rows that are finite, or NaN as a whole")]
    knot[:, : rows.shape[-2]] = rows
    return []
