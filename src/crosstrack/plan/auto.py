"""A way of its own through what is in the way, and a trajectory along it: for goals in place of routes."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray

from crosstrack.errors import Problem, Unreachable
from crosstrack.plan.auto_fit import Free, at_rest, fitted
from crosstrack.plan.auto_stop import after, braking, settled, stop_and_go
from crosstrack.plan.facing import Look, facing
from crosstrack.protocols import Map, PlanningTask, Trajectory
from crosstrack.search.sampled import Sampling, sampled_way
from crosstrack.search.taut import direct, length
from crosstrack.search.way import REPAIRS, find_way
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, NonNegative, Positive

EDGE = 0.05
"""m, that a plan keeps from the bounds"""
CLOSER = 0.01
"""m, by which the legs that a trajectory goes along may be closer to obstacles than the way"""
MARGINS = (1.2, 1.0, 0.25)
"""of the margin, that ways are looked for with: in turn, as long as there is none"""
AMPLE = 0.4
"""m, beyond the radius, of ways that are looked for first in motion: more is seen from there, and flown fast"""
DETOUR, CURIOSITY = 1.2, 2.0
"""by which factor, and by how much (m) besides, such a way may be longer than the shortest"""
FEW_REPAIRS = 3
"""of ways that are looked for in motion, but for the narrowest: only there must it be certain that there is none"""
REACH = 0.4
"""m, how far a search looks at distances, at least"""
DOUBT = 0.005
"""m, that a way keeps beyond what the map's distances may be too large by"""
NEAR = 0.05
"""m, a way too short to be one"""
HORIZON = 10.0
"""m, of the way that is planned in motion: it ends at rest there, and is planned on before that"""
EASE = 0.7
"""of the acceleration that the task allows, planned with: the less, the less the flight is off the plan"""
STRONGEST = 10.0
"""m/s², planned with for a vehicle that turns at once"""


