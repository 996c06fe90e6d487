"""What a mission's trajectory is certified to keep to."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from crosstrack.errors import InputError, Problem
from crosstrack.flight.plan import Plan
from crosstrack.mission.mission import Mission
from crosstrack.mission.planning import task_for
from crosstrack.protocols import PlanningTask
from crosstrack.trajectory.certified.certificate import Certificate, certify
from crosstrack.trajectory.certified.extremes import axis_range
from crosstrack.trajectory.flatness.yaw import Faced
from crosstrack.trajectory.polynomial import PiecewisePolynomial

ROUNDING = 1e-6
"""m, that a certified height may be below the ground or outside the bounds that the trajectory begins on"""


@dataclass(frozen=True)
class Line:
    """One quantity of a trajectory beside its limit."""

    quantity: str
    """as people call it"""
    unit: str
    value: float
    """certified for every instant: nothing is above it, or below it for distances that must be kept"""
    limit: float | None = None
    """in the same unit; None where it is free"""
    time: float | None = None
    """s, when it is reached"""
    least: bool = False
    """whether the limit is a lower one"""

    @property
    def holds(self) -> bool:
        """Return whether the limit is kept."""
        return self.limit is None or (self.value >= self.limit if self.least else self.value <= self.limit)


@dataclass(frozen=True)
class Certified:
    """A planned mission and what is certified of its trajectory."""

    plan: Plan
    trajectory: PiecewisePolynomial
    task: PlanningTask
    allowed: float | None
    """m, the farthest from the straight legs that was asked for"""
    certificate: Certificate
    lines: tuple[Line, ...]

    @property
    def broken(self) -> list[Line]:
        """The limits that are not kept."""
        return [line for line in self.lines if not line.holds]

    def document(self) -> dict[str, Any]:
        """Return the certificate and the limits as plain values for JSON."""
        lines = [asdict(line) | {"holds": line.holds} for line in self.lines]
        return {"name": self.plan.name, "holds": not self.broken, "findings": lines} | self.certificate.document()


def certified(mission: Mission, plan: Plan) -> Certified:
    """Certify the trajectory of a mission.

    Args:
        mission: with a planner
        plan: what it was built to

    Raises:
        InputError: its planner made something else than a piecewise polynomial.
    """
    trajectory = plan.course.trajectory
    if isinstance(trajectory, Faced):
        trajectory = trajectory.trajectory
    if mission.planner is None or not isinstance(trajectory, PiecewisePolynomial):
        message = f"makes a {type(trajectory).__name__}; only piecewise polynomials can be certified"
        raise InputError(mission.name, [Problem("planner", message)])
    task = task_for(mission, mission.planner, plan.route, plan.scenario)
    allowed = mission.planner.allowed(mission.tolerance)
    certificate = certify(trajectory, route=plan.route.points, world=task.world)
    lines = [
        Line("duration", "s", trajectory.duration),
        Line("length", "m", plan.course.path.length),
        *motion(certificate, task),
        *places(certificate, task, allowed),
        *room(trajectory, task),
    ]
    return Certified(plan, trajectory, task, allowed, certificate, tuple(lines))


def motion(certificate: Certificate, task: PlanningTask) -> Iterator[Line]:
    """Yield the largest derivatives beside the limits of the vehicle and the mission."""
    envelope = task.envelope
    rows = (
        ("speed", "speed", "m/s", task.speed),
        ("vertical speed", "speed_vertical", "m/s", envelope.speed_vertical),
        ("acceleration", "acceleration", "m/s²", envelope.acceleration),
        ("vertical acceleration", "acceleration_vertical", "m/s²", envelope.acceleration_vertical),
        ("jerk", "jerk", "m/s³", None),
        ("snap", "snap", "m/s⁴", None),
    )
    for quantity, name, unit, limit in rows:
        peak = certificate.peaks[name]
        yield Line(f"largest {quantity}", unit, peak.value, limit, peak.time)


def places(certificate: Certificate, task: PlanningTask, allowed: float | None) -> Iterator[Line]:
    """Yield the deviation from the route, and the clearance where there are obstacles."""
    if (deviation := certificate.deviation) is not None:
        yield Line("largest deviation from the route", "m", deviation.value, allowed, deviation.time)
    clearance = certificate.clearance
    if clearance is not None and math.isfinite(clearance.attained):
        yield Line("least clearance", "m", clearance.value, task.radius, clearance.time, least=True)


def room(trajectory: PiecewisePolynomial, task: PlanningTask) -> Iterator[Line]:
    """Yield the least height over the ground, and the least distance to the bounds where there are any."""
    ranges = axis_range(trajectory)
    lowest = ranges[2].least
    yield Line(
        "least height over the ground", "m", lowest.value - task.world.ground, -ROUNDING, lowest.time, least=True
    )
    if task.world.bounds is None:
        return
    low, high = task.world.bounds
    sides = [(side.least.value - low[k], side.least.time) for k, side in enumerate(ranges)]
    sides += [(high[k] - side.greatest.value, side.greatest.time) for k, side in enumerate(ranges)]
    distance, time = min(sides)
    yield Line("least distance to the bounds", "m", float(distance), -ROUNDING, time, least=True)


def remarks(found: Certified) -> list[str]:
    """Say which limits a trajectory breaks."""
    return [
        f"the trajectory's {line.quantity} is {line.value:.3g} {line.unit}, "
        f"{'below' if line.least else 'above'} {line.limit:.3g} {line.unit}"
        + (f", after {line.time:.2f} s" if line.time is not None else "")
        for line in found.broken
    ]
