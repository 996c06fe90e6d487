"""What clients draw into the scene: kept for as long as it would be seen, and after that for the report."""

from collections import deque
from dataclasses import dataclass, replace

from crosstrack.types import Array

FOREVER = 1 << 62
"""ns, the end of what stays"""
LASTING = 1.0
"""s, that a marker without a duration is seen"""
MOST_POINTS = 500_000
"""of all markers together; beyond that the oldest are dropped"""


@dataclass(frozen=True, eq=False)
class Marker:
    """Something drawn."""

    kind: str
    """points, lines, arrows, strings or transforms"""
    points: Array
    """(n, 3) m, world NED; lines and arrows go from each even one to the next"""
    color: tuple[float, float, float, float]
    """red, green, blue, opacity, 0 to 1"""
    size: float
    """of points in pixels, thickness of lines in AirSim's units, scale of letters and axes"""
    begins: int
    """ns"""
    ends: int
    """ns"""
    texts: tuple[str, ...] = ()
    """(n,) of strings and named transforms"""
    orientations: Array | None = None
    """(n, 4) xyzw, of transforms"""


@dataclass(frozen=True)
class Trace:
    """How the way of a vehicle is drawn."""

    color: tuple[float, float, float, float]
    """red, green, blue, opacity, 0 to 1"""
    thickness: float


def weight(marker: Marker) -> int:
    """Return the points and letters of a marker."""
    return len(marker.points) + sum(map(len, marker.texts))


class Markers:
    """All that was drawn."""

    def __init__(self) -> None:
        self.drawn: deque[Marker] = deque()
        self.traces: dict[str, Trace] = {}
        """by vehicle"""
        self.points = 0
        self.dropped = 0
        """markers that were dropped, as there were too many"""

    def add(self, marker: Marker) -> None:
        """Keep a marker."""
        self.drawn.append(marker)
        self.points += weight(marker)
        while self.points > MOST_POINTS:
            self.points -= weight(self.drawn.popleft())
            self.dropped += 1

    def flush(self, now: int) -> None:
        """End all that is seen at a time (ns), strings excepted."""
        self.drawn = deque(
            replace(one, ends=now) if one.kind != "strings" and one.begins <= now < one.ends else one
            for one in self.drawn
        )

    def seen(self, now: int) -> list[Marker]:
        """Return what is seen at a time (ns)."""
        return [one for one in self.drawn if one.begins <= now < one.ends]
