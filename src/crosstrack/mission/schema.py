"""What a mission file may say: its fields, their units and defaults."""

from dataclasses import dataclass, field
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Ge, Le, Len
from pydantic import AfterValidator, ConfigDict, Discriminator, Tag

from crosstrack.frames import Origin
from crosstrack.mission.parts import CONFIG, Part
from crosstrack.registry import find
from crosstrack.types import Air, Finite, Limits, Mismatch, Noise, Positive, Vector, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.build import WorldSpec

MAX_SAMPLES = 5_000_000
"""most control steps one flight may take"""

Point = Annotated[tuple[Finite, ...], Len(2, 3)]
"""m; two coordinates are flown at the start's height"""
Points = Annotated[tuple[Point, ...], Len(1, 100_000)]


def _file_or_points(value: object) -> str:
    return "file" if isinstance(value, str) else "points"


def usual_tracker(planner: object) -> str:
    """Return the kind of tracker that a mission with or without a planner has by default."""
    return "carrot" if planner is None else "feed_forward"


def _plain_name(name: str) -> str:
    if PurePath(name).name != name or name in {"", ".."} or len(name) > 100 or not name.isprintable():
        raise ValueError(f"must be a plain name of 1 to 100 letters, without slash or line break, found {name!r:.60}")
    return name


Name = Annotated[str, AfterValidator(_plain_name)]
Route = Annotated[Annotated[str, Tag("file")] | Annotated[Points, Tag("points")], Discriminator(_file_or_points)]


@dataclass(frozen=True)
class Start:
    """Where the vehicle starts, at rest."""

    position: Vector
    """m"""
    yaw: Finite = 0.0
    """rad, counter-clockwise from east; clockwise from north with `frame: ned`"""
    takeoff: bool = False
    """start on the ground below and climb to the position first"""
    on_route: bool = True
    """the route leads from here through its points; false: it is its points alone, the start is off it"""


@dataclass(frozen=True)
class Member:
    """One of several vehicles that fly at once."""

    name: Name
    start: Start
    route: Points | None = None
    """points to fly through"""
    goal: Point | None = None
    """m, instead of a route: where to, by a way that is found"""


@dataclass(frozen=True)
class Timing:
    """How often the tracker is asked, and for how long at most."""

    rate: Annotated[float, Ge(1), Le(1000)] = 50.0
    """commands per second"""
    timeout: Positive = 300.0
    """s of flight"""

    def __post_init__(self) -> None:
        if self.rate * self.timeout > MAX_SAMPLES:
            raise ValueError(
                f"rate times timeout is {self.rate * self.timeout:g} steps; at most {MAX_SAMPLES} are allowed"
            )


@dataclass(frozen=True)
class World(WorldSpec):
    """What is in the way."""

    generate: Annotated[Any, Part("generator")] | None = None
    """obstacles made from a seed: forest, maze, city, gap or trap"""


@dataclass(frozen=True, kw_only=True)
class MissionFile:
    """Everything a mission file says."""

    __pydantic_config__: ClassVar[ConfigDict] = CONFIG

    name: Name = "mission"
    """what its results are filed under; that of the file, when left out of one"""
    start: Start
    """by default that of the first of the `vehicles`"""
    route: Route | None = None
    """points to fly through, or the name of a QGroundControl `.plan` file beside the mission"""
    goal: Point | None = None
    """m, instead of a route: where to, by a way that is found"""
    vehicles: Annotated[tuple[Member, ...], Len(0, 1000)] = ()
    """several that fly at once, each with what it says itself in place of what the mission says"""
    speed: Positive = 5.0
    """m/s, cruise"""
    tolerance: Positive = 0.3
    """m, cross-track error the speed profile plans for"""
    frame: Literal["enu", "ned"] = "enu"
    """world frame of start, route points, wind, and of the world's bounds, ground and shapes"""
    loop: bool = False
    """fly back to the route's first point at the end"""
    world: World = field(default_factory=World)
    vehicle: Annotated[Any, Part("vehicle")] = field(default_factory=Quadrotor)
    map: Literal["known", "unknown"] = "known"
    """whether the vehicle is told of the world, or must see it"""
    sensors: tuple[Annotated[Any, Part("sensor")], ...] = ()
    """what it sees with"""
    planner: Annotated[Any, Part("planner")] | None = None
    """what turns the route into a trajectory; left out, its corners are rounded and its speed is planned; auto by
    default where there is a goal"""
    tracker: Annotated[Any, Part("tracker")] | None = None
    """what follows: by default feed_forward where there is a planner, carrot elsewhere"""
    avoid: tuple[Annotated[Any, Part("avoider")], ...] = ()
    """what changes the tracker's commands, one after another"""
    replan: Literal["auto", "never", "trapped", "blocked"] = "auto"
    """when a new way is looked for in flight: where the vehicle is trapped, or also where the course is blocked; auto:
    blocked with a planner that finds ways and something unknown, trapped with any avoider that changes the course, else
    never, as with several vehicles in a known world"""
    limits: Limits = field(default_factory=Limits)
    wind: Wind = field(default_factory=Wind)
    air: Air = field(default_factory=Air)
    noise: Noise = field(default_factory=Noise)
    mismatch: Mismatch = field(default_factory=Mismatch)
    timing: Timing = field(default_factory=Timing)
    origin: Origin | None = None
    """WGS84 place of the local (0, 0, 0); by default the home of the `.plan` file, else AirSim's"""
    seed: Annotated[int, Ge(0), Le(2**63 - 1)] = 1
    """all that is random follows from it"""

    def __post_init__(self) -> None:
        if self.planner is None and (self.goal or any(member.goal for member in self.vehicles)):
            object.__setattr__(self, "planner", find("planner", "auto")())
        if self.tracker is None:
            object.__setattr__(self, "tracker", find("tracker", usual_tracker(self.planner))())
