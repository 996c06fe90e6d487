"""One flight of the benchmark, as a task: an arena, a contestant, and what came of it."""

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, cast

import numpy as np

from crosstrack.campaign.avoidance.contestants import CONTESTANTS, document
from crosstrack.campaign.avoidance.families import FAMILIES, Arena
from crosstrack.campaign.avoidance.optimum import Optimum, optimum
from crosstrack.campaign.flights import MILLIMETRE, TENTH, rounded, thinned
from crosstrack.campaign.task import Task, task
from crosstrack.errors import InputError, Unreachable
from crosstrack.flight import loop
from crosstrack.flight.flight import Flight
from crosstrack.flight.summary import summary
from crosstrack.mission.load import from_document
from crosstrack.mission.parts import adapter
from crosstrack.mission.schema import World as WorldFile
from crosstrack.types import Outcome
from crosstrack.world.world import World

CLEARANCE = 0.25
"""m, that the shortest way keeps"""
LONG = 20.0
"""m, for a flight that is not flown"""
REFUSED: dict[str, Any] = {"outcome": Outcome.UNREACHABLE.name.lower(), "summary": None, "trace": None, "courses": []}
"""what comes of a mission that is not flown, since there is no way"""
SAMPLES, POINTS = 400, 200
"""of one flight and of one course that are kept, at most"""


def trial_task(family: str, seed: int, contestant: str) -> Task:
    """Return the task of one flight."""
    return task(f"{__name__}:{fly.__name__}", {"family": family, "seed": seed, "contestant": contestant})


def fly(payload: Mapping[str, Any]) -> dict[str, Any]:
    """Fly one contestant in one arena.

    Args:
        payload: `family`, `seed`, `contestant`

    Returns:
        `labels`, the payload; `document`, the mission; `optimum`: `length` (m) and `points` (m) of the shortest way,
        None where there is none; `summary` of the flight, None where it did not begin; `outcome`, its key; `trace`:
        `time` (s), `position` (m), `steered` (whether an avoider changed the command); `courses`, the first and every
        later one (m).
    """
    family, seed, contestant = payload["family"], payload["seed"], CONTESTANTS[payload["contestant"]]
    arena = FAMILIES[family](family, seed)
    best = shortest(arena)
    straight = float(np.linalg.norm(np.subtract(arena.goal, arena.start)))
    written = document(arena, contestant, best.length if best else straight)
    known = {
        "labels": dict(payload),
        "document": written,
        "optimum": None if best is None else {"length": best.length, "points": rounded(best.points, MILLIMETRE)},
    }
    warm(contestant.name)
    try:
        plan = from_document(written).build()
    except InputError:
        if best is not None:
            raise
        return known | REFUSED  # the goal is inside an obstacle of a known map: told before anything is planned
    except Unreachable:
        return known | REFUSED
    loop.warm_up(plan)
    return known | flown(loop.fly(plan))


@cache
def warm(contestant: str) -> None:
    """Compile what a contestant needs to plan and to fly, so that its first flight is timed like the others."""
    plan = from_document(document(FAMILIES["trap"]("trap", 0), CONTESTANTS[contestant], LONG)).build()
    loop.warm_up(plan)


def shortest(arena: Arena) -> Optimum | None:
    """Return the shortest way through an arena; None where there is none."""
    return optimum(built(arena.world), np.array(arena.start), np.array(arena.goal), CLEARANCE)


def built(world: Mapping[str, Any]) -> World:
    """Return the world that a mission says; it names no files."""
    said = adapter(WorldFile).validate_json(json.dumps(world))
    return cast(World, said.build({}))


def flown(flight: Flight) -> dict[str, Any]:
    """Return what is kept of a flight."""
    record, first = flight.record, flight.plan.course.path
    known = np.flatnonzero(np.isfinite(record.position).all(axis=1))
    rows = known[thinned(len(known), SAMPLES)]
    courses = [first(np.linspace(0.0, first.length, POINTS)), *(replan.points for replan in flight.replans)]
    return {
        "outcome": flight.outcome.name.lower(),
        "summary": summary(flight),
        "trace": {
            "time": rounded(record.time[rows] - record.time[0], TENTH),
            "position": rounded(record.position[rows], MILLIMETRE),
            "steered": (record.interventions[rows] > 0).tolist(),
        },
        "courses": [rounded(course[thinned(len(course), POINTS)], MILLIMETRE) for course in courses],
    }
