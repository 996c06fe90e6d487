"""Ways to get to a goal: what avoidance is measured of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from crosstrack.campaign.avoidance.families import Arena
from crosstrack.errors import InputError, Problem

LIDAR = {"kind": "lidar", "rings": 16, "columns": 360, "range": 15.0, "rate": 10.0}
SAFETY, POTENTIAL = {"kind": "safety"}, {"kind": "potential"}
BENDING = {"map": "unknown", "sensors": [LIDAR], "avoid": [POTENTIAL, SAFETY], "tracker": {"kind": "carrot"}}
PATIENCE = 4.0
"""times the time of the optimum that a flight is given"""
SPARE = 10.0
"""s, that it is given beside"""


@dataclass(frozen=True)
class Contestant:
    """How to get to a goal."""

    name: str
    says: str
    """what it does, as a sentence"""
    speed: float
    """m/s, cruise"""
    plans: bool
    """whether it looks for a way to begin with; one that does not flies straight at the goal"""
    mission: Mapping[str, Any]
    """what a mission says for it, beside start, goal and world"""


CONTESTANTS = {
    one.name: one
    for one in (
        Contestant(
            "planned",
            "Given the map: a planned trajectory, flown, with the safety layer behind it.",
            4.0,
            True,
            {"planner": {"kind": "auto"}, "map": "known", "avoid": [SAFETY]},
        ),
        Contestant(
            "unknown",
            "Without a map: planned on what the lidar has seen, again and again, with the safety layer behind it.",
            3.0,
            True,
            {"planner": {"kind": "auto"}, "map": "unknown", "sensors": [LIDAR], "avoid": [SAFETY]},
        ),
        Contestant(
            "fallback",
            "Without a map: straight at the goal, deflected by the potential field; where trapped, a way is planned.",
            3.0,
            False,
            {**BENDING, "replan": "trapped"},
        ),
        Contestant(
            "field",
            "Without a map and without any plan: straight at the goal, deflected by the potential field alone.",
            3.0,
            False,
            {**BENDING, "replan": "never"},
        ),
    )
}


def contestants(words: Sequence[str]) -> list[Contestant]:
    """Return the contestants that words name, all without any.

    Raises:
        InputError: a word names none.
    """
    unknown = [word for word in words if word not in CONTESTANTS]
    if unknown:
        known = f"known: {', '.join(CONTESTANTS)}"
        raise InputError("planners", [Problem(word, f"there is no such contestant; {known}") for word in unknown])
    return [CONTESTANTS[word] for word in dict.fromkeys(words or CONTESTANTS)]


def document(arena: Arena, contestant: Contestant, length: float) -> dict[str, Any]:
    """Return the mission of a contestant in an arena.

    Args:
        arena: where
        contestant: how
        length: m, of the shortest way, or of the straight line where there is none; its time bounds that of the flight
    """
    where = {"goal": list(arena.goal)} if contestant.plans else {"route": [list(arena.goal)]}
    return {
        "name": f"{arena.name}-{contestant.name}",
        "start": {"position": list(arena.start)},
        **where,
        "speed": contestant.speed,
        "seed": arena.seed,
        "world": dict(arena.world),
        "vehicle": {"kind": "quadrotor", "radius": 0.2},
        "timing": {"timeout": round(PATIENCE * length / contestant.speed + SPARE, 1)},
        **contestant.mission,
    }
