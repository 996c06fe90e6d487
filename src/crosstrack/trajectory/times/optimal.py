"""Durations that make a trajectory as smooth as it can be in a time, or weigh its effort against its time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.trajectory.arguments import is_number
from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.conditions import Conditions, conditions, order_faults
from crosstrack.trajectory.guide import Guide
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.effort_descent import descend
from crosstrack.trajectory.times.guided_descent import descend_guided
from crosstrack.trajectory.times.timing import legs, square_root, total_fault
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class Timed:
    """A trajectory with optimised durations, and how far the optimisation came."""

    curve: PiecewisePolynomial
    objective: float
    """what was minimised: effort with the guide, plus the price of the time"""
    converged: bool
    """whether a local minimum was reached to rounding"""
    iterations: int
    slope: float
    """largest slope of the objective by the logarithm of a duration, relative to the effort; zero at the optimum"""


@reported_by("least_effort")
def least_effort(
    waypoints: ArrayLike,
    total: float,
    derivative: int = 3,
    *,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    periodic: bool = False,
    guide: float | Guide | Sequence[Guide] | None = None,
) -> Timed:
    """Return the trajectory of least effort through waypoints in a total time, over the durations of its segments too.

        min over T of min over p of ∫ ‖p⁽ˢ⁾‖² dt + Σ λ_j ∫ ‖p⁽ᵏ⁾ - g_j‖² dt,      Σ T_i = total

    Without a guide all starts tried lead to the same durations; with one there may be several local minima, and this is
    the one found from durations in proportion to the square roots of the lengths of the legs.

    Args:
        waypoints: (n, d) m, at least two, no two neighbours the same
        total: s
        derivative: s, 2 for acceleration, 3 for jerk, 4 for snap
        start: see `minimum`
        end: likewise
        velocities: likewise
        periodic: likewise
        guide: λ of the chords of the segments, which follow the durations, or guides, which are fixed in time

    Raises:
        InputError: all that is wrong with the arguments, or they leave the trajectory undetermined.
    """
    found = total_fault(total) + order_faults(derivative)
    begin = _begin(waypoints, 1.0 if found else total, found)
    remade = _maker(waypoints, derivative, start, end, velocities, periodic, guide)
    return _timed(remade, guide, begin, None)


@reported_by("least_effort_and_time")
def least_effort_and_time(
    waypoints: ArrayLike,
    price: float,
    derivative: int = 3,
    *,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    periodic: bool = False,
    guide: float | Guide | Sequence[Guide] | None = None,
) -> Timed:
    """Return the trajectory through waypoints that minimises effort plus the price of its time.

        min over T of min over p of ∫ ‖p⁽ˢ⁾‖² dt + Σ λ_j ∫ ‖p⁽ᵏ⁾ - g_j‖² dt + ρ Σ T_i

    Richter, Bry & Roy, Polynomial Trajectory Planning for Aggressive Quadrotor Flight, Robotics Research (2016).

    Args:
        waypoints: (n, d) m, at least two, no two neighbours the same
        price: ρ, unit of the effort per second
        derivative: s, 2 for acceleration, 3 for jerk, 4 for snap
        start: see `minimum`
        end: likewise
        velocities: likewise
        periodic: likewise
        guide: see `least_effort`

    Raises:
        InputError: all that is wrong with the arguments, or they leave the trajectory undetermined.
    """
    found = order_faults(derivative)
    if not is_number(price) or not 0 < price < np.inf:
        found.append(Problem("price", f"must be above 0 and finite, found {price!r:.60}"))
    begin = _begin(waypoints, 1.0, found)
    remade = _maker(waypoints, derivative, start, end, velocities, periodic, guide)
    # from rest to rest and without guides the effort is α^(1-2s) times as much in α times the time
    cost = closed_form(remade(begin)).cost(derivative)
    power = 2 * derivative - 1
    factor = (power * cost / price) ** (1 / (power + 1)) if cost > 0.0 else 1.0
    return _timed(remade, guide, begin * factor, price)


def _begin(waypoints: ArrayLike, total: float, found: list[Problem]) -> Array:
    """Return the durations (N,) s to begin with."""
    legs(waypoints, found)
    if found:
        raise InputError("times", found)
    return square_root(waypoints, total=total)


def _maker(
    waypoints: ArrayLike,
    derivative: int,
    start: ArrayLike | None,
    end: ArrayLike | None,
    velocities: ArrayLike | None,
    periodic: bool,
    guide: float | Guide | Sequence[Guide] | None,
) -> Callable[[Array], Conditions]:
    """Return the function from durations to conditions."""

    def remade(durations: Array) -> Conditions:
        times = np.concatenate([[0.0], np.cumsum(durations)])
        return conditions(waypoints, times, derivative, start, end, velocities, periodic, guide)

    return remade


def _timed(
    remade: Callable[[Array], Conditions],
    guide: float | Guide | Sequence[Guide] | None,
    begin: Array,
    price: float | None,
) -> Timed:
    """Optimise from some durations: by Newton's method where the curvature is at hand."""
    guides = [guide] if isinstance(guide, Guide) else guide if isinstance(guide, Sequence) else []
    asked = remade(begin)
    closed_form(asked)  # raises where the trajectory is undetermined
    done = descend_guided(remade, guides, begin, price) if guides or asked.periodic else descend(asked, price)
    best = done.effort
    curve = closed_form(replace(asked, durations=best.durations, knots=best.knots, periodic=False))
    objective = best.value + (price or 0.0) * curve.duration
    return Timed(curve, objective, done.converged, done.iterations, done.slope)
