"""What makes numbers from a file a curve: finite, of sensible size, and without jumps."""

from collections.abc import Callable

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

MOST_BYTES = 1 << 26
MOST_PIECES = 100_000
MOST_DEGREE = 9
"""of a piece in a file; minimum snap has 7"""
SHORTEST, LONGEST = 1e-6, 1e6
"""s, of a piece"""
FARTHEST = 1e9
"""m, from the origin"""
GAP = 1e-3
"""m, most between the end of a piece and the beginning of the next: more than rounding, less than a vehicle feels"""
TOLD = 20
"""problems that are told of one file"""

Fault = tuple[int, str, str]
"""number of the piece, `duration` or `coefficients`, message"""
Locate = Callable[[int, str], tuple[str, int | None]]
"""from the first two of these to place and line"""


def curve_of(name: str, durations: Array, coefficients: Array, locate: Locate) -> PiecewisePolynomial:
    """Return the curve of durations (pieces,) s and coefficients (pieces, powers, 3).

    Raises:
        InputError: everything that is wrong with them.
    """
    found = sizes(durations, coefficients) or jumps(durations, coefficients)
    if found:
        told = [Problem(place, message, line) for i, what, message in found for place, line in [locate(i, what)]]
        raise InputError(name, told[:TOLD])
    return PiecewisePolynomial(durations, coefficients)


def sizes(durations: Array, coefficients: Array) -> list[Fault]:
    """Return what is not finite, too short, too long, or may lead too far."""
    allowed = (durations >= SHORTEST) & (durations <= LONGEST)
    found = [
        (int(i), "duration", f"must be between {SHORTEST:g} and {LONGEST:g} s, found {durations[i]:g}")
        for i in np.flatnonzero(~allowed)
    ]
    finite = np.isfinite(coefficients).all(axis=(1, 2))
    found += [(int(i), "coefficients", "must be finite numbers") for i in np.flatnonzero(~finite)]
    with np.errstate(over="ignore", invalid="ignore"):
        reach = (np.abs(coefficients) * powers_of(durations, coefficients)).sum(axis=1).max(axis=1)
    far = np.flatnonzero(finite & allowed & ~(reach <= FARTHEST))
    message = f"must stay within {FARTHEST:g} m of the origin on every axis, may reach"
    return [*found, *((int(i), "coefficients", f"{message} {reach[i]:.3g}") for i in far)]


def jumps(durations: Array, coefficients: Array) -> list[Fault]:
    """Return which pieces do not begin where the one before ends."""
    ends = (coefficients * powers_of(durations, coefficients)).sum(axis=1)
    gaps = np.linalg.norm(coefficients[1:, 0] - ends[:-1], axis=1)
    return [
        (int(i) + 1, "coefficients", f"begins {gaps[i]:.3g} m from where the piece before ends; at most {GAP:g} m")
        for i in np.flatnonzero(gaps > GAP)
    ]


def in_space(curve: PiecewisePolynomial) -> list[Problem]:
    """Return what keeps a curve from being written: other dimensions than x, y, z."""
    dimensions = curve.coefficients.shape[2]
    return [] if dimensions == 3 else [Problem("curve", f"must have 3 dimensions, found {dimensions}")]


def powers_of(durations: Array, coefficients: Array) -> Array:
    """Return the powers (pieces, powers, 1) of the durations that the coefficients are multiplied with at the end."""
    powers: Array = durations[:, None, None] ** np.arange(coefficients.shape[1])[:, None]
    return powers
