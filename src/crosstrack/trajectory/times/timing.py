"""Durations for the legs between waypoints, and the time of a whole trajectory stretched to limits."""

from math import perm

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.trajectory.arguments import is_number
from crosstrack.trajectory.certified.extremes import largest_norm
from crosstrack.trajectory.conditions import numbers
from crosstrack.trajectory.limits import VERTICAL, MotionLimits, limit_faults
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

SLACK = 4e-9
"""relative, by which limits are undercut: more than certified extremes may differ by when they are taken again"""
AT_REST = 1e-6
"""of its maximum, up to which a derivative at the ends counts as zero"""


@reported_by("constant_speed")
def constant_speed(waypoints: ArrayLike, limits: MotionLimits | None = None, *, total: float | None = None) -> Array:
    """Return durations (N,) s in proportion to the lengths of the legs.

    A climbing leg is no faster than the vertical limit allows. With a total no limits are needed.

    Args:
        waypoints: (N + 1, d) m, no two neighbours the same
        limits: `speed`, `speed_vertical`; the others are not looked at
        total: s, that the durations are scaled to

    Raises:
        InputError: all that is wrong with the arguments.
    """
    return _allocated(waypoints, limits or _unit(total), ("speed",), total)


@reported_by("square_root")
def square_root(waypoints: ArrayLike, limits: MotionLimits | None = None, *, total: float | None = None) -> Array:
    """Return durations (N,) s in proportion to the square roots of the lengths of the legs.

    It is the time from rest to rest with full acceleration, then full deceleration: 2 √(length / acceleration).

    Args:
        waypoints: (N + 1, d) m, no two neighbours the same
        limits: `acceleration`, `acceleration_vertical`; the others are not looked at
        total: s, that the durations are scaled to; with it no limits are needed

    Raises:
        InputError: all that is wrong with the arguments.
    """
    return _allocated(waypoints, limits or _unit(total), ("acceleration",), total)


@reported_by("trapezoid")
def trapezoid(waypoints: ArrayLike, limits: MotionLimits, *, total: float | None = None) -> Array:
    """Return durations (N,) s from rest to rest on every leg: accelerate, cruise where there is room, decelerate.

        T = l/v + v/a where l > v²/a, else 2 √(l/a)

    with the largest speed v and acceleration a along the leg that keep within all four limits.

    Args:
        waypoints: (N + 1, d) m, no two neighbours the same
        limits: `speed`, `acceleration` and their vertical ones; jerk is not looked at
        total: s, that the durations are scaled to

    Raises:
        InputError: all that is wrong with the arguments.
    """
    return _allocated(waypoints, limits, ("speed", "acceleration"), total)


def rescaled(curve: PiecewisePolynomial, limits: MotionLimits) -> PiecewisePolynomial:
    """Return the same curve in space, in the least time at which limits hold, certified for every instant.

    Stretched by α its derivatives of order k are α^-k as large, so α = max (peak / limit)^(1/k): the tightest limit is
    met, and all others hold. Derivatives at the ends change too, so they must be zero, or those of a loop.

    Raises:
        InputError: no limit is given, one is not positive, or the curve moves at its ends or not at all.
    """
    dimensions = curve.coefficients.shape[2]
    found = limit_faults(limits, dimensions)
    if not found and not limits.bounds(dimensions):
        found.append(Problem("limits", "must hold at least one limit"))
    found += _moving(curve)
    if found:
        raise InputError("rescaled", found)
    factor = haste(curve, limits)
    if factor == 0.0:
        raise InputError("rescaled", [Problem("curve", "does not move in any way that the limits bound")])
    return stretched(curve, factor * (1.0 + SLACK))


def haste(curve: PiecewisePolynomial, limits: MotionLimits) -> float:
    """Return max (peak / limit)^(1/k) over the limits, with certified peaks: above 1 the curve is too fast."""
    return max(
        float((largest_norm(curve, order, axes).value / most) ** (1.0 / order))
        for _, order, axes, most in limits.bounds(curve.coefficients.shape[2])
    )


