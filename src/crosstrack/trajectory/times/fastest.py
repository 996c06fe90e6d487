"""Smooth trajectories in the least time that limits allow."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.conditions import Conditions, conditions, order_faults
from crosstrack.trajectory.limits import Bound, MotionLimits, limit_faults
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.tightness import stretched_time
from crosstrack.trajectory.times.timing import legs, rescaled, square_root
from crosstrack.types import Array

POWERS = (128.0, 512.0)
"""of the norm that stands for the maximum, one after the other"""
FLAT = 1e-4
"""slope of log (total time) by log T at which the search has converged"""
GAIN = 1e-6
"""of log (total time) a step, below which the search has converged with many segments"""
DENSE = 64
"""segments up to which the search keeps all its knowledge of the curvature, and not that of the last steps"""


@dataclass(frozen=True, eq=False)
class Fastest:
    """A trajectory within limits, and how the search for its durations ended."""

    curve: PiecewisePolynomial
    """within every limit at every instant, certified, and at the tightest one"""
    converged: bool
    """whether a local minimum was reached for every power of the norm"""
    iterations: int


@reported_by("fastest")
def fastest(waypoints: ArrayLike, limits: MotionLimits, derivative: int = 3) -> Fastest:
    """Return the trajectory through waypoints, from rest to rest, that is over as soon as limits allow.

    It is the fastest of those that have least effort for their durations,

        min over T of Σ T_i α(T),      α = max over time and limits of (‖p⁽ᵏ⁾‖ / limit)^(1/k),

    and is then stretched by α, so that all limits hold and the tightest is met. The maximum is smoothed for the
    search: the limits are certified, the time is a local minimum to about 2 ‰. That the curve is smooth costs time
    against time-optimal control, which switches between the limits.

    Wang, Zhou, Xu & Gao, Geometrically Constrained Trajectory Optimization for Multicopters, IEEE T-RO 38 (2022).

    Args:
        waypoints: (n, d) m, at least two, no two neighbours the same
        limits: at least one
        derivative: s, whose squared integral is minimised: 2 for acceleration, 3 for jerk, 4 for snap

    Raises:
        InputError: all that is wrong with the arguments.
    """
    found = order_faults(derivative)
    steps = legs(waypoints, found)
    if steps.size:
        found += limit_faults(limits, steps.shape[1])
        if not found and not limits.bounds(steps.shape[1]):
            found.append(Problem("limits", "must hold at least one limit"))
    if found:
        raise InputError("fastest", found)
    times = np.concatenate([[0.0], np.cumsum(square_root(waypoints, total=float(len(steps))))])
    asked = conditions(waypoints, times, derivative, None, None, None, False, None)
    return _search(asked, limits, limits.bounds(steps.shape[1]))


def _search(asked: Conditions, limits: MotionLimits, bounds: list[Bound]) -> Fastest:
    """Minimise the stretched time with sharper and sharper norms, and keep the best of what they lead to."""
    y = np.log(asked.durations)
    best = _within(asked, y, limits)
    converged, iterations = True, 0
    for power in POWERS:
        objective = partial(_objective, asked, bounds, power)
        if len(y) <= DENSE:
            done = minimize(objective, y, jac=True, method="BFGS", options={"gtol": FLAT})
        else:
            options = {"gtol": FLAT, "ftol": GAIN, "maxcor": 20}
            done = minimize(objective, y, jac=True, method="L-BFGS-B", options=options)
        y = done.x
        converged, iterations = converged and bool(done.success), iterations + int(done.nit)
        best = min(best, _within(asked, y, limits), key=lambda curve: curve.duration)
    return Fastest(best, converged, iterations)


def _objective(asked: Conditions, bounds: list[Bound], power: float, y: Array) -> tuple[float, Array]:
    return stretched_time(asked, np.exp(y), bounds, power)


def _within(asked: Conditions, y: Array, limits: MotionLimits) -> PiecewisePolynomial:
    """Return the trajectory of durations in the ratios of exp y, stretched to the limits."""
    return rescaled(closed_form(replace(asked, durations=np.exp(y))), limits)
