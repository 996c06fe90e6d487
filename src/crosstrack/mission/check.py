"""What the schema cannot see: how the fields of a mission fit each other and the world."""

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.mission.complaints import faults_of
from crosstrack.mission.parts import kind_of
from crosstrack.mission.text import Document, Place, show
from crosstrack.mission.values import sound
from crosstrack.types import Array
from crosstrack.world.files import read

if TYPE_CHECKING:
    from crosstrack.mission.mission import Mission

TURN = 2 * math.pi
"""rad"""

Faults = Iterator[tuple[Place, str]]


def faults(mission: "Mission", broken: Collection[str] = ()) -> Faults:
    """Yield everything that does not fit, with its place.

    A check is left out where one of the fields that it reads is broken, or was found wrong before.
    """
    ruined = set(broken)
    for needs, check in CHECKS:
        if ruined.isdisjoint(needs):
            found = list(check(mission))
            ruined |= {str(place[0]) for place, _ in found}
            yield from found


def assure(mission: "Mission") -> None:
    """Check a mission that was made in Python rather than read.

    Raises:
        InputError: everything that is wrong with it.
    """
    found: list[Problem] = []
    document = Document(str(mission.name), sound(mission.document(), found))
    found += faults_of(document)
    if not found:
        found = [Problem(show(place), message) for place, message in faults(mission)]
    if found:
        raise InputError(document.source, found)


def speed_is_allowed(mission: "Mission") -> Faults:
    """Compare the cruise speed with its limit."""
    if mission.speed > mission.limits.speed:
        yield ("speed",), f"{mission.speed:g} m/s is above limits.speed, {mission.limits.speed:g} m/s"


def points_are_alike(mission: "Mission") -> Faults:
    """Find points of another dimension than the first."""
    if isinstance(mission.route, str):
        return
    first = len(mission.route[0])
    for index, point in enumerate(mission.route):
        if len(point) != first:
            yield (
                ("route", index),
                f"has {len(point)} coordinates, route[0] has {first}: give all of them 2, or all 3",
            )


def route_is_read(mission: "Mission") -> Faults:
    """Read the `.plan` file."""
    try:
        _ = mission.survey
    except InputError as error:
        yield from ((("route",), f"{error.source}: {problem}") for problem in error.problems)


def world_is_built(mission: "Mission") -> Faults:
    """Read the world's files and make its obstacles; where that fails, try each source alone."""
    try:
        _ = mission.obstacles
    except InputError:
        world = mission.enu.world
        alone = replace(world, shapes=(), generate=None, image=None, cloud=None)
        for name in ("generate", "image", "cloud"):
            try:
                replace(alone, **{name: getattr(world, name)}).build(mission.files)
            except InputError as error:
                yield from ((("world", name), f"{error.source}: {problem}") for problem in error.problems)


def planner_fits(mission: "Mission") -> Faults:
    """Read the planner's files, and ask for a start that its trajectory can begin at."""
    if mission.planner is None:
        return
    if not mission.start.on_route:
        yield ("planner",), "plans from the start, which must be on the route: start.on_route is false"
    for name in mission.planner.names:
        try:
            read(mission.files, name)
        except InputError as error:
            yield from ((("planner",), f"{error.source}: {problem}") for problem in error.problems)


def tracker_has_what_it_needs(mission: "Mission") -> Faults:
    """Ask for a planner where the tracker follows a trajectory, and for a vehicle that takes what it commands."""
    tracker, scenario = mission.tracker, mission.scenario()
    assert tracker is not None  # it was given its default
    kind = kind_of("tracker", tracker)
    if "trajectory" in tracker.needs and mission.planner is None:
        yield ("tracker",), f"{kind} follows a trajectory: add a planner, such as planner: {{kind: minimum_snap}}"
    try:
        envelope = mission.vehicle.envelope(scenario)
    except InputError as error:
        yield from (((error.source, problem.place), problem.message) for problem in error.problems)
        return
    if "attitude" in tracker.needs and envelope.model is None:
        vehicle = kind_of("vehicle", mission.vehicle)
        yield ("tracker",), f"{kind} commands attitudes or rates, which the vehicle {vehicle} does not take"


def route_leads_somewhere(mission: "Mission") -> Faults:
    """Ask for two distinct points."""
    points = mission.points
    if np.ptp(points, axis=0).max() == 0.0:
        where = "the start and its points" if mission.start.on_route else "its points"
        yield ("route",), f"needs at least 2 distinct points, but {where} all lie at {_write(points[0])}"