def stretched(curve: PiecewisePolynomial, factor: float) -> PiecewisePolynomial:
    """Return the same curve in space, flown in `factor` times the time."""
    powers = np.arange(curve.coefficients.shape[1])
    return PiecewisePolynomial(curve.durations * factor, curve.coefficients / factor ** powers[:, None])


def total_fault(total: float | None) -> list[Problem]:
    """Return what is wrong with a total duration."""
    if total is None or (is_number(total) and 0 < total < np.inf):
        return []
    return [Problem("total", f"must be above 0 s and finite, found {total!r:.60}")]


def legs(waypoints: ArrayLike, found: list[Problem]) -> Array:
    """Return the legs (N, d) m between waypoints, or tell what is wrong with these."""
    points = numbers("waypoints", waypoints, 2, found)
    if points.size and len(points) < 2:
        found.append(Problem("waypoints", f"must be at least 2, found {len(points)}"))
    if not points.size or len(points) < 2:
        return np.empty((0, 0))
    steps = np.diff(points, axis=0)
    for k in np.flatnonzero((steps == 0.0).all(axis=1)):
        message = f"must not repeat waypoints[{k}]: a leg of no length takes no time of its own"
        found.append(Problem(f"waypoints[{k + 1}]", message))
    return steps


def _unit(total: float | None) -> MotionLimits:
    """Return limits of one where a total alone decides, else none."""
    return MotionLimits() if total is None else MotionLimits(speed=1.0, acceleration=1.0)


def _allocated(waypoints: ArrayLike, limits: MotionLimits, needed: tuple[str, ...], total: float | None) -> Array:
    """Return the time on every leg from rest to rest under the limits that are needed and their vertical ones."""
    found: list[Problem] = []
    steps = legs(waypoints, found)
    found += limit_faults(limits, steps.shape[1] if steps.size else 3)
    if isinstance(limits, MotionLimits):
        found += [Problem(f"limits.{name}", "must be given") for name in needed if getattr(limits, name) is None]
    found += total_fault(total)
    if found:
        raise InputError("times", found)
    lengths = np.linalg.norm(steps, axis=1)
    speeds = along(steps, lengths, limits.speed, limits.speed_vertical)
    durations: Array = lengths / speeds
    if "acceleration" in needed:
        accelerations = along(steps, lengths, limits.acceleration, limits.acceleration_vertical)
        durations = 2.0 * np.sqrt(lengths / accelerations)
        if "speed" in needed:
            cruises = lengths > speeds**2 / accelerations
            durations = np.where(cruises, lengths / speeds + speeds / accelerations, durations)
    return durations if total is None else durations * (total / durations.sum())


def along(steps: Array, lengths: Array, most: float | None, vertical: float | None) -> Array:
    """Return the largest speed or acceleration (N,) along the legs that keeps within a limit and a vertical one."""
    found = np.full(len(steps), np.inf if most is None else most, float)
    if vertical is not None:
        heights = np.abs(steps[:, VERTICAL[0]])
        climbs = heights > 0.0
        found[climbs] = np.minimum(found[climbs], vertical * lengths[climbs] / heights[climbs])
    return found


def _moving(curve: PiecewisePolynomial) -> list[Problem]:
    """Return at which ends a curve that is no loop moves."""
    found: dict[str, Problem] = {}
    for order in range(1, (curve.degree + 1) // 2):
        small = AT_REST * largest_norm(curve, order, tolerance=1e-3).value
        first = perm(order) * curve.coefficients[0, order]
        last = curve(curve.duration, order)
        if np.linalg.norm(first - last) <= small:
            continue
        for place, value in (("start", first), ("end", last)):
            if np.linalg.norm(value) > small:
                message = f"must be at rest to stretch time, found the derivative {value.tolist()} of order {order}"
                found.setdefault(place, Problem(f"curve.{place}", message))
    return list(found.values())
