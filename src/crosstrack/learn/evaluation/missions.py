"""The missions that policies are evaluated in, and what flies them beside a policy."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import numpy as np

from crosstrack.campaign.avoidance.contestants import CONTESTANTS, LIDAR, PATIENCE, SAFETY, SPARE, Contestant, document
from crosstrack.campaign.avoidance.families import FAMILIES, Arena
from crosstrack.learn.arenas import forest
from crosstrack.learn.follow import route
from crosstrack.policy.card import Card

POLICY, SAFE, FIELD, PLANNER, RANDOM, CARROT, NPFG = "policy", "safe", "field", "planner", "random", "carrot", "npfg"
SAYS = {
    POLICY: "The policy alone.",
    SAFE: "The policy with the safety layer behind it, which sees with the lidar of the potential field too.",
    FIELD: CONTESTANTS["field"].says,
    PLANNER: CONTESTANTS["unknown"].says,
    RANDOM: "Every action as likely as any other, at the rate of the policy.",
    CARROT: "The follower carrot at the speed of the policy.",
    NPFG: "The follower npfg at the speed of the policy.",
}
BESIDE = {"avoid": (SAFE, FIELD, PLANNER, RANDOM), "follow": (CARROT, NPFG)}
"""what may fly beside a policy of each task"""
FOREST, ROUTE = "forest", "route"
WORLDS = (FOREST, *(name for name in FAMILIES if not name.startswith(FOREST) and name != "closed"))
"""families of worlds in which there is a way to the goal"""
RATE = 50.0
"""Hz, of commands at least"""
WIND = 3.0
"""m/s, mean, while paths are followed"""
TOLERANCE = 1.0
"""m, within which the corners of routes are rounded, as they are in training"""


@dataclass(frozen=True)
class Where:
    """Worlds of one kind, of which every seed makes another."""

    family: str
    """one of WORLDS; or ROUTE, open air with a route"""
    density: float = 0.0
    """trees per m², of a forest"""

    @property
    def name(self) -> str:
        """What results are filed under."""
        return f"{FOREST}-{self.density:g}" if self.family == FOREST else self.family

    def arena(self, seed: int) -> Arena:
        """Return the arena of a seed."""
        return forest(self.density, seed) if self.family == FOREST else FAMILIES[self.family](self.family, seed)


def rate(period: float) -> float:
    """Return the rate of commands (Hz): the least from RATE on that is a multiple of the rate of decisions."""
    return math.ceil(RATE * period - 1e-9) / period


def mission(file: str, card: Card, where: Where, seed: int, contestant: str) -> dict[str, Any]:
    """Return the mission of a contestant, as a mission file would say it.

    Args:
        file: of the policy, as a mission names it
        card: of the policy
        where: in which worlds
        seed: of the world
        contestant: a key of SAYS that fits the task of the policy
    """
    made = avoiding if card.task == "avoid" else following
    plain: dict[str, Any] = json.loads(json.dumps(made(file, card.options, where, seed, contestant)))
    plain["vehicle"] = {
        "kind": "quadrotor",
        "airframe": card.options.get("airframe", "generic"),
        "radius": card.options.get("radius", 0.2),
    }
    return plain


def avoiding(file: str, options: Mapping[str, Any], where: Where, seed: int, contestant: str) -> dict[str, Any]:
    """Return the mission to get to a goal; all begin facing it."""
    arena = where.arena(seed)
    way = np.subtract(arena.goal, arena.start)
    said = document(arena, beside(file, options, contestant), float(np.linalg.norm(way)))
    said["start"]["yaw"] = math.atan2(way[1], way[0])
    if contestant in {POLICY, SAFE, RANDOM}:
        said["timing"]["rate"] = rate(options["period"])
    return said


def beside(file: str, options: Mapping[str, Any], name: str) -> Contestant:
    """Return a contestant of avoidance."""
    if name in {FIELD, PLANNER}:
        found = CONTESTANTS["field" if name == FIELD else "unknown"]
        return Contestant(name, found.says, found.speed, found.plans, found.mission)
    guarded = name == SAFE
    said = {
        "map": "unknown",
        # The policy goes by the last of those that see at once, its own: a few beams are no map to count on.
        "sensors": [*([LIDAR] if guarded else []), options["sensor"]],
        "avoid": [{"kind": "policy", "file": file}, *([SAFETY] if guarded else [])],
        "tracker": {"kind": "carrot"},
        "replan": "never",
    }
    return Contestant(name, SAYS[name], options["speed"], False, said)


def following(file: str, options: Mapping[str, Any], where: Where, seed: int, contestant: str) -> dict[str, Any]:
    """Return the mission to follow a route in wind from any side."""
    corners = route(seed)
    legs = np.diff(corners, axis=0)
    side = float(np.random.default_rng([seed, 1]).uniform(-math.pi, math.pi))
    length = float(np.linalg.norm(legs, axis=1).sum())
    return {
        "name": f"{where.name}-{seed}-{contestant}",
        "start": {"position": corners[0].tolist(), "yaw": math.atan2(legs[0, 1], legs[0, 0])},
        "route": corners[1:].tolist(),
        "speed": options["speed"],
        "tolerance": TOLERANCE,
        "seed": seed,
        "tracker": {"kind": "policy", "file": file} if contestant == POLICY else {"kind": contestant},
        "wind": {"mean": [WIND * math.cos(side), WIND * math.sin(side), 0.0], "gusts": "light"},
        "timing": {
            "timeout": round(PATIENCE * length / options["speed"] + SPARE, 1),
            "rate": rate(options["period"]),
        },
    }


def named(policy: str) -> str:
    """Return how a mission names a policy: its file without the folder, or its own name where it ships."""
    return PurePath(policy).name