def start_is_sound(mission: "Mission") -> Faults:
    """Check the start against ground, bounds and obstacles."""
    start = mission.enu.start
    place: Place = ("start", "position")
    above = start.position[2] - mission.enu.world.ground
    if start.takeoff and above <= 0.0:
        where = f"{-above:g} m below" if above < 0.0 else "on"
        yield place, f"is {where} the ground: a takeoff climbs to it, so it must be above"
    for point in {tuple(start.position), tuple(mission.launch)}:
        yield from ((place, message) for message in _point_faults(mission, np.array([point]))[0])


def route_is_clear(mission: "Mission") -> Faults:
    """Check every point of the route against ground, bounds and obstacles."""
    for index, messages in enumerate(_point_faults(mission, mission.waypoints)):
        place: Place = ("route",) if mission.survey else ("route", index)
        label = f"point {index} of {mission.route} " if mission.survey else ""
        yield from ((place, label + message) for message in messages)


def _point_faults(mission: "Mission", points: Array) -> list[list[str]]:
    """Return what is wrong with each of some points (n, 3), at most 20 points' worth."""
    world, radius = mission.obstacles, mission.vehicle.radius
    clearance = world.distance(points)
    low, high = world.bounds if world.bounds is not None else (np.full(3, -np.inf), np.full(3, np.inf))
    outside = np.maximum(np.maximum(low - points, points - high), 0.0).max(axis=1)
    deep = world.ground - points[:, 2]
    found: list[list[str]] = [[] for _ in points]
    wrong = np.flatnonzero((clearance < radius) | (outside > 0) | (deep > 0))
    for index in wrong[:20]:
        where = _write(points[index])
        if outside[index] > 0:
            found[index].append(f"{where} lies {outside[index]:.3g} m outside world.bounds")
        if deep[index] > 0:
            found[index].append(f"{where} lies {deep[index]:.3g} m below the ground")
        if clearance[index] < radius:
            found[index].append(_too_close(where, float(clearance[index]), radius))
    return found


def _too_close(where: str, clearance: float, radius: float) -> str:
    near = f"{clearance:.3g} m from" if clearance >= 0 else f"{-clearance:.3g} m inside"
    return f"{where} lies {near} an obstacle; at least vehicle.radius, {radius:g} m, is needed"


def _write(point: Array) -> str:
    return "(" + ", ".join(f"{value:g}" for value in point) + ")"


CHECKS: tuple[tuple[frozenset[str], Callable[["Mission"], Faults]], ...] = (
    (frozenset({"speed", "limits"}), speed_is_allowed),
    (frozenset({"route"}), points_are_alike),
    (frozenset({"route", "origin"}), route_is_read),
    (frozenset({"world", "frame"}), world_is_built),
    (frozenset({"planner", "start"}), planner_fits),
    (
        frozenset({"planner", "tracker", "vehicle", "start", "frame", "world", "limits", "air", "noise"}),
        tracker_has_what_it_needs,
    ),
    (frozenset({"start", "route", "origin", "frame", "world", "loop"}), route_leads_somewhere),
    (frozenset({"start", "frame", "world", "vehicle"}), start_is_sound),
    (frozenset({"start", "route", "origin", "frame", "world", "vehicle"}), route_is_clear),
)


def remarks(mission: "Mission") -> list[str]:
    """Say what of the `.plan` file is not flown, which legs come too close, and what looks like a slip.

    Legs are not flown where there is a planner: its trajectory has a certificate.
    """
    yaw = mission.start.yaw
    return [
        *(f"{mission.route}: {remark}" for remark in (mission.survey.remarks if mission.survey else ())),
        *([f"start.yaw is {yaw:g} rad, more than a full turn: was it meant in degrees?"] if abs(yaw) > TURN else []),
        *(leg_remarks(mission) if mission.planner is None else ()),
    ]


def leg_remarks(mission: "Mission") -> list[str]:
    """Say which legs of the route, the first 10, come too close to an obstacle or go through one."""
    world, radius = mission.obstacles, mission.vehicle.radius
    clearances = ((a, b, world.swept(a, b)) for a, b in pairwise(mission.points))
    close = [
        f"the leg from {_write(a)} to {_write(b)} "
        + (
            "goes through an obstacle"
            if least < 0
            else f"passes an obstacle at {least:.2f} m, nearer than vehicle.radius, {radius:g} m"
        )
        for a, b, least in clearances
        if least < radius
    ]
    return close[:10]
