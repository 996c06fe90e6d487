"""From the route of a mission to the course that is flown."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.flight.plan import Replanning
from crosstrack.follow.course import RESERVE, plan_course
from crosstrack.path.pace import course_of
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course, Path, Planner, PlanningTask, Scenario
from crosstrack.registry import find
from crosstrack.world.files import read

if TYPE_CHECKING:
    from crosstrack.mission.mission import Mission

SPACING = 0.1
"""m, between the points that a way which was found is kept as"""


def course_for(mission: "Mission", route: Polyline, scenario: Scenario) -> Course:
    """Return the course of a mission: its planner's trajectory, or without one its route, rounded and paced.

    Raises:
        InputError: the planner cannot plan this.
        Infeasible: no trajectory keeps within what is asked for.
    """
    envelope = mission.vehicle.envelope(scenario)
    if mission.planner is None:
        joins = None if mission.start.on_route else mission.launch
        return plan_course(route, mission.tolerance, mission.speed, envelope, joins)
    if not envelope.stops:
        message = "plans from rest to rest, and this kind of vehicle cannot stop"
        raise InputError(mission.name, [Problem("planner", message)])
    trajectory = mission.planner.plan(task_for(mission, mission.planner, route, scenario))
    return replace(course_of(trajectory, envelope), corners=route.points)


def task_for(mission: "Mission", planner: Planner, route: Polyline, scenario: Scenario) -> PlanningTask:
    """Return what a mission asks of a planner; a share of the acceleration is left to the tracker."""
    envelope = mission.vehicle.envelope(scenario)
    reserved = replace(
        envelope,
        acceleration=RESERVE * envelope.acceleration,
        acceleration_vertical=RESERVE * envelope.acceleration_vertical,
    )
    return PlanningTask(
        waypoints=route.points,
        speed=min(mission.speed, envelope.speed),
        tolerance=mission.tolerance,
        envelope=reserved,
        world=mission.told,
        radius=mission.vehicle.radius,
        files={name: read(mission.files, name) for name in planner.names},
    )


def replanning_for(mission: "Mission", route: Polyline, scenario: Scenario) -> Replanning | None:
    """Return how a mission is planned again in flight; None where it is not."""
    planner: Planner | None = mission.planner
    own = planner is not None and planner.replans
    when = mission.replan
    if when == "auto":
        uncertain = mission.map == "unknown" or bool(mission.sensors)
        bending = any(not avoider.guards for avoider in mission.avoid)
        when = "blocked" if own and uncertain else "trapped" if bending else "never"
    if when == "never":
        return None
    if planner is None or not planner.replans:
        planner = find("planner", "auto")()
    return Replanning(planner, task_for(mission, planner, route, scenario), when == "blocked")


def along(path: Path) -> Polyline:
    """Return a path as a polyline, for what is measured against it."""
    return Polyline(path(np.linspace(0.0, path.length, max(2, int(path.length / SPACING) + 1))))
