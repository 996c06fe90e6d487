"""A mission: what its file says, and what follows from it."""

import time
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.flight.plan import Plan
from crosstrack.frames import Origin
from crosstrack.mission.check import assure
from crosstrack.mission.convert import in_enu
from crosstrack.mission.document import plain
from crosstrack.mission.parts import given
from crosstrack.mission.planning import along, course_for, replanning_for
from crosstrack.mission.qgroundcontrol import PlanFile, read_plan
from crosstrack.mission.schema import MissionFile
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import FromFiles, Scenario
from crosstrack.registry import find
from crosstrack.types import Array
from crosstrack.world.files import Files, read
from crosstrack.world.world import World


@dataclass(frozen=True, kw_only=True)
class Mission(MissionFile):
    """A mission as its file says it, read from a folder.

    Example:
        >>> import crosstrack as ct
        >>> mission = ct.Mission(start=ct.Start((0, 0, 10)), route=((20, 0), (20, 20)))
        >>> mission.build().route.length
        40.0
    """

    files: Files = field(default=Path(), compare=False, repr=False)
    """the folder that the names of files start from, or the contents of the files by name"""

    def document(self) -> dict[str, Any]:
        """Return everything the mission says, defaults included, as JSON has it."""
        document: dict[str, Any] = plain(replace(self, files={}))
        del document["files"]
        return document

    @cached_property
    def enu(self) -> MissionFile:
        """The same mission in the library's own frame."""
        return in_enu(self)

    @cached_property
    def survey(self) -> PlanFile | None:
        """What the route's `.plan` file holds; None where the route is points."""
        if not isinstance(self.route, str):
            return None
        return read_plan(self.route, read(self.files, self.route), self.origin)

    @cached_property
    def obstacles(self) -> World:
        """The world, built.

        Raises:
            InputError: one of its files is missing or wrong.
        """
        return self.enu.world.build(self.files)

    @cached_property
    def told(self) -> World:
        """What the vehicle is told of the obstacles."""
        if self.map == "unknown":
            return World(bounds=self.obstacles.bounds, ground=self.obstacles.ground)
        return self.enu.world.told(self.obstacles)

    @cached_property
    def members(self) -> tuple["Mission", ...]:
        """The missions of the `vehicles`, one each; of a single vehicle, the mission itself."""
        if not self.vehicles:
            return (self,)
        return tuple(self._member(index) for index in range(len(self.vehicles)))

    def _member(self, index: int) -> "Mission":
        said = self.vehicles[index]
        goes = self if said.route is None and said.goal is None else said
        mission = replace(
            self,
            name=said.name,
            start=said.start,
            route=goes.route,
            goal=goes.goal,
            vehicles=(),
            replan="never" if self.replan == "auto" and self.map == "known" else self.replan,
            seed=self.seed + index,
            files=self.files,
        )
        vars(mission)["obstacles"] = self.obstacles  # the same world, built once
        return mission

    @property
    def place(self) -> Origin:
        """WGS84 place of the local (0, 0, 0)."""
        return self.origin or (self.survey.home if self.survey else None) or Origin()

    @property
    def names(self) -> list[str]:
        """The files that the mission names."""
        planned = self.planner.names if self.planner is not None else ()
        learned = [name for part in (self.tracker, *self.avoid) if isinstance(part, FromFiles) for name in part.names]
        return [*([self.route] if isinstance(self.route, str) else []), *self.world.files(), *planned, *learned]

    @cached_property
    def waypoints(self) -> Array:
        """The route's own points in the library's frame, (n, 3) m."""
        if self.survey is not None:
            return self.survey.points
        height = self.enu.start.position[2]
        points = self.enu.route if self.enu.goal is None else (self.enu.goal,)
        return np.array([(*point, height)[:3] for point in points or ()], float)

    @cached_property
    def points(self) -> Array:
        """The whole route, from where it begins to where it ends, (n, 3) m."""
        start = self.enu.start
        above = [np.array(start.position)] if start.on_route else []
        below = [self.launch] if start.on_route and start.takeoff else []
        closed = [(above or [self.waypoints[0]])[0]] if self.loop else []
        return np.array([*below, *above, *self.waypoints, *closed])

    @property
    def launch(self) -> Array:
        """Where the vehicle starts, (3,) m."""
        start = self.enu.start
        return np.array([*start.position[:2], self.enu.world.ground if start.takeoff else start.position[2]])

    def with_vehicle(self, kind: str) -> "Mission":
        """Return the mission flown by another kind of vehicle, which keeps the fields that both kinds have.

        Raises:
            InputError: no such vehicle.
        """
        vehicle = find("vehicle", kind)
        common = {f.name for f in fields(vehicle)} & {f.name for f in fields(self.vehicle)}
        return replace(self, vehicle=vehicle(**{name: getattr(self.vehicle, name) for name in common}))

    def build(self) -> Plan:
        """Return the mission as objects, ready to fly.

        Raises:
            InputError: everything that is wrong with the mission, or it is of several vehicles.
            Infeasible: no trajectory keeps within what is asked for, or there is no way to the goal.
        """
        if self.vehicles:
            raise InputError(self.name, [Problem("vehicles", "are several: build their `plans`, or `fly_together`")])
        return self.plans()[0]

    def plans(self) -> list[Plan]:
        """Return what each of the vehicles flies; of a mission of one vehicle, its plan alone.

        Raises:
            InputError: everything that is wrong with the mission.
            Infeasible: no trajectory keeps within what is asked for, or there is no way to a goal.
        """
        assure(self)
        return [member.plan(member.name if self.vehicles else "") for member in self.members]

    def plan(self, name: str) -> Plan:
        """Return the mission as objects, once it is known to be sound; with the name of its vehicle among several."""
        scenario, tracker = replace(self.scenario(), name=name), self.tracker
        assert tracker is not None  # it was given its default
        route, began = Polyline(self.points), time.perf_counter()
        course = course_for(self, route, scenario)
        planning_time = time.perf_counter() - began
        files = {name: read(self.files, name) for name in self.names}
        return Plan(
            name=self.name,
            document=self.document(),
            route=route if self.goal is None else along(course.path),
            course=course,
            vehicle=self.vehicle,
            tracker=given(tracker, files),
            scenario=scenario,
            timeout=self.timing.timeout,
            avoiders=tuple(given(avoider, files) for avoider in self.avoid),
            told=self.told,
            warned=self.map == "known",
            replanning=replanning_for(self, route, scenario),
            planning_time=planning_time,
            files=files,
        )

    def scenario(self) -> Scenario:
        """Return what the vehicle is launched into."""
        return Scenario(
            position=self.launch,
            yaw=self.enu.start.yaw,
            world=self.obstacles,
            cruise=self.speed,
            limits=self.limits,
            wind=self.enu.wind,
            air=self.air,
            noise=self.noise,
            period=1 / self.timing.rate,
            seed=self.seed,
            mismatch=self.mismatch,
            sensors=self.sensors,
            traffic=self.enu.world.traffic(),
        )
