"""What a flight takes of the machine."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields

import numpy as np


@dataclass(frozen=True)
class Effort:
    """Time of the machine."""

    flying: float = 0.0
    """s, for the whole flight, after the first plan"""
    planning: float = 0.0
    """s, for all plans, the first included"""
    decision: float = 0.0
    """s, median from what the sensors see to the command, plans left out"""
    decision_worst: float = 0.0
    """s, 99th percentile of the same"""

    def texts(self) -> dict[str, str]:
        """Return it as a log keeps it."""
        return {name: repr(value) for name, value in asdict(self).items()}


NO_EFFORT = Effort()
"""nothing, or nothing known"""


def effort(flying: float, planning: float, decisions: Sequence[float]) -> Effort:
    """Return what was taken, given the time (s) of every decision."""
    median, worst = np.percentile(decisions, (50, 99)).tolist() if decisions else (0.0, 0.0)
    return Effort(flying, planning, median, worst)


def read(texts: dict[str, str]) -> Effort:
    """Return what a log keeps.

    Raises:
        KeyError, ValueError: it is not all there, or no numbers.
    """
    return Effort(**{field.name: float(texts[field.name]) for field in fields(Effort)})
