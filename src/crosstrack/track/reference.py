"""A trajectory sampled for the loop: position to snap and yaw at any time, in compiled code."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Course, Trajectory
from crosstrack.types import Array

SPACING = 0.005
"""s, between samples: the Taylor series from the nearest, to the fourth order, is exact to 1e-13 of a crackle"""
ROWS = 1024
"""samples in a stretch"""
AHEAD = 1.0
"""s, that a stretch reaches beyond the time it is asked for at least"""

Motion = tuple[
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
    float,
]
"""Position (m), velocity, acceleration, jerk and snap (m/s⁴), three each; yaw (rad) and yaw rate (rad/s)."""


@runtime_checkable
class Facing(Protocol):
    """A trajectory that also says where to look."""

    def yaw(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate at the time `t` (s, shape (...)): yaw or its derivative of an order, (...) rad/s^order."""


@dataclass(frozen=True, eq=False)
class Reference:
    """A stretch of a trajectory, sampled; before its beginning and after its end it rests."""

    trajectory: Trajectory
    heading: float
    """rad, yaw of a trajectory that leaves it open"""
    begin: float
    """s, time of the first sample"""
    rows: Array
    """(n, 17), a `Motion` each, SPACING apart"""

    def covering(self, t: float) -> "Reference":
        """Return a stretch that has the time `t` (s) and at least AHEAD seconds more."""
        if 0 <= t - self.begin <= (len(self.rows) - 1) * SPACING - AHEAD:
            return self
        return reference(self.trajectory, self.heading, t)


def reference(trajectory: Trajectory, heading: float, t: float = 0.0) -> Reference:
    """Return the stretch of a trajectory that begins at the time `t` (s).

    Args:
        trajectory: with four derivatives
        heading: rad, the yaw where the trajectory leaves it open
        t: s
    """
    times = np.linspace(t, t + (ROWS - 1) * SPACING, ROWS)
    orders = [trajectory(times, order) for order in range(5)]
    moving = ((times >= 0) & (times <= trajectory.duration))[:, None]
    derivatives = [np.where(moving, values, 0.0) for values in orders[1:]]
    if isinstance(trajectory, Facing):
        yaw = [trajectory.yaw(times), np.where(moving[:, 0], trajectory.yaw(times, 1), 0.0)]
    else:
        yaw = [np.full(ROWS, heading), np.full(ROWS, 0.0 * heading)]  # both NaN where none is asked for
    return Reference(trajectory, heading, t, np.column_stack([orders[0], *derivatives, *yaw]))


@compiled
def motion(rows: Array, since: float) -> Motion:
    """Return what a stretch asks for `since` seconds after its first sample."""
    k = min(max(int(since / SPACING + 0.5), 0), rows.shape[0] - 1)
    r, h = rows[k], since - k * SPACING
    h2, h3, h4 = h * h / 2, h * h * h / 6, h * h * h * h / 24
    return (
        r[0] + h * r[3] + h2 * r[6] + h3 * r[9] + h4 * r[12],
        r[1] + h * r[4] + h2 * r[7] + h3 * r[10] + h4 * r[13],
        r[2] + h * r[5] + h2 * r[8] + h3 * r[11] + h4 * r[14],
        r[3] + h * r[6] + h2 * r[9] + h3 * r[12],
        r[4] + h * r[7] + h2 * r[10] + h3 * r[13],
        r[5] + h * r[8] + h2 * r[11] + h3 * r[14],
        r[6] + h * r[9] + h2 * r[12],
        r[7] + h * r[10] + h2 * r[13],
        r[8] + h * r[11] + h2 * r[14],
        r[9] + h * r[12],
        r[10] + h * r[13],
        r[11] + h * r[14],
        r[12],
        r[13],
        r[14],
        r[15] + h * r[16],
        r[16],
    )


def trajectory_of(course: Course) -> Trajectory:
    """Return the trajectory of a course.

    Raises:
        InputError: it has none.
    """
    if course.trajectory is None:
        message = "this one follows a trajectory, and the course is a path only: add a `planner`"
        raise InputError("course", [Problem("tracker", message)])
    return course.trajectory
