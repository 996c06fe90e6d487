"""What is tuned, and how: checked before anything flies."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

from crosstrack.campaign.flights import flight_task
from crosstrack.campaign.grid import in_wind, with_tracker
from crosstrack.campaign.task import Task
from crosstrack.campaign.tune_axes import axes_of
from crosstrack.campaign.tune_cost import Term, parse_cost
from crosstrack.campaign.tune_search import Axis, Values, population
from crosstrack.campaign.words import OWN, distinct
from crosstrack.errors import InputError, Problem
from crosstrack.mission.mission import Mission
from crosstrack.mission.parts import kind_of
from crosstrack.types import Noise

BUDGET = 300
"""flights of a tuning, unless it is told how many"""
SEEDS = 3
"""of a tuning, unless it is told how many; one where nothing is random"""
MOST = 100_000
"""flights of one tuning"""
MOST_SEED = 2**63 - 1
FOLLOWING, TRACKING = "cross_track_rms_captured_m", "tracking_rms_m"
Made = TypeVar("Made")


@dataclass(frozen=True)
class Tuning:
    """What to tune, and how."""

    mission: Mission
    """with the tracker whose parameters are tuned"""
    axes: tuple[Axis, ...]
    """the parameters"""
    terms: tuple[Term, ...]
    """of the cost"""
    winds: tuple[str, ...]
    """words for what the mission is flown in"""
    seeds: int
    """flown in every wind, from the mission's on; as many after them are held out"""
    budget: int
    """flights at most, those of held-out seeds included"""

    @property
    def flights(self) -> int:
        """Of one trial."""
        return self.seeds * len(self.winds)

    @property
    def generations(self) -> int:
        """Of the search: what the budget leaves besides the present values, and both on held-out seeds."""
        return (self.budget - 3 * self.flights) // (population(self.axes) * self.flights)

    def tasks(self, values: Values, first: int = 0) -> list[Task]:
        """Return the flights of a candidate, from the seed on that is `first` after the mission's.

        There are none where the tracker refuses the values, which may contradict one another.
        """
        tracker: Any = self.mission.tracker
        try:
            mission = replace(self.mission, tracker=replace(tracker, **values))
        except (ValueError, InputError):
            return []
        seeds = range(self.mission.seed + first, self.mission.seed + first + self.seeds)
        return [
            flight_task(replace(in_wind(mission, wind), seed=seed), self.labels(values, wind, seed))
            for wind in self.winds
            for seed in seeds
        ]

    def labels(self, values: Values, wind: str, seed: int) -> Mapping[str, Any]:
        """Return what a flight is filed under."""
        present = all(values[axis.name] == axis.value for axis in self.axes)
        name = f"{kind_of('tracker', self.mission.tracker)} {'before' if present else 'after'}"
        return {"mission": self.mission.name, "tracker": name, "wind": wind, "seed": seed}


def tuning(
    mission: Mission,
    tracker: str | None = None,
    *,
    parameters: Sequence[str] = (),
    cost: str | None = None,
    winds: Sequence[str] = (OWN,),
    seeds: int | None = None,
    budget: int = BUDGET,
) -> Tuning:
    """Return what to tune, checked.

    Args:
        mission: what is flown
        tracker: the kind to tune, by default the mission's; another begins with its own defaults
        parameters: `NAME` or `NAME=LOW:HIGH`; without any, all that are positive. A range left out is from a fifth to
            five times the present value
        cost: `[NUMBER*]METRIC [+ ...]`; by default the error that the tracker is made to keep small
        winds: `calm`, `E,N,U` or `E,N,U,GUSTS` (m/s), or `mission` for the mission's own
        seeds: how many, from the mission's on
        budget: flights at most

    Raises:
        InputError: everything that is wrong with these.
    """
    problems: list[Problem] = []
    same = tracker is None or tracker == kind_of("tracker", mission.tracker)
    changed = mission if same else attempt(lambda: with_tracker(mission, str(tracker)), "--tracker", problems)
    words = tuple(distinct(winds))
    for word in words:
        attempt(partial(in_wind, mission, word), "--wind", problems)
    axes = attempt(lambda: axes_of(changed.tracker, parameters), "--parameter", problems) if changed else None
    terms = attempt(lambda: terms_for(changed or mission, cost), "--cost", problems)
    if seeds is None:
        random = not problems and any(is_random(in_wind(mission, word)) for word in words)
        seeds = SEEDS if random else 1
    problems += sizes(mission.seed, seeds, len(words), budget, axes or ())
    if problems or changed is None or axes is None or terms is None:
        raise InputError("tune", problems)
    changed.build()
    return Tuning(changed, tuple(axes), terms, words, seeds, budget)


def attempt(make: Callable[[], Made], flag: str, problems: list[Problem]) -> Made | None:
    """Return what is made; None where the input is wrong, with its problems added to the others under the flag."""
    try:
        return make()
    except InputError as error:
        problems += [replace(problem, place=f"{flag} {problem.place}".strip()) for problem in error.problems]
        return None


def terms_for(mission: Mission, text: str | None) -> tuple[Term, ...]:
    """Return the terms of the cost: by default the error that the tracker is made to keep small."""
    tracker: Any = mission.tracker
    terms = parse_cost(text if text is not None else TRACKING if "trajectory" in tracker.needs else FOLLOWING)
    if mission.planner is None and any(term.metric.startswith("tracking_") for term in terms):
        raise InputError("--cost", [Problem("", "the mission has no planner, so there is no trajectory to track")])
    return terms


def is_random(mission: Mission) -> bool:
    """Return whether anything in a flight depends on the seed."""
    return mission.wind.gusts != "none" or replace(mission.noise, delay=0.0) != Noise()


def sizes(first: int, seeds: int, winds: int, budget: int, axes: Sequence[Axis]) -> list[Problem]:
    """Return what is wrong with the numbers of a tuning."""
    if not 1 <= seeds <= MOST or first + 2 * seeds - 1 > MOST_SEED:
        message = (
            f"must be from 1 to {MOST}, and the last held-out seed at most {MOST_SEED}; found {seeds} from {first}"
        )
        return [Problem("--seeds", message)]
    trial, candidates = seeds * winds, population(axes) if axes else 1
    least = (3 + candidates) * trial
    if least <= budget <= MOST:
        return []
    needed = f"{trial} for the present values, {candidates * trial} for a generation, {2 * trial} on held-out seeds"
    message = f"must be from {least} ({needed}) to {MOST}, found {budget}"
    return [Problem("--budget", message)]
