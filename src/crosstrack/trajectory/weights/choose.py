"""Weights of a guide from what is wanted: how far a trajectory may stray from its chords, and its limits.

A guide draws a trajectory to a curve by a weight λ on each segment. Three are tried:

- the chords at constant speed: smooth, but corners are taken at speed, so that there is a deviation that no weight
  gets below; past some weight the mean error still falls while the largest grows;
- the chords at rest at every waypoint, see `resting`: they are themselves a trajectory, so that with growing weights
  any deviation is reached, at about twice the speed of the chord;
- where neither does, the trajectory of least excess, see `reach`. If it meets all, so do weights that are great
  enough; if it does not, no trajectory does, and that is proven.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import Infeasible, InputError, Problem, reported_by
from crosstrack.trajectory import hermite
from crosstrack.trajectory.arguments import is_number
from crosstrack.trajectory.conditions import conditions
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.limits import Bound, MotionLimits, limit_faults
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.weights.excess import deviation
from crosstrack.trajectory.weights.reach import Reach, least_excess
from crosstrack.trajectory.weights.weight_search import Kind, Search, Trial
from crosstrack.types import Array


@dataclass(frozen=True, eq=False)
class WeightsChosen:
    """Weights that keep a trajectory within what is allowed, and the trajectory."""

    guide: Guide
    """with a weight for each segment, for `minimum`"""
    kind: Kind
    """what it draws to"""
    curve: PiecewisePolynomial
    deviations: Array
    """(N,) m, certified: no piece is farther from its chord at any instant"""
    peaks: dict[str, float]
    """certified peak of the deviation and of everything that is limited, by name; m, m/s, ..."""
    solves: int
    """trajectories computed on the way"""

    @property
    def weights(self) -> Array:
        """(N,) λ"""
        return np.asarray(self.guide.weight)


@reported_by("choose_weights")
def choose_weights(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int = 3,
    *,
    max_deviation: float,
    limits: MotionLimits | None = None,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
) -> WeightsChosen:
    """Return a guide whose weights keep a trajectory near to its chords and within limits, and no more.

    Args:
        waypoints: (n, d) m
        times: (n,) s, increasing
        derivative: s, the derivative that is minimised
        max_deviation: m, from each segment's chord
        limits: of speed, acceleration and jerk; None for none
        start: see `minimum`
        end: see `minimum`

    Raises:
        InputError: all that is wrong with the arguments.
        Infeasible: it is proven that no trajectory through these waypoints at these times meets all, whatever the
            weights; or it is so close that the search ends undecided. The message says which, and by how much.

    Example:
        >>> from crosstrack.trajectory import choose_weights
        >>> chosen = choose_weights([[0, 0], [4, 0], [4, 3]], [0, 2, 4], max_deviation=0.1)
        >>> bool(chosen.deviations.max() <= 0.1), chosen.weights.shape
        (True, (2,))
    """
    asked = conditions(waypoints, times, derivative, start, end, None, False, 0.0)
    points = np.array(waypoints, float)
    found = limit_faults(limits, points.shape[1]) if limits is not None else []
    if not is_number(max_deviation) or not 0 < max_deviation < np.inf:
        found.append(Problem("max_deviation", f"must be a length above 0, in metres, found {max_deviation!r:.60}"))
    if found:
        raise InputError("choose_weights", found)
    allowed = [deviation(max_deviation), *(limits.bounds(points.shape[1]) if limits else ())]
    searches = [
        Search(asked, points, allowed, "chord", chord(points, asked.durations)),
        Search(asked, points, allowed, "resting", resting(points, asked.durations, derivative)),
    ]
    trials = [search.run() for search in searches]
    nearest = min(trials, key=lambda trial: trial.worst)
    if nearest.worst > 1:
        reach = least_excess(asked, points, allowed, nearest.curve)
        searches.append(Search(asked, points, allowed, "least excess", reach.curve))
        trials.append(searches[-1].run() if reach.at_most <= 1 else nearest)
        if trials[-1].worst > 1:
            raise Infeasible("choose_weights", [_why(reach, allowed)])
    met = [k for k, trial in enumerate(trials) if trial.worst <= 1]
    k = min(met, key=lambda k: trials[k].cost)
    return _chosen(searches[k], trials[k], sum(search.solves for search in searches))


def _chosen(search: Search, best: Trial, solves: int) -> WeightsChosen:
    """Return the result of a trial that meets all."""
    rows = zip(search.allowed, best.excesses, strict=True)
    peaks = {each.name: float(row.max()) * each.most for each, row in rows}
    deviations = best.excesses[0] * search.allowed[0].most
    return WeightsChosen(Guide(search.target, best.weights), search.kind, best.curve, deviations, peaks, solves)


def resting(points: Array, durations: Array, s: int) -> PiecewisePolynomial:
    """Return the motion along straight lines through points (N + 1, d) m, s - 1 derivatives of which are 0 at each."""
    powers = np.arange(2 * s)[:, None]
    steps = np.diff(points, axis=0)[:, None, :]
    coefficients = hermite.coefficients(s)[:, s, None] * steps / durations[:, None, None] ** powers
    coefficients[:, 0] = points[:-1]
    return PiecewisePolynomial(durations, coefficients)


def _why(reach: Reach, allowed: Sequence[Bound]) -> Problem:
    """Return why no weights meet all: that none can, or that it is too close to tell."""
    limits = ", ".join(f"{each.name} {each.most:g}" for each in allowed)
    shares = " and ".join(f"{name} on segment {k}" for name, k, share in reach.binding[:3] if share > 0.05)
    place = f"segment {reach.binding[0][1]}" if reach.binding else ""
    what = f"through these waypoints at these times keeps within {limits}"
    if reach.at_least > 1:
        least = f"the best exceeds it by {reach.at_least - 1:.2%} or more"
        return Problem(place, f"proven: no trajectory {what}; {least}: {shares}")
    found = f"the best found exceeds it by {reach.at_most - 1:.2%}, and no more is proven than {reach.at_least - 1:.2%}"
    return Problem(place, f"not decided whether a trajectory {what}: {found}")
