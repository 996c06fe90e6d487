"""What a tuning minimises: a weighted sum of metrics, over flights that arrive."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from statistics import fmean
from typing import Any

from crosstrack.errors import InputError, Problem
from crosstrack.flight.metrics import OF_THE_MACHINE, Metrics
from crosstrack.mission.parts import suggest

TERM = re.compile(r"\s*(?:([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*\*)?\s*([A-Za-z]\w*)\s*")
"""a number and a star, or neither, and a name"""


@dataclass(frozen=True)
class Term:
    """One metric of a cost."""

    weight: float
    """per unit of the metric"""
    metric: str


@dataclass(frozen=True, order=True)
class Cost:
    """What some flights cost; the fields are compared in turn, so that any failure outweighs every error."""

    missed: int
    """flights that did not arrive, or lack a metric of the cost since they never captured the route"""
    miss: float
    """m, mean over these of the distance to the last waypoint plus the RMS cross-track error"""
    mean: float
    """mean over the others of the weighted sum; inf without any"""

    def __str__(self) -> str:
        return f"{self.mean:.5g}" + (f" and {self.missed} missed" if self.missed else "")


NEVER = 1e9
"""m, the miss of a flight of which nothing is known"""


def parse_cost(text: str) -> tuple[Term, ...]:
    """Return the terms of a cost such as `tracking_rms_m + 0.1*rms_jerk_mps3`.

    Raises:
        InputError: everything that is wrong with it.
    """
    terms, problems, at = [], [], 0
    while True:
        match = TERM.match(text, at)
        if match is None:
            rest = text[at:].strip()
            problems.append(Problem("", f"must be [NUMBER*]METRIC [+ ...], found {repr(rest) if rest else 'nothing'}"))
            break
        weight, metric = float(match[1] or 1), match[2]
        terms.append(Term(weight, metric))
        problems += [Problem("", trouble) for trouble in troubles(weight, metric)]
        at = match.end()
        if at == len(text):
            break
        if text[at] != "+":
            problems.append(Problem("", f"must have a + between its terms, found {text[at:].strip()!r}"))
            break
        at += 1
    if problems:
        raise InputError("--cost", problems)
    return tuple(terms)


def troubles(weight: float, metric: str) -> list[str]:
    """Return what is wrong with a term."""
    known = [field.name for field in fields(Metrics) if field.name not in OF_THE_MACHINE]
    found = [] if metric in known else [f"there is no metric {metric!r}; {suggest(metric, known)}"]
    return found + ([] if 0 < abs(weight) < 1e9 else [f"the weight of {metric} must be between 0 and 1e9 in size"])


def cost_of(summaries: Sequence[Mapping[str, Any] | None], terms: Sequence[Term]) -> Cost:
    """Return the cost of flights by their summaries, at least one; None stands for one that broke."""
    sums = [weighted(summary, terms) for summary in summaries]
    misses = [miss(summary) for summary, total in zip(summaries, sums, strict=True) if total is None]
    met = [total for total in sums if total is not None]
    return Cost(len(misses), fmean(misses) if misses else 0.0, fmean(met) if met else float("inf"))


def weighted(summary: Mapping[str, Any] | None, terms: Sequence[Term]) -> float | None:
    """Return the weighted sum of the metrics of a flight; None unless it arrived and has them all."""
    if summary is None or not summary["arrived"] or any(summary[term.metric] is None for term in terms):
        return None
    return float(sum(term.weight * summary[term.metric] for term in terms))


def miss(summary: Mapping[str, Any] | None) -> float:
    """Return how far (m) a flight was from what it should have been: the search goes down this slope."""
    return NEVER if summary is None else float(summary["final_error_m"] + summary["cross_track_rms_m"])
