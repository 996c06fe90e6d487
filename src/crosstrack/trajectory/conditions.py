"""What a trajectory must meet and minimise, checked and as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.arguments import is_number
from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.guide import Guide, chord_loads
from crosstrack.types import Array

ORDERS = (2, 3, 4)
"""derivatives that can be minimised"""


@dataclass(frozen=True, eq=False)
class Conditions:
    """A trajectory asked for: what is known at its knots, and the guides as quadratic and linear terms."""

    durations: Array
    """(N,) s"""
    knots: Array
    """(N + 1, s, d): position relative to the first waypoint, velocity, ...; NaN is free"""
    weights: Array
    """(N, 3) λ of guides of order 0, 1, 2 on each segment; (0, 3) without guides"""
    loads: Array
    """(N, 2 s, d) linear terms of the guides, see `banded.kernel`; (0, 2 s, d) without guides"""
    origin: Array
    """(d,) m, the first waypoint"""
    periodic: bool

    @property
    def order(self) -> int:
        """The derivative s that is minimised."""
        return int(self.knots.shape[1])


def conditions(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int,
    start: ArrayLike | None,
    end: ArrayLike | None,
    velocities: ArrayLike | None,
    periodic: bool,
    guide: float | Guide | Sequence[Guide] | None,
) -> Conditions:
    """Return the arguments of `minimum` as arrays.

    Raises:
        InputError: all that is wrong with them.
    """
    found: list[Problem] = []
    points, moments = numbers("waypoints", waypoints, 2, found), numbers("times", times, 1, found)
    found += order_faults(derivative)
    if not found:
        found += _fit(points, moments)
    if found:
        raise InputError("minimum", found)
    relative = points - points[0]
    knots = np.full((len(points), derivative, points.shape[1]), np.nan)
    knots[:, 0] = relative
    if velocities is not None:
        _velocities(velocities, knots, found)
    if periodic:
        _closed(knots, start, end, found)
    else:
        _ends(("start", start), ("end", end), knots, velocities is not None, found)
    guides = [guide] if isinstance(guide, Guide) else guide
    durations = np.diff(moments)
    weights, loads = _guides(guides, points, durations, knots, found)
    if found:
        raise InputError("minimum", found)
    return Conditions(durations, knots, weights, loads, points[0], periodic)


def order_faults(derivative: int) -> list[Problem]:
    """Return what is wrong with the derivative that is to be minimised."""
    if isinstance(derivative, int | np.integer) and derivative in ORDERS:
        return []
    return [Problem("derivative", f"must be 2, 3 or 4, found {derivative!r}")]


def numbers(name: str, value: ArrayLike, dimensions: int, found: list[Problem]) -> Array:
    """Return an argument as an array of finite numbers, or tell what is wrong with it."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        found.append(Problem(name, "must be an array of numbers, all rows equally long"))
        return np.empty(0)
    if array.ndim != dimensions or array.size == 0:
        shape = "(n, d)" if dimensions == 2 else "(n,)"
        found.append(Problem(name, f"must have the shape {shape}, found {array.shape}"))
        return np.empty(0)
    if not np.isfinite(array).all():
        where = np.argwhere(~np.isfinite(array))[0].tolist()
        found.append(Problem(f"{name}{where}", f"must be a finite number, found {array[tuple(where)]}"))
    return array


def _fit(points: Array, moments: Array) -> list[Problem]:
    """Check waypoints against times."""
    if len(points) < 2:
        return [Problem("waypoints", f"must be at least 2, found {len(points)}")]
    if len(moments) != len(points):
        return [Problem("times", f"must be one for each of the {len(points)} waypoints, found {len(moments)}")]
    steps = moments[1:] - moments[:-1]
    if (steps > 0).all():
        return []
    k = int(np.flatnonzero(~(steps > 0))[0]) + 1
    return [Problem(f"times[{k}]", f"must be after times[{k - 1}], {moments[k - 1]:g} s, found {moments[k]:g} s")]


