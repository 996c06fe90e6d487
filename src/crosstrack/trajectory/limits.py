"""How fast a trajectory may move, accelerate and jerk."""

from dataclasses import dataclass, fields
from typing import NamedTuple

from crosstrack.errors import Problem
from crosstrack.trajectory.arguments import is_number

VERTICAL = (2,)
"""the axis of the vertical limits"""


class Bound(NamedTuple):
    """One limit as geometry: the Euclidean norm of a derivative over some axes is at most a value."""

    name: str
    """the field of `MotionLimits`"""
    order: int
    """of the derivative"""
    axes: tuple[int, ...]
    """that the norm is taken over"""
    most: float
    """m/s^order"""


@dataclass(frozen=True, slots=True)
class MotionLimits:
    """Limits of a motion, each a number above zero or None for none.

    The plain ones bound the Euclidean norm over all axes, the vertical ones the third of three axes besides.
    """

    speed: float | None = None
    """m/s"""
    speed_vertical: float | None = None
    """m/s"""
    acceleration: float | None = None
    """m/s²"""
    acceleration_vertical: float | None = None
    """m/s²"""
    jerk: float | None = None
    """m/s³"""

    def bounds(self, dimensions: int) -> list[Bound]:
        """Return the limits that are given, for curves of a dimension, by order of the derivative."""
        everything = tuple(range(dimensions))
        rows = [
            ("speed", 1, everything),
            ("speed_vertical", 1, VERTICAL),
            ("acceleration", 2, everything),
            ("acceleration_vertical", 2, VERTICAL),
            ("jerk", 3, everything),
        ]
        return [
            Bound(name, order, axes, most) for name, order, axes in rows if (most := getattr(self, name)) is not None
        ]


def limit_faults(limits: object, dimensions: int) -> list[Problem]:
    """Return what is wrong with limits for curves of a dimension; some have to be given."""
    if not isinstance(limits, MotionLimits):
        return [Problem("limits", f"must be MotionLimits, found {limits!r:.60}")]
    found = []
    for field in fields(limits):
        place, value = f"limits.{field.name}", getattr(limits, field.name)
        if value is None:
            continue
        if not is_number(value) or not 0 < value < float("inf"):
            found.append(Problem(place, f"must be above 0 and finite, found {value!r}"))
        if field.name.endswith("_vertical") and dimensions != 3:
            found.append(Problem(place, f"is for three dimensions, found {dimensions}"))
    return found
