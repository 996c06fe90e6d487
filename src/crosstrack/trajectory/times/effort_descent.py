"""Newton's method for the durations that minimise effort, O(N) a step.

The effort of the best trajectory J(T) = min_x J(x, T) is minimised over y = log T, with ρ Σ T added, or with Σ T fixed.
A step comes from the second derivatives of J(x, T) by all derivatives x at the knots and all y together: that is a band
matrix (see `effort`), and eliminating x from it gives J(T) its curvature. After a step x is solved for again.
Nocedal & Wright, Numerical Optimization (2006), 3.4 (shifted Hessian), 18.1 (equality constraint).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from crosstrack.trajectory.closed_form import solved
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.guide import chord_loads
from crosstrack.trajectory.times.effort import curvature, grams, slopes
from crosstrack.types import Array

MOST_ITERATIONS = 200
FLAT = 1e-9
"""slope of the objective by log T, relative to the effort, at which it has converged"""
GAIN = 1e-13
"""relative gain that rounding hides: where a step promises less it has converged too"""
ROUGH = 1e-8
"""likewise, where rounding is so rough that the step brings no gain: legs a million times as long as others"""
NOTHING = 1e-9
"""of the effort at the beginning, below which effort counts as none: a straight line at constant speed has none"""
LONGEST_STEP = 1.0
"""of log T"""
SHORTEST_STEP = 1e-9
"""fraction of a Newton step below which the search gives up"""
ARMIJO = 1e-4
SHIFTS = (0.0, *(0.01 * 4.0**k for k in range(40)))
"""of the curvature, relative to the effort, until it is positive"""
SMALLEST = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Effort:
    """The effort at given durations, with all that is needed to go on from there."""

    durations: Array
    """(N,) s"""
    value: float
    """J, guides included"""
    slopes: Array
    """(N,) dJ / d log T"""
    knots: Array
    """(N + 1, s, d) the derivatives that minimise it"""


@dataclass(frozen=True, slots=True)
class Descent:
    """How a minimisation over durations ended."""

    effort: Effort
    converged: bool
    iterations: int
    slope: float
    """largest slope of the objective by log T, relative to the effort"""


def effort(asked: Conditions, durations: Array) -> Effort:
    """Return the least effort at some durations; the guide, where there is one, is the chord."""
    s, knots, loads = asked.order, asked.knots.copy(), asked.loads
    if asked.weights.size:
        loads = chord_loads(knots[:, 0], durations, asked.weights[:, 0], s)
    solved(replace(asked, durations=durations, loads=loads), knots)
    out = np.empty(len(durations))
    return Effort(durations, slopes(durations, knots, asked.weights, grams(s), out), out, knots)


def descend(asked: Conditions, price: float | None) -> Descent:
    """Minimise effort + price · Σ T from the durations asked for, or the effort alone with their total for None."""
    now = effort(asked, asked.durations)
    nothing = NOTHING * now.value + SMALLEST
    for iteration in range(MOST_ITERATIONS + 1):
        uphill, rho = _uphill(now, price)
        size = max(now.value, nothing)
        slope = float(np.abs(uphill).max()) / size
        if slope <= FLAT:
            return Descent(now, True, iteration, slope)
        step = _step(asked, now, rho, uphill, fixed=price is None)
        if step is None:
            break
        promised = -float(uphill @ step)
        ahead = _search(asked, now, step, price) if promised > GAIN * size and iteration < MOST_ITERATIONS else None
        if ahead is None:
            return Descent(now, promised <= ROUGH * size, iteration, slope)
        now = ahead
    return Descent(now, False, iteration, slope)


def _uphill(now: Effort, price: float | None) -> tuple[Array, float]:
    """Return the slopes (N,) of J + ρ Σ T by log T, and ρ: with a fixed total the one that makes them smallest."""
    rho = price
    if rho is None:
        rho = -float(now.slopes @ now.durations) / float(now.durations @ now.durations)
    return now.slopes + rho * now.durations, rho


def _step(asked: Conditions, now: Effort, price: float, uphill: Array, fixed: bool) -> Array | None:
    """Return the Newton step (N,) of log T, shifted where the curvature is not positive, or None."""
    s, columns = asked.knots.shape[1:]
    free, count = (s - 1) * columns, len(now.durations)
    band = np.zeros((2 * free + 1, (count + 1) * (free + 1) - 1))
    pinned = ~np.isnan(asked.knots[:, :, 0])
    curvature(now.durations, now.knots, pinned, asked.weights, price, grams(s), band)
    places = np.arange(count) * (free + 1) + free
    right = np.zeros((band.shape[1], 2))
    right[places, 0] = -0.5 * uphill
    right[places, 1] = now.durations
    for shift in SHIFTS:
        shifted = band.copy()
        shifted[0, places] += shift * now.value
        try:
            factor = cholesky_banded(shifted, overwrite_ab=True, lower=True, check_finite=False)
        except LinAlgError:
            continue
        solved = cho_solve_banded((factor, True), right, check_finite=False)[places]
        step: Array = solved[:, 0]
        if fixed:
            step = step - (now.durations @ step) / (now.durations @ solved[:, 1]) * solved[:, 1]
        return step * min(1.0, LONGEST_STEP / float(np.abs(step).max()))
    return None


def _search(asked: Conditions, now: Effort, step: Array, price: float | None) -> Effort | None:
    """Return the effort after as much of a step as makes the objective fall enough, or None when none does."""
    total = now.durations.sum()
    fall = float(now.slopes @ step) + (price or 0.0) * float(now.durations @ step)
    fraction = 1.0
    while fraction > SHORTEST_STEP:
        durations = now.durations * np.exp(fraction * step)
        if price is None:
            durations *= total / durations.sum()
        ahead = effort(asked, durations)
        change = ahead.value - now.value + (price or 0.0) * (durations.sum() - total)
        if change <= ARMIJO * fraction * fall + GAIN * now.value:
            return ahead
        fraction *= 0.5
    return None
