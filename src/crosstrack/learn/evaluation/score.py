"""How each contestant of an evaluation did."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import quantiles
from typing import Any

from crosstrack.campaign.avoidance.score import wilson
from crosstrack.campaign.ranking import Loss, Spread, spread

LATE = ("timed_out", "stuck")


@dataclass(frozen=True)
class Score:
    """How one contestant did in the worlds of one kind."""

    world: str
    contestant: str
    flights: int
    """how many there are, those that were lost to errors too"""
    arrived: int
    """at the goal, in time, without a collision: a success"""
    interval: tuple[float, float]
    """share of successes, 95 % confidence interval of Wilson"""
    collided: int
    left_bounds: int
    late: int
    """out of time, or stuck"""
    otherwise: int
    """flights that ended in another way, such as by losing control"""
    lost: int
    """flights of which there is only an error"""
    speed: Spread | None
    """m/s, means over time of the flights that arrived"""
    mean_speed: float | None
    """m/s, mean over them"""
    clearance: Spread | None
    """m, the least from the vehicle's centre to an obstacle of every flight"""
    length: Spread | None
    """flown length over that of the route, of the flights that arrived"""
    interventions: float | None
    """times that the safety layer stepped in, a flight; None where there is none"""
    cross_track: Spread | None
    """m, root mean square over time of the distance to a route that is followed, of every flight"""
    cross_track_90: float | None
    """m, what 90 % of these are below"""
    decision: Spread | None
    """s of the machine, median of every flight"""


def score(world: str, contestant: str, results: Sequence[Mapping[str, Any]], lost: int = 0) -> Score:
    """Return how a contestant did.

    Args:
        world: what the results are called together
        contestant: whose they are
        results: what `trial.fly` returned
        lost: flights beside them of which there is only an error
    """
    ends = [result["outcome"] for result in results]
    flown = [result["summary"] for result in results if result["summary"] is not None]
    there = [numbers for numbers in flown if numbers["arrived"]]
    known = {"arrived", "collided", "left_bounds", *LATE}
    guarded = any({"kind": "safety"} in result["document"].get("avoid", ()) for result in results)
    followed = not any("avoid" in result["document"] for result in results)
    errors = [numbers["cross_track_rms_m"] for numbers in flown] if followed else []
    speeds = [numbers["mean_speed_mps"] for numbers in there]
    steps = [numbers["safety_interventions"] for numbers in flown]
    return Score(
        world=world,
        contestant=contestant,
        flights=len(results) + lost,
        arrived=ends.count("arrived"),
        interval=wilson(ends.count("arrived"), len(results) + lost),
        collided=ends.count("collided"),
        left_bounds=ends.count("left_bounds"),
        late=sum(map(ends.count, LATE)),
        otherwise=sum(end not in known for end in ends),
        lost=lost,
        speed=spread(speeds),
        mean_speed=mean(speeds),
        clearance=spread([row["min_clearance_m"] for row in flown if row["min_clearance_m"] is not None]),
        length=spread([row["flown_length_m"] / row["path_length_m"] for row in there]),
        interventions=mean(steps) if guarded else None,
        cross_track=spread(errors),
        cross_track_90=ninth(errors),
        decision=spread([row["decision_time_s"] for row in flown]),
    )


def mean(values: Sequence[float]) -> float | None:
    """Return the mean of values, None without any."""
    return sum(values) / len(values) if values else None


def ninth(values: Sequence[float]) -> float | None:
    """Return what 90 % of values are below, None without any."""
    if len(values) < 2:
        return values[0] if values else None
    return quantiles(values, n=10, method="inclusive")[-1]


def scores(results: Sequence[Mapping[str, Any]], losses: Sequence[Loss] = ()) -> list[Score]:
    """Return the score of every contestant in every kind of worlds, as they come."""
    labels = [*(result["labels"] for result in results), *(loss.labels for loss in losses)]
    worlds = list(dict.fromkeys(one["world"] for one in labels))
    names = list(dict.fromkeys(one["contestant"] for one in labels))
    found = []
    for pair in ((world, name) for world in worlds for name in names):
        mine = [result for result in results if pair == (result["labels"]["world"], result["labels"]["contestant"])]
        lost = sum(pair == (loss.labels["world"], loss.labels["contestant"]) for loss in losses)
        if mine or lost:
            found.append(score(*pair, mine, lost))
    return found
