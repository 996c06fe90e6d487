"""How each contestant did in each family."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from crosstrack.campaign.avoidance.contestants import CONTESTANTS
from crosstrack.campaign.avoidance.families import FAMILIES
from crosstrack.campaign.ranking import Loss, Spread, spread

SLOWEST = 3.0
"""times the time of the shortest way at cruise speed: what takes longer did not succeed"""
SURE = 1.959964
"""standard deviations within which 95 % of a normal distribution lie"""


@dataclass(frozen=True)
class Score:
    """How one contestant did over some flights."""

    family: str
    contestant: str
    flights: int
    """how many there are, those that were lost to errors too"""
    succeeded: int
    """arrived in time without a collision; where there is no way to the goal: ended by saying so"""
    interval: tuple[float, float]
    """share of successes, 95 % confidence interval of Wilson"""
    collided: int
    late: int
    """arrived, but in more than three times the time of the shortest way at cruise speed"""
    lost: int
    """flights of which there is only an error"""
    clearance: Spread | None
    """m, the least of every flight"""
    length: Spread | None
    """flown length over that of the shortest way, of the flights that arrived"""
    time: Spread | None
    """flight time over that of the shortest way at cruise speed, likewise"""
    speed: Spread | None
    """m/s, mean of every flight, likewise"""
    planning: Spread | None
    """s, all plans of a flight together"""
    replans: Spread | None
    interventions: Spread | None
    """times that the safety layer stepped in"""
    decision: Spread | None
    """s, median of every flight"""
    slowest_decision: Spread | None
    """s, 99th percentile of every flight"""


def wilson(succeeded: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a share (Wilson 1927, Eq. 4), in [0, 1].

    (p + z²/2n ± z √(p (1 - p)/n + z²/4n²)) / (1 + z²/n), with the share p = succeeded / n.
    """
    if count == 0:
        return 0.0, 1.0
    share, square = succeeded / count, SURE**2 / count
    middle = (share + square / 2) / (1 + square)
    half = math.sqrt(SURE**2 * (share * (1 - share) / count + square / (4 * count))) / (1 + square)
    # Rounded, an end at 0 or 1 may come out inside: the share lies within for certain.
    return max(0.0, min(share, middle - half)), min(1.0, max(share, middle + half))


def time_ratio(result: Mapping[str, Any]) -> float:
    """Return the flight time over that of the shortest way at cruise speed; inf where there is none."""
    if result["optimum"] is None:
        return math.inf
    cruise = CONTESTANTS[result["labels"]["contestant"]].speed
    return float(result["summary"]["flight_time_s"] * cruise / result["optimum"]["length"])


def arrived(result: Mapping[str, Any]) -> bool:
    """Return whether a flight got to its goal."""
    return bool(result["outcome"] == "arrived")


def succeeded(result: Mapping[str, Any]) -> bool:
    """Return whether a flight did what was to be done."""
    if result["optimum"] is None:
        return bool(result["outcome"] == "unreachable")
    return arrived(result) and time_ratio(result) <= SLOWEST


def score(family: str, contestant: str, results: Sequence[Mapping[str, Any]], lost: int = 0) -> Score:
    """Return how a contestant did.

    Args:
        family: what the results are called together
        contestant: whose they are
        results: what `trial.fly` returned
        lost: flights beside them of which there is only an error
    """
    flights, good = len(results) + lost, sum(map(succeeded, results))
    goals = [result for result in results if arrived(result) and result["optimum"] is not None]
    summaries = [result["summary"] for result in results if result["summary"] is not None]

    def of(name: str) -> Spread | None:
        return spread([numbers[name] for numbers in summaries if numbers[name] is not None])

    def over(value: Callable[[Mapping[str, Any]], float]) -> Spread | None:
        return spread([value(result) for result in goals])

    return Score(
        family=family,
        contestant=contestant,
        flights=flights,
        succeeded=good,
        interval=wilson(good, flights),
        collided=sum(result["outcome"] == "collided" for result in results),
        late=sum(time_ratio(result) > SLOWEST for result in goals),
        lost=lost,
        clearance=of("min_clearance_m"),
        length=over(lambda result: result["summary"]["flown_length_m"] / result["optimum"]["length"]),
        time=over(time_ratio),
        speed=over(lambda result: float(result["summary"]["mean_speed_mps"])),
        planning=of("planning_time_s"),
        replans=of("replans"),
        interventions=of("safety_interventions"),
        decision=of("decision_time_s"),
        slowest_decision=of("decision_time_p99_s"),
    )


def scores(results: Sequence[Mapping[str, Any]], losses: Sequence[Loss] = ()) -> list[Score]:
    """Return the score of every contestant in every family there is a flight of."""
    labels = [*(result["labels"] for result in results), *(loss.labels for loss in losses)]
    there = {(one["family"], one["contestant"]) for one in labels}
    pairs = [pair for pair in product(FAMILIES, CONTESTANTS) if pair in there]
    return [
        score(
            *pair,
            [result for result in results if pair == (result["labels"]["family"], result["labels"]["contestant"])],
            sum(pair == (loss.labels["family"], loss.labels["contestant"]) for loss in losses),
        )
        for pair in pairs
    ]
