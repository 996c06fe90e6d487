"""Flights as tasks: a mission is flown in a worker, and its numbers and a thinned trace come back."""

import json
from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from crosstrack.campaign.task import Task, state, task
from crosstrack.flight import loop
from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import OF_THE_MACHINE
from crosstrack.flight.plan import Plan
from crosstrack.flight.summary import summary
from crosstrack.mission.load import from_document
from crosstrack.mission.mission import Mission
from crosstrack.types import Array
from crosstrack.world.files import read

SAMPLES = 400
"""of one flight that are kept, at most"""
POINTS = 1000
"""of one route that are kept, at most"""
VARIED = ("tracker", "wind", "seed")
"""fields of a mission that its course does not depend on"""
MILLIMETRE, TENTH = 3, 4
"""decimals of positions and speeds, and of errors and times"""


def flight_task(mission: Mission, labels: Mapping[str, Any]) -> Task:
    """Return the task of flying a mission.

    Args:
        mission: what to fly
        labels: what the result is filed under, such as mission, tracker, wind and seed

    Raises:
        InputError: one of its files cannot be read.
    """
    files = {name: _encoded(read(mission.files, name)) for name in mission.names}
    payload = {"document": mission.document(), "files": files, "labels": dict(labels), "sources": sources(mission)}
    return task(f"{__name__}:{fly.__name__}", payload)


def sources(mission: Mission) -> dict[str, str]:
    """Return digests of the other packages that parts of a mission come from, by name."""
    parts = [mission.vehicle, mission.planner, mission.tracker, *mission.avoid, mission.world.generate]
    packages = {type(part).__module__.partition(".")[0] for part in parts if part is not None}
    return {name: state(name) for name in sorted(packages - {"crosstrack", "__main__"})}


def fly(payload: Mapping[str, Any]) -> dict[str, Any]:
    """Fly a mission and return what is compared.

    Args:
        payload: `document` of a mission, `files` by name in base64, `labels`; and `sources`, for its key alone

    Returns:
        `labels`; `summary`, see `flight.summary`, without the times of the machine; `trace` of at most 400 samples,
        evenly chosen: `time` (s), `position` (m), `cross_track` (m), `tracking` (m, None without a trajectory),
        `speed` (m/s); `route`, at most 1000 points (m).
    """
    flight = loop.fly(plan_of(payload["document"], tuple(sorted(payload["files"].items()))))
    numbers = summary(flight)
    for name in OF_THE_MACHINE:
        del numbers[name]
    points = flight.plan.route.points
    return {
        "labels": payload["labels"],
        "summary": numbers,
        "trace": trace(flight),
        "route": rounded(points[thinned(len(points), POINTS)], MILLIMETRE),
    }


def plan_of(document: Mapping[str, Any], files: tuple[tuple[str, str], ...]) -> Plan:
    """Return what is to be flown; missions that differ in tracker, wind and seed alone share one course."""
    mission = from_document(document, {name: b64decode(content) for name, content in files})
    common = {name: value for name, value in document.items() if name not in VARIED}
    plan, tracker = _planned(json.dumps(common, sort_keys=True), files), mission.tracker
    assert tracker is not None  # it was given its default
    return replace(
        plan,
        document=mission.document(),
        tracker=tracker,
        scenario=replace(plan.scenario, wind=mission.enu.wind, seed=mission.seed),
    )


@lru_cache(maxsize=8)
def _planned(document: str, files: tuple[tuple[str, str], ...]) -> Plan:
    return from_document(json.loads(document), {name: b64decode(content) for name, content in files}).build()


@lru_cache(maxsize=8)
def _encoded(content: bytes) -> str:
    """Return the contents of a file as text; tasks of one mission share it."""
    return b64encode(content).decode()


def trace(flight: Flight) -> dict[str, Any]:
    """Return samples of a flight, evenly chosen among those whose state is finite."""
    record = flight.record
    speed = np.linalg.norm(record.velocity, axis=1)
    known = np.flatnonzero(np.isfinite(flight.cross_track) & np.isfinite(speed))
    rows = known[thinned(len(known), SAMPLES)]
    followed = flight.plan.course.trajectory is not None
    return {
        "time": rounded(record.time[rows] - record.time[0], TENTH),
        "position": rounded(record.position[rows], MILLIMETRE),
        "cross_track": rounded(flight.cross_track[rows], TENTH),
        "tracking": rounded(flight.tracking[rows], TENTH) if followed else None,
        "speed": rounded(speed[rows], MILLIMETRE),
    }


def thinned(count: int, most: int) -> Any:
    """Return indices (m,) of at most `most` of `count` rows, evenly spread, with both ends."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def rounded(values: Array, decimals: int) -> Any:
    """Return numbers as JSON has them."""
    return np.round(values, decimals).tolist()