def _velocities(velocities: ArrayLike, knots: Array, found: list[Problem]) -> None:
    given = _rows("velocities", velocities, knots.shape[2], found)
    if given is None:
        return
    if len(given) != len(knots):
        found.append(Problem("velocities", f"must be one for each of the {len(knots)} waypoints, found {len(given)}"))
        return
    knots[:, 1] = given


def _ends(
    start: tuple[str, ArrayLike | None],
    end: tuple[str, ArrayLike | None],
    knots: Array,
    with_velocities: bool,
    found: list[Problem],
) -> None:
    """Fill in the derivatives at both ends."""
    most = knots.shape[1] - 1
    for (name, value), knot in ((start, knots[0]), (end, knots[-1])):
        if value is None:
            knot[(2 if with_velocities else 1) :] = 0.0
            continue
        rows = _rows(name, value, knots.shape[2], found)
        if rows is None:
            continue
        if len(rows) > most:
            found.append(Problem(name, f"must have at most {most} rows, velocity and up, found {len(rows)}"))
            continue
        knot[1:] = 0.0
        knot[1 : 1 + len(rows)] = rows


def _rows(name: str, value: ArrayLike, dimensions: int, found: list[Problem]) -> Array | None:
    """Return rows of vectors of which each is finite or NaN as a whole, or tell what is wrong."""
    try:
        rows = np.asarray(value, float)
    except (TypeError, ValueError):
        found.append(Problem(name, "must be an array of numbers, all rows equally long"))
        return None
    if rows.size == 0:
        return np.empty((0, dimensions))
    if rows.ndim != 2 or rows.shape[1] != dimensions:
        found.append(Problem(name, f"must have the shape (k, {dimensions}), found {rows.shape}"))
        return None
    missing = np.isnan(rows)
    mixed = np.flatnonzero((missing.any(axis=1) & ~missing.all(axis=1)) | np.isinf(rows).any(axis=1))
    if mixed.size:
        message = f"must be finite, or NaN as a whole, found {rows[mixed[0]].tolist()}"
        found.append(Problem(f"{name}[{mixed[0]}]", message))
        return None
    return rows


def _closed(knots: Array, start: ArrayLike | None, end: ArrayLike | None, found: list[Problem]) -> None:
    """Check that a loop closes and that nothing is asked of its ends."""
    for name, value in (("start", start), ("end", end)):
        if value is not None:
            found.append(Problem(name, "must not be given with periodic: a loop has no ends"))
    if (knots[-1, 0] != knots[0, 0]).any():
        message = f"must be the first again to close the loop, found {knots[-1, 0].tolist()} m from it"
        found.append(Problem(f"waypoints[{len(knots) - 1}]", message))
    if knots.shape[1] > 1 and not np.array_equal(knots[0, 1], knots[-1, 1], equal_nan=True):
        found.append(Problem("velocities", "must be the same at both ends of a loop"))


def _guides(
    guides: float | Sequence[Guide] | None, points: Array, durations: Array, knots: Array, found: list[Problem]
) -> tuple[Array, Array]:
    """Return weights and loads of the guides."""
    s, dimensions = knots.shape[1:]
    if guides is None:
        return np.empty((0, GUIDES)), np.empty((0, 2 * s, dimensions))
    weights = np.zeros((len(durations), GUIDES))
    if not isinstance(guides, Sequence):
        if not is_number(guides) or not 0 <= guides < np.inf:
            found.append(Problem("guide", f"must be a weight of 0 or more, or guides, found {guides!r:.60}"))
            return weights, np.empty(0)
        weights[:, 0] = guides
        return weights, chord_loads(points, durations, weights[:, 0], s)
    if not all(isinstance(guide, Guide) for guide in guides):
        found.append(Problem("guide", f"must be a weight of 0 or more, or guides, found {guides!r:.60}"))
        return weights, np.empty(0)
    loads = np.zeros((len(durations), 2 * s, dimensions))
    moments = np.concatenate([[0.0], np.cumsum(durations)])
    for k, guide in enumerate(guides):
        wrong = guide.faults(len(durations), dimensions)
        found += [Problem(f"guide[{k}].{place}", message) for place, message in wrong]
        if not wrong:
            weights[:, guide.order] += guide.weight
            loads += guide.loads(moments, points[:-1], s)
    return weights, loads
