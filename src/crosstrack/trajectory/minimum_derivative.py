"""Minimum-acceleration, -jerk and -snap trajectories through waypoints, or within corridors and limits."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.conditions import conditions
from crosstrack.trajectory.constrained.bounded import solve
from crosstrack.trajectory.constrained.corridor import Corridor
from crosstrack.trajectory.guide import Guide
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial

WORST = 0.01
"""relative, how far the cost may be above the least within a corridor and limits; 0.001 is aimed at"""


@reported_by("minimum")
def minimum(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int = 3,
    *,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    periodic: bool = False,
    guide: float | Guide | Sequence[Guide] | None = None,
    corridor: float | Corridor | None = None,
    limits: MotionLimits | None = None,
) -> PiecewisePolynomial:
    """Return the piecewise polynomial of degree 2 s - 1 through waypoints that minimises a derivative s.

        min ∫ ‖p⁽ˢ⁾‖² dt + Σ λ_j ∫ ‖p⁽ᵏ⁾ - g_j‖² dt,      p(t_i) = w_i

    In closed form; within a corridor or limits, see `bounded.solve`, to within 1 % of the least cost, and mostly 0.1 %.

    Without guides it is the optimum over all curves, C^(2 s - 2) at the waypoints; with guides that of this degree,
    C^(s - 1). Its time begins at 0 at the first waypoint.

    Args:
        waypoints: (n, d) m, at least two
        times: (n,) s, increasing
        derivative: s, 2 for acceleration, 3 for jerk, 4 for snap
        start: (k, d) velocity, acceleration, ... at the first waypoint, k < s; rows of NaN are free, rows that are not
            there are zero
        end: likewise at the last
        velocities: (n, d) m/s at the waypoints; rows of NaN are free. They hold at the ends too where `start` or
            `end` is not given
        periodic: close the loop, with equal derivatives at both ends; the last waypoint is the first
        guide: λ of the chords of the segments as guide, or guides
        corridor: m, the inner waypoints need only be met to within this on every axis; or `Boxes`, a `Tube` or
            `Polytopes` that hold the whole curve between the first waypoint and the last, at every instant
        limits: of speed, acceleration and jerk, at every instant

    Raises:
        InputError: all that is wrong with the arguments, or they leave the trajectory undetermined.
        Infeasible: no such trajectory keeps within the corridor and the limits.

    Example:
        >>> from crosstrack.trajectory import minimum
        >>> curve = minimum([[0, 0], [1, 2], [3, 2]], [0, 1, 2], derivative=4)
        >>> curve(1.0).round(9).tolist(), curve.coefficients.shape
        ([1.0, 2.0], (2, 8, 2))
    """
    if corridor is not None or limits is not None:
        if periodic:
            raise InputError("minimum", [Problem("periodic", "must not be given with a corridor or limits")])
        found = solve(
            waypoints,
            times,
            derivative,
            start=start,
            end=end,
            velocities=velocities,
            guide=guide,
            corridor=corridor,
            limits=limits,
        )
        if not found.gap <= WORST:
            message = f"are so uneven that the least cost is only known to within {found.gap:.2g} of what was found"
            raise InputError("minimum", [Problem("times", message)])
        return found.curve
    return closed_form(conditions(waypoints, times, derivative, start, end, velocities, periodic, guide))