@dataclass(frozen=True)
class Auto:
    """Find the way, and fly it on a trajectory of minimum jerk inside polytopes of free space."""

    margin: NonNegative = 0.05
    """m, of clearance beyond the radius of the vehicle: for what the flight is off the plan"""
    reach: Positive = 0.8
    """m, beside the way, within which the trajectory heeds obstacles from the start; others when it comes near them"""
    search: Literal["grid"] | Sampling = "grid"
    """how the way is found: on a lattice, which finds the shortest and knows when there is none, or by samples"""
    checks: Annotated[int, Ge(1), Le(10_000_000)] = 20_000
    """points and legs that are checked when it is by samples"""
    yaw: Look = "fixed"
    """fixed: as at the start; velocity: where it flies"""

    names: ClassVar[tuple[str, ...]] = ()
    replans: ClassVar[bool] = True

    def allowed(self, tolerance: float) -> None:
        """Allow any deviation from the straight legs."""

    def plan(self, task: PlanningTask) -> Trajectory:
        """Return the trajectory with its yaw; it begins with the motion of the task and ends at rest.

        Raises:
            Unreachable: obstacles leave no way.
        """
        return facing(self.curve(task, np.inf if at_rest(task.motion) else HORIZON), self.yaw)

    def curve(self, task: PlanningTask, horizon: float) -> PiecewisePolynomial:
        """Return the trajectory along as much of the way as is within a horizon (m).

        Raises:
            Unreachable: obstacles leave no way.
        """
        limits, start = limits_of(task, EASE), task.waypoints[0]
        free = Free(task.world, task.radius + self.margin, self.reach, room(task.world, task.radius), limits)
        check_goals(task)
        way, through = self.way(task, free.box, horizon)
        if length(way) < NEAR:
            return settled(start, task.motion, task.waypoints[-1], limits)
        way, through = begun(way, through, horizon)
        found = fitted(free, way, through, task.motion)
        if found is not None:
            return found
        return stop_and_go(way, limits) if at_rest(task.motion) else self.slowed(task, free)

    def slowed(self, task: PlanningTask, free: Free) -> PiecewisePolynomial:
        """Return the trajectory that leads to where it could stop and on from there; it stops there if it must.

        With all the acceleration that the task allows.
        """
        start, free = task.waypoints[0], replace(free, limits=limits_of(task, 1.0))
        stop = braking(task.world, start, task.motion, free.clearance, free.limits)
        turn = stop(stop.duration)
        later = rested(task, turn)
        if np.linalg.norm(turn - start) > NEAR and np.linalg.norm(turn - task.waypoints[1]) > NEAR:
            way, through = self.way(later, free.box, HORIZON)
            way, through = np.concatenate([start[None], way]), np.concatenate([[False], through])
            found = fitted(free, *begun(way, through, HORIZON), task.motion)
            if found is not None:
                return found
        return after(stop, self.curve(later, HORIZON))

    def way(self, task: PlanningTask, box: Array, horizon: float) -> tuple[Array, NDArray[np.bool_]]:
        """Return the way (n, 3) m through the waypoints, and which of its points they are (n,).

        With a horizon (m) one with ample room, unless it is a detour; else the one of `tight`.

        Raises:
            Unreachable: obstacles leave no way.
        """
        if np.isinf(horizon):
            return self.tight(task, box, MARGINS[:-1], REPAIRS)
        try:
            ample, through = self.ways(task, task.radius + max(AMPLE, self.margin), box, FEW_REPAIRS)
        except Unreachable:
            return self.tight(task, box, MARGINS[:1], FEW_REPAIRS)
        if length(ample) <= DETOUR * length(task.waypoints):
            return ample, through
        way, passed = self.tight(task, box, MARGINS[:1], FEW_REPAIRS)
        return (ample, through) if length(ample) <= DETOUR * length(way) + CURIOSITY else (way, passed)

    def tight(
        self, task: PlanningTask, box: Array, shares: tuple[float, ...], repairs: int
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Return the same way with the first of some shares of the margin that there is one with, else with less.

        That is a quarter of it, or a little more than what the map's distances may be too large by: less, and a layer
        that guards the flight would not let it through.

        Raises:
            Unreachable: obstacles leave no way.
        """
        for share in shares:
            try:
                return self.ways(task, task.radius + share * self.margin, box, repairs)
            except Unreachable:
                continue
        least = max(MARGINS[-1] * self.margin, min(task.world.optimism + DOUBT, self.margin))
        return self.ways(task, task.radius + least, box, REPAIRS)

    def ways(self, task: PlanningTask, clearance: float, box: Array, repairs: int) -> tuple[Array, NDArray[np.bool_]]:
        """Return the way with a clearance (m), with few legs, and which of its points are waypoints."""
        points, through = [task.waypoints[:1]], [False]
        for start, goal in pairwise(task.waypoints):
            if self.search == "grid":
                way = find_way(task.world, start, goal, clearance, box, max(REACH, clearance), repairs)
            else:
                way = sampled_way(task.world, start, goal, clearance, box, self.search, self.checks)
            way = direct(task.world, way, clearance - CLOSER)
            points.append(way[1:])
            through += [False] * (len(way) - 2) + [True]
        return np.concatenate(points), np.array(through)


def begun(way: Array, through: NDArray[np.bool_], horizon: float) -> tuple[Array, NDArray[np.bool_]]:
    """Return the first part of a way (n, 3) m up to a horizon (m), and which of its points are waypoints."""
    arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    if arcs[-1] <= horizon:
        return way, through
    last = int(np.searchsorted(arcs, horizon - NEAR))
    share = min((horizon - arcs[last - 1]) / (arcs[last] - arcs[last - 1]), 1.0)
    end = way[last - 1] + share * (way[last] - way[last - 1])
    return np.concatenate([way[:last], end[None]]), np.append(through[:last], False)


def check_goals(task: PlanningTask) -> None:
    """Refuse waypoints where the vehicle would touch an obstacle."""
    distances = task.world.distance(task.waypoints[1:])
    near = np.flatnonzero(distances < task.radius)
    if near.size:
        distance, last = float(distances[near[0]]), near[0] == len(distances) - 1
        where = (
            f"is inside an obstacle, {-distance:.3g} m deep"
            if distance <= 0.0
            else f"is {distance:.3g} m from an obstacle"
        )
        message = f"{where}; at least the vehicle's radius, {task.radius:g} m, is needed"
        raise Unreachable("auto", [Problem("goal" if last else f"waypoints[{near[0] + 1}]", message)])


def limits_of(task: PlanningTask, share: float) -> MotionLimits:
    """Return the limits of a task, finite, with a share of its acceleration."""
    envelope = task.envelope
    return MotionLimits(
        speed=task.speed,
        speed_vertical=envelope.speed_vertical,
        acceleration=share * min(envelope.acceleration, STRONGEST),
        acceleration_vertical=min(envelope.acceleration_vertical, STRONGEST),
    )


def rested(task: PlanningTask, position: Array) -> PlanningTask:
    """Return what is left of a task at rest at a position (3,) m."""
    waypoints = np.concatenate([position[None], task.waypoints[1:]])
    return replace(task, waypoints=waypoints, motion=np.zeros((2, 3)))


def room(world: Map, radius: float) -> Array:
    """Return the lowest and highest corner of the space that may be flown, (2, 3) m, infinite where it is open."""
    box = np.array([[-np.inf] * 3, [np.inf] * 3])
    if world.bounds is not None:
        box = world.bounds + np.array([[EDGE], [-EDGE]])
    box[0, 2] = max(box[0, 2], world.ground + radius + EDGE)
    return box
