"""Solving the conditions of a trajectory in closed form, closed loops too."""

from dataclasses import replace

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory import banded, graded, hermite
from crosstrack.trajectory.banded import COLUMNS, GUIDES
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

LOST = 1e-2
"""relative pivot of the elimination below which orthogonal transformations take over"""
UNDETERMINED = 1e-13
"""relative diagonal of their triangle below which nothing determines a derivative"""
ENDS = np.array([0, -1])
"""first and last knot"""


def closed_form(asked: Conditions) -> PiecewisePolynomial:
    """Return the trajectory that meets conditions at the least cost, in O(N).

    Raises:
        InputError: the conditions leave it undetermined, or the durations are out of all proportion.
    """
    if asked.periodic:
        asked = closed_loop(asked)
    coefficients = solved(asked, asked.knots.copy())
    coefficients[:, 0] += asked.origin
    return PiecewisePolynomial(asked.durations, coefficients)


def solved(asked: Conditions, knots: Array) -> Array:
    """Return the coefficients (N, 2 s, columns) for knots (N + 1, s, columns), and fill in what is free of these.

    The columns share everything but their numbers, so that any number of them is solved for in groups.
    """
    segments, (s, columns) = len(asked.durations), knots.shape[1:]
    if columns == COLUMNS:
        return _solved(asked, knots, asked.loads)
    coefficients = np.empty((segments, 2 * s, columns))
    for first in range(0, columns, COLUMNS):
        part = slice(first, min(first + COLUMNS, columns))
        width = part.stop - first
        few = np.zeros((segments + 1, s, COLUMNS))
        loads = np.zeros((len(asked.loads), 2 * s, COLUMNS))
        few[:, :, :width], loads[:, :, :width] = knots[:, :, part], asked.loads[:, :, part]
        coefficients[:, :, part] = _solved(asked, few, loads)[:, :, :width]
        knots[:, :, part] = few[:, :, :width]
    return coefficients


def _solved(asked: Conditions, knots: Array, loads: Array) -> Array:
    s = knots.shape[1]
    given, coefficients, least = knots.copy(), np.empty((len(asked.durations), 2 * s, COLUMNS)), np.empty(1)
    banded.kernel(s)(asked.durations, knots, asked.weights, loads, coefficients, least)
    if not least[0] > LOST:
        knots[:] = given
        graded.kernel(s)(asked.durations, knots, asked.weights, loads, coefficients, least)
    if not least[0] > UNDETERMINED:
        raise InputError("minimum", [Problem("waypoints", _undetermined(asked))])
    if not np.isfinite(coefficients).all():
        raise InputError("minimum", [Problem("times", "are too short or too long: the coefficients are not finite")])
    return coefficients


def _undetermined(asked: Conditions) -> str:
    given = int((~np.isnan(asked.knots[:, 1:, 0])).sum())
    return (
        f"leave the trajectory undetermined: {len(asked.knots)} waypoints and {given} derivatives are given, and "
        f"curves without derivative {asked.order} meet them all; fix more of `start`, `end` or `velocities`"
    )


def closed_loop(asked: Conditions) -> Conditions:
    """Return the conditions with the derivatives at the ends of a loop that minimise its cost.

    The curve is linear in them: with the curve that has zeros there, and one for each that has a one there and all
    else zero, they are at most s - 1 unknowns of a least-squares problem: the cost is a sum of squares, see `graded`.
    """
    knots, columns = asked.knots, asked.knots.shape[2]
    free = np.flatnonzero(np.isnan(knots[0, :, 0]))
    ones = np.where(np.isnan(knots[:, :, :1]), np.nan, 0.0).repeat(len(free), axis=2)
    both = np.concatenate([knots, ones], axis=2)
    both[np.ix_(ENDS, free)] = 0.0
    for column, row in enumerate(free):
        both[ENDS, row, columns + column] = 1.0
    loads = np.concatenate([asked.loads, np.zeros((*asked.loads.shape[:2], len(free)))], axis=2)
    solved(replace(asked, loads=loads), both)
    found = residuals(asked, ends(asked.durations, both))
    matrix, off = found[:, columns:], found[:, :columns] - drawn(asked)
    sizes = np.linalg.norm(matrix, axis=0)
    closed = knots.copy()
    closed[np.ix_(ENDS, free)] = -np.linalg.lstsq(matrix / sizes, off, rcond=None)[0] / sizes[:, None]
    return replace(asked, knots=closed)


def ends(durations: Array, knots: Array) -> Array:
    """Return the ends z (N, 2 s, d) of every segment, see `hermite`, with its first point as the origin."""
    scaled = durations[:, None, None] ** np.arange(knots.shape[1])[:, None]
    z = np.concatenate([knots[:-1] * scaled, knots[1:] * scaled], axis=1)
    z[:, knots.shape[1]] -= z[:, 0]
    z[:, 0] = 0.0
    return z


def residuals(asked: Conditions, z: Array) -> Array:
    """Return the rows (rows, d) whose squares add up to the quadratic part of the cost of ends z (N, 2 s, d)."""
    s, spans = asked.order, asked.durations[:, None, None]
    rows = [spans ** (0.5 - s) * (hermite.root(s, s) @ z)]
    for order in range(GUIDES) if asked.weights.size else ():
        weight = asked.weights[:, order, None, None]
        rows.append(np.sqrt(weight) * spans ** (0.5 - order) * (hermite.root(s, order) @ z))
    return np.concatenate([row.reshape(-1, z.shape[2]) for row in rows])


def drawn(asked: Conditions) -> Array:
    """Return what the guides draw `residuals` to, (rows, d): the lowest order takes the linear terms of all."""
    s, spans, dimensions = asked.order, asked.durations[:, None, None], asked.knots.shape[2]
    rows, loaded = [np.zeros((len(spans) * s, dimensions))], np.zeros(len(spans), bool)
    for order in range(GUIDES) if asked.weights.size else ():
        weight = asked.weights[:, order]
        takes = (weight > 0.0) & ~loaded
        scale = np.sqrt(np.where(takes, weight, 1.0))[:, None, None] * spans ** (0.5 - order)
        found = np.linalg.pinv(hermite.root(s, order).T) @ asked.loads / scale
        rows.append(np.where(takes[:, None, None], found, 0.0).reshape(-1, dimensions))
        loaded |= takes
    return np.concatenate(rows)
