"""What the generators share."""

from collections.abc import Iterable
from typing import Annotated

from annotated_types import Ge, Lt

from crosstrack.types import Finite, Positive
from crosstrack.world.shapes import Box

Seed = Annotated[int, Ge(0), Lt(2**63)]
Corner = tuple[Finite, Finite]
Size = tuple[Positive, Positive, Positive]
MOST_SHAPES = 20_000


def check(problems: Iterable[str]) -> None:
    """Raise ValueError with all problems that are not empty."""
    found = [problem for problem in problems if problem]
    if found:
        raise ValueError("; ".join(found))


def wall(start: Corner, end: Corner, thickness: float, lo: float, hi: float) -> Box:
    """Return the box around a line along an axis, half a thickness beyond it on every side."""
    half = thickness / 2
    (x0, x1), (y0, y1) = sorted((start[0], end[0])), sorted((start[1], end[1]))
    return Box((x0 - half, y0 - half, lo), (x1 + half, y1 + half, hi))
