"""A trajectory from a file, of whoever made it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.plan.facing import Look, facing
from crosstrack.protocols import PlanningTask, Trajectory
from crosstrack.trajectory.files.formats import from_bytes
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

STILL = 0.05
"""m/s, a speed that counts as rest"""


@dataclass(frozen=True)
class FromFile:
    """Fly the trajectory of a file, which must lead from the start to the last point of the route."""

    replans: ClassVar[bool] = False

    file: str
    """a trajectory.json or .csv beside the mission"""
    yaw: Look = "fixed"
    """fixed: as at the start; velocity: where it flies"""

    @property
    def names(self) -> tuple[str, ...]:
        """The file."""
        return (self.file,)

    def allowed(self, tolerance: float) -> None:
        """Allow any deviation from the legs: the file knows why."""

    def plan(self, task: PlanningTask) -> Trajectory:
        """Return the file's trajectory; whether it keeps the limits is for its certificate to say.

        Raises:
            InputError: everything that is wrong with the file, or how it does not fit the route.
        """
        curve = from_bytes(self.file, task.files[self.file])
        found = list(misfits(curve, task))
        if found:
            raise InputError(self.file, found)
        return facing(curve, self.yaw)


def misfits(curve: PiecewisePolynomial, task: PlanningTask) -> Iterator[Problem]:
    """Yield which ends of a trajectory are not those of the route, at rest."""
    ends = (("start", 0.0, task.waypoints[0]), ("end", curve.duration, task.waypoints[-1]))
    for name, time, wanted in ends:
        found, speed = curve(time), float(np.linalg.norm(curve(time, 1)))
        if (distance := float(np.linalg.norm(found - wanted))) > task.tolerance:
            at = f"is at {written(found)}, {distance:.3g} m from the route's, {written(wanted)}"
            yield Problem(name, f"{at}; at most the mission's tolerance, {task.tolerance:g} m, is allowed")
        if speed > STILL:
            yield Problem(name, f"moves at {speed:.3g} m/s; the vehicle is at rest there (below {STILL:g} m/s)")


def written(point: Array) -> str:
    """Return a point (3,) as text."""
    return "(" + ", ".join(f"{value:.6g}" for value in point) + ")"
