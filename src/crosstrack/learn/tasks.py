"""The tasks by name."""

from dataclasses import asdict
from typing import Any

from crosstrack.errors import InputError, Problem
from crosstrack.learn.avoid import Avoid
from crosstrack.learn.follow import Follow
from crosstrack.learn.hover import Hover

TASKS: dict[str, type[Any]] = {"avoid": Avoid, "follow": Follow, "hover": Hover}


def find(name: str) -> type[Any]:
    """Return the class of a task.

    Raises:
        InputError: no such task; the message lists those there are.
    """
    if name not in TASKS:
        raise InputError("task", [Problem(name, f"there is no such task; known: {', '.join(TASKS)}")])
    return TASKS[name]


def options(task: Any) -> dict[str, Any]:
    """Return everything that a task is told, as plain values, and the sensor that a mission would give it."""
    found = asdict(task)
    sensor = getattr(task, "sensor", None)
    if sensor is not None:
        kind = "lidar" if task.observation == "rays" else "depth_camera"
        found["sensor"] = {"kind": kind, **asdict(sensor)}
    return found
