"""Minimum-snap and minimum-jerk planning: durations of the legs, a shape, and the pace that the limits allow."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from crosstrack.plan.cadence import evenly, spread
from crosstrack.plan.facing import Look, facing
from crosstrack.protocols import PlanningTask, Trajectory
from crosstrack.trajectory.constrained.bounded import solve
from crosstrack.trajectory.constrained.corridor import Tube
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.fastest import fastest
from crosstrack.trajectory.times.optimal import least_effort
from crosstrack.trajectory.times.timing import constant_speed, haste, rescaled, square_root, trapezoid
from crosstrack.trajectory.weights.choose import choose_weights
from crosstrack.types import Array, NonNegative, Positive

ROUNDS = 12
"""times that a shape which depends on its pace is planned again"""
CLOSE = 0.005
"""of the pace, what the last round may leave unused"""


@dataclass(frozen=True)
class Minimum:
    """Minimise the integral of a squared derivative through the waypoints, as fast as speed and acceleration allow."""

    corridor: Positive | None = None
    """m, the whole trajectory stays within this of the legs; with neither it nor a guide, the mission's tolerance"""
    guide: Literal["auto"] | NonNegative | None = None
    """weight of the distance to the legs, 0 for a free trajectory; auto: what keeps it in the corridor without one"""
    times: Literal["constant", "trapezoid", "square_root", "optimal", "fastest"] = "trapezoid"
    """how the time is shared out between the legs: optimal for the least effort, fastest for the least time through
    the waypoints; in a corridor the trapezoid, which slows for its corners, takes the least"""

    yaw: Look = "fixed"
    """fixed: as at the start; velocity: where it flies"""

    derivative: ClassVar[int]
    names: ClassVar[tuple[str, ...]] = ()
    replans: ClassVar[bool] = False

    def allowed(self, tolerance: float) -> float | None:
        """Return how far (m) from the legs the trajectory may be."""
        if self.corridor is not None:
            return self.corridor
        return tolerance if self.guide in {None, "auto"} else None

    def plan(self, task: PlanningTask) -> Trajectory:
        """Return the trajectory with its yaw.

        Raises:
            Infeasible: nothing keeps it within the corridor.
        """
        return facing(self.curve(task), self.yaw)

    def curve(self, task: PlanningTask) -> PiecewisePolynomial:
        """Return the trajectory, at the pace at which its tightest limit is met.

        Raises:
            Infeasible: nothing keeps it within the corridor.
        """
        limits, radius = motion_limits(task), self.allowed(task.tolerance)
        if radius is not None and self.guide != "auto":
            return rescaled(self.inside(task.waypoints, radius, limits), limits)
        durations = DURATIONS[self.times](task.waypoints, limits, self.derivative)
        if radius is not None:
            chosen = choose_weights(task.waypoints, moments(durations), self.derivative, max_deviation=radius)
            return rescaled(chosen.curve, limits)
        if not self.guide:
            return rescaled(minimum(task.waypoints, moments(durations), self.derivative), limits)
        return self.guided(task.waypoints, durations, float(self.guide), limits)

    def inside(self, waypoints: Array, radius: float, limits: MotionLimits) -> PiecewisePolynomial:
        """Return the trajectory whose pieces stay within a radius of their legs: near the waypoints, not through them.

        Stretched it is the same curve in space. The trapezoid slows for the corners; other times are shared out
        evenly along each leg.
        """
        if self.times == "trapezoid":
            knots, times = spread(waypoints, radius, limits)
        else:
            durations = DURATIONS[self.times](waypoints, limits, self.derivative)
            knots, times = evenly(waypoints, durations, radius, limits)
        weight = self.guide if isinstance(self.guide, int | float) and self.guide > 0 else None
        return solve(knots, times, self.derivative, guide=weight, corridor=Tube(radius)).curve

    def guided(self, waypoints: Array, durations: Array, weight: float, limits: MotionLimits) -> PiecewisePolynomial:
        """Return the trajectory of a weight, replanned at its pace: the faster it is, the less the weight counts."""
        for _ in range(ROUNDS):
            curve = minimum(waypoints, moments(durations), self.derivative, guide=weight)
            factor = haste(curve, limits)
            if 1 - CLOSE <= factor <= 1:
                break
            durations = durations * factor
        return rescaled(curve, limits)


@dataclass(frozen=True)
class MinimumSnap(Minimum):
    """Plan a trajectory of minimum snap, the smoothest for a quadrotor's body rates."""

    derivative: ClassVar[int] = 4


@dataclass(frozen=True)
class MinimumJerk(Minimum):
    """Plan a trajectory of minimum jerk, which swings out less beside the legs than one of minimum snap."""

    derivative: ClassVar[int] = 3


def motion_limits(task: PlanningTask) -> MotionLimits:
    """Return the limits of a task."""
    envelope = task.envelope
    return MotionLimits(
        speed=task.speed,
        speed_vertical=envelope.speed_vertical,
        acceleration=envelope.acceleration,
        acceleration_vertical=envelope.acceleration_vertical,
    )


def moments(durations: Array) -> Array:
    """Return when each waypoint is passed, (N + 1,) s, for durations (N,) s."""
    return np.concatenate([[0.0], np.cumsum(durations)])


def optimal(waypoints: Array, limits: MotionLimits, derivative: int) -> Array:
    """Return the durations (N,) s of least effort, in a total like that of the trapezoid."""
    total = float(trapezoid(waypoints, limits).sum())
    return least_effort(waypoints, total, derivative).curve.durations


DURATIONS: dict[str, Callable[[Array, MotionLimits, int], Array]] = {
    "constant": lambda waypoints, limits, _: constant_speed(waypoints, limits),
    "trapezoid": lambda waypoints, limits, _: trapezoid(waypoints, limits),
    "square_root": lambda waypoints, limits, _: square_root(waypoints, limits),
    "optimal": optimal,
    "fastest": lambda waypoints, limits, derivative: fastest(waypoints, limits, derivative).curve.durations,
}
"""(waypoints, limits, derivative) to durations (N,) s"""
