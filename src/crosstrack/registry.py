"""The parts a mission can name: (role, name) to class.

Built-ins are the lines below; other packages add theirs as entry points of the group `crosstrack.<role>`.
A part is a frozen dataclass: its fields are its mission schema, its documentation and its `--set` paths.
"""

from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from crosstrack.errors import InputError, Problem

BUILT_IN: dict[str, dict[str, str]] = {
    "vehicle": {
        "quadrotor": "crosstrack.vehicles.quadrotor:Quadrotor",
        "point": "crosstrack.vehicles.point:Point",
        "airsim": "crosstrack.vehicles.airsim.vehicle:AirSim",
    },
    "planner": {
        "minimum_snap": "crosstrack.plan.minimum:MinimumSnap",
        "minimum_jerk": "crosstrack.plan.minimum:MinimumJerk",
        "auto": "crosstrack.plan.auto:Auto",
        "file": "crosstrack.plan.from_file:FromFile",
    },
    "tracker": {
        "carrot": "crosstrack.follow.carrot:Carrot",
        "nlgl": "crosstrack.follow.nlgl:Nlgl",
        "npfg": "crosstrack.follow.npfg:Npfg",
        "lqr_path": "crosstrack.follow.lqr_path:LqrPath",
        "move_on_path": "crosstrack.follow.move_on_path:MoveOnPath",
        "published_carrot": "crosstrack.follow.published_carrot:PublishedCarrot",
        "pure_pursuit": "crosstrack.follow.pure_pursuit:PurePursuit",
        "vector_field": "crosstrack.follow.vector_field:VectorField",
        "proportional_los": "crosstrack.follow.proportional_los:ProportionalLos",
        "policy": "crosstrack.follow.policy:Policy",
        "feed_forward": "crosstrack.track.feed_forward:FeedForward",
        "cascaded_pid": "crosstrack.track.cascaded_pid:CascadedPid",
        "lqr": "crosstrack.track.lqr:Lqr",
        "geometric": "crosstrack.track.geometric:Geometric",
        "incremental": "crosstrack.track.incremental:Incremental",
        "mpc": "crosstrack.track.mpc:Mpc",
    },
    "avoider": {
        "potential": "crosstrack.avoid.potential:Potential",
        "orca": "crosstrack.avoid.orca:Orca",
        "formation": "crosstrack.avoid.formation:Formation",
        "policy": "crosstrack.avoid.policy:Policy",
        "safety": "crosstrack.avoid.safety:Safety",
    },
    "sensor": {
        "lidar": "crosstrack.sense.lidar:Lidar",
        "depth_camera": "crosstrack.sense.depth_camera:DepthCamera",
        "distance_ring": "crosstrack.sense.distance_ring:DistanceRing",
    },
    "generator": {
        "forest": "crosstrack.world.generate:Forest",
        "maze": "crosstrack.world.generate:Maze",
        "city": "crosstrack.world.generate:City",
        "gap": "crosstrack.world.generate:Gap",
        "trap": "crosstrack.world.generate:Trap",
    },
}


@cache
def table(role: str) -> dict[str, str]:
    """Return name to `module:class` of one role, built-ins first."""
    found = dict(BUILT_IN[role])
    for point in entry_points(group=f"crosstrack.{role}"):
        found.setdefault(point.name, point.value)
    return found


def roles() -> list[str]:
    """Return the roles that have a registry."""
    return list(BUILT_IN)


def names(role: str) -> list[str]:
    """Return the registered names of a role, in order of registration."""
    return list(table(role))


def find(role: str, name: str) -> type[Any]:
    """Import and return the class registered under a role and a name.

    Raises:
        InputError: no such name; the message lists those there are.
    """
    target = table(role).get(name)
    if target is None:
        known = ", ".join(names(role)) or "none registered"
        raise InputError(f"{role}", [Problem("kind", f"unknown {role} {name!r}; known: {known}")])
    module, _, attribute = target.partition(":")
    part: type[Any] = getattr(import_module(module), attribute)
    return part
