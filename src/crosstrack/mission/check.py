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
from crosstrack.protocols import EXACT, FromFiles
from crosstrack.types import Air, Array
from crosstrack.world.files import read
from crosstrack.world.world import World

if TYPE_CHECKING:
    from crosstrack.mission.mission import Mission

OF_A_MEMBER = ("start", "route", "goal")
"""fields that each of several vehicles may have of its own"""
TURN = 2 * math.pi
"""rad"""

Faults = Iterator[tuple[Place, str]]


def faults(mission: "Mission", broken: Collection[str] = ()) -> Faults:
    """Yield everything that does not fit, with its place.

    A check is left out where one of the fields that it reads is broken, or was found wrong before.
    """
    if mission.vehicles:
        yield from fleet_faults(mission, broken)
        return
    ruined = set(broken)
    for needs, check in CHECKS:
        if ruined.isdisjoint(needs):
            found = list(check(mission))
            ruined |= {str(place[0]) for place, _ in found}
            yield from found


def fleet_faults(mission: "Mission", broken: Collection[str]) -> Faults:
    """Yield what does not fit in a mission of several vehicles: of what they share, once."""
    names = [member.name for member in mission.vehicles]
    for index, name in enumerate(names):
        if name in names[:index]:
            yield ("vehicles", index, "name"), f"{name!r} is the name of another vehicle too"
    told: set[tuple[Place, str]] = set()
    for index, member in enumerate(mission.members):
        for place, message in faults(member, broken):
            own = place[0] in OF_A_MEMBER and getattr(mission.vehicles[index], str(place[0])) is not None
            fault: tuple[Place, str] = (("vehicles", index, *place) if own else place, message)
            if fault not in told:
                told.add(fault)
                yield fault
    yield from starts_are_apart(mission)


def starts_are_apart(mission: "Mission") -> Faults:
    """Find vehicles that would start inside one another."""
    places = np.array([member.launch for member in mission.members])
    for index in range(1, len(places)):
        near = np.linalg.norm(places[:index] - places[index], axis=1)
        other = int(near.argmin())
        if near[other] < 2 * mission.vehicle.radius:
            message = f"is {near[other]:.3g} m from that of {mission.vehicles[other].name!r}"
            yield ("vehicles", index, "start"), f"{message}; at least two radii, {2 * mission.vehicle.radius:g} m"


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


def leads_one_way(mission: "Mission") -> Faults:
    """Ask for a route or a goal, and not both."""
    if (mission.route is None) == (mission.goal is None):
        found = "both are given" if mission.goal is not None else "neither is given"
        yield ("route",), f"either a route or a goal is needed; {found}"
    elif mission.goal is not None and mission.planner is not None and not mission.planner.replans:
        kind = kind_of("planner", mission.planner)
        yield ("planner",), f"{kind} finds no way to a goal: use planner: {{kind: auto}}, or give a route"
    elif mission.goal is not None and mission.loop:
        yield ("loop",), "leads back along a route; with a goal there is none"


def points_are_alike(mission: "Mission") -> Faults:
    """Find points of another dimension than the first."""
    if mission.route is None or isinstance(mission.route, str):
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


def sees_what_it_must(mission: "Mission") -> Faults:
    """Ask for a sensor where nothing is told."""
    if mission.map == "unknown" and not mission.sensors:
        yield ("map",), "is unknown, and nothing sees it: add sensors, such as sensors: [{kind: lidar}]"


def avoiders_can_act(mission: "Mission") -> Faults:
    """Ask for a tracker that commands motions where an avoider bends them."""
    tracker = mission.tracker
    assert tracker is not None  # it was given its default
    for index, avoider in enumerate(mission.avoid):
        if not avoider.guards and "attitude" in tracker.needs:
            bends, flies = kind_of("avoider", avoider), kind_of("tracker", tracker)
            message = f"{bends} changes velocities, and the tracker {flies} commands attitudes or rates"
            yield ("avoid", index), f"{message}: use a follower, or feed_forward"


def policies_fit(mission: "Mission") -> Faults:
    """Read the policies, and ask for sensors that show them what they were trained on."""
    places: list[tuple[Place, object]] = [(("tracker",), mission.tracker)]
    places += [(("avoid", index), avoider) for index, avoider in enumerate(mission.avoid)]
    for place, part in places:
        if not isinstance(part, FromFiles):
            continue
        try:
            ready = part.given({name: read(mission.files, name) for name in part.names})
            blind = ready.blind(mission.sensors)
        except InputError as error:
            yield from (((*place, "file"), f"{error.source}: {problem}") for problem in error.problems)
            continue
        if blind:
            yield place, blind


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
        found = _point_faults(mission, np.array([point]), mission.obstacles)[0]
        yield from ((place, message) for message in found)


def route_is_clear(mission: "Mission") -> Faults:
    """Check every point of the route against ground, bounds and obstacles."""
    for index, messages in enumerate(_point_faults(mission, mission.waypoints, mission.told)):
        place: Place = ("goal",) if mission.goal else ("route",) if mission.survey else ("route", index)
        label = f"point {index} of {mission.route} " if mission.survey else ""
        yield from ((place, label + message) for message in messages)


def _point_faults(mission: "Mission", points: Array, world: World) -> list[list[str]]:
    """Return what is wrong with each of some points (n, 3) in a world, at most 20 points' worth."""
    radius = mission.vehicle.radius
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
    (frozenset({"route", "goal", "planner", "loop", "vehicles"}), leads_one_way),
    (frozenset({"route"}), points_are_alike),
    (frozenset({"route", "origin"}), route_is_read),
    (frozenset({"world", "frame"}), world_is_built),
    (frozenset({"planner", "start"}), planner_fits),
    (frozenset({"map", "sensors"}), sees_what_it_must),
    (frozenset({"avoid", "tracker", "planner"}), avoiders_can_act),
    (frozenset({"avoid", "tracker", "sensors"}), policies_fit),
    (
        frozenset({"planner", "tracker", "vehicle", "start", "frame", "world", "limits", "air", "noise"}),
        tracker_has_what_it_needs,
    ),
    (frozenset({"start", "route", "goal", "origin", "frame", "world", "loop", "vehicles"}), route_leads_somewhere),
    (frozenset({"start", "frame", "world", "vehicle"}), start_is_sound),
    (frozenset({"start", "route", "goal", "map", "origin", "frame", "world", "vehicle", "vehicles"}), route_is_clear),
)


def remarks(mission: "Mission") -> list[str]:
    """Say what of the `.plan` file is not flown, which legs come too close, and what looks like a slip.

    Legs are not flown where there is a planner: its trajectory has a certificate.
    """
    yaw = mission.start.yaw
    return [
        *(f"{mission.route}: {remark}" for remark in (mission.survey.remarks if mission.survey else ())),
        *([f"start.yaw is {yaw:g} rad, more than a full turn: was it meant in degrees?"] if abs(yaw) > TURN else []),
        *unheard(mission),
        *(leg_remarks(mission) if mission.planner is None and not mission.avoid else ()),
    ]


def unheard(mission: "Mission") -> list[str]:
    """Say what a mission says to the embedded simulator alone, where another one flies it."""
    if mission.vehicle.stand_in is mission.vehicle:
        return []
    told = {"mismatch": mission.mismatch != EXACT, "air": mission.air != Air()}
    return [f"{name} is for the embedded simulator: this vehicle does not hear of it" for name in told if told[name]]


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
