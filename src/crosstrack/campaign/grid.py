"""The grid of a comparison: missions by trackers by winds by seeds."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

from crosstrack import registry
from crosstrack.campaign.flights import flight_task
from crosstrack.campaign.task import Task
from crosstrack.campaign.words import OWN, distinct, tracker_document, wind_of
from crosstrack.errors import Infeasible, InputError, Problem
from crosstrack.mission.load import from_document
from crosstrack.mission.mission import Mission
from crosstrack.mission.parts import kind_of

MOST = 100_000
"""flights of one comparison"""
LAST_SEED = 2**63 - 1


def grid(missions: Sequence[Mission], trackers: Sequence[str], winds: Sequence[str], seeds: int = 1) -> list[Task]:
    """Return the flights of every mission with every tracker in every wind from every seed.

    Every mission is planned, and checked with every tracker, before anything flies.

    Args:
        missions: at least one, each of a name of its own
        trackers: `NAME` with its defaults, `NAME:FIELD=VALUE,...`, or `mission` for the mission's own
        winds: `calm`, `E,N,U` or `E,N,U,GUSTS` (m/s), or `mission` for the mission's own
        seeds: how many, from that of the mission on

    Raises:
        InputError: everything that is wrong, with mission and tracker.
    """
    trackers, winds = distinct(trackers), distinct(winds)
    problems = [*sizes(missions, len(trackers) * len(winds), seeds), *badly_written(trackers, winds)]
    equipped: dict[tuple[int, str], Mission] = {}
    if not problems:
        problems += [problem for mission in missions for problem in unplannable(mission)]
        for (number, mission), word in product(enumerate(missions), trackers):
            try:
                equipped[number, word] = with_tracker(mission, word)
            except InputError as error:
                problems += [Problem(f"{mission.name} with {word}", str(problem)) for problem in error.problems]
    if problems:
        raise InputError("compare", problems)
    return [
        flight_task(flown, {"mission": flown.name, "tracker": word, "wind": wind, "seed": flown.seed})
        for (_, word), mission in equipped.items()
        for wind in winds
        for flown in from_seeds(in_wind(mission, wind), seeds)
    ]


def with_tracker(mission: Mission, word: str) -> Mission:
    """Return a mission with the tracker that a word says.

    Raises:
        InputError: there is none such, or it cannot fly the mission.
    """
    tracker = tracker_document(word)
    return from_document(mission.document() | {"tracker": tracker}, mission.files) if tracker else mission


def in_wind(mission: Mission, word: str) -> Mission:
    """Return a mission in the wind that a word says.

    Raises:
        InputError: it says none.
    """
    return replace(mission, wind=wind_of(word, mission.frame) or mission.wind)


def from_seeds(mission: Mission, seeds: int) -> Iterator[Mission]:
    """Yield a mission from so many seeds, its own first."""
    return (replace(mission, seed=mission.seed + k) for k in range(seeds))


def fitting(missions: Sequence[Mission]) -> list[str]:
    """Return the trackers to compare by default: all registered ones that can fly every mission, and the missions' own.

    The missions' own are left out where each is among the others as it is.
    """
    known = [word for word in registry.names("tracker") if all(_fits(mission, word) for mission in missions)]
    kinds = [kind_of("tracker", mission.tracker) for mission in missions]
    covered = all(
        kind in known and mission.tracker == registry.find("tracker", kind)()
        for mission, kind in zip(missions, kinds, strict=True)
    )
    return known if covered else [OWN, *known]


def _fits(mission: Mission, word: str) -> bool:
    try:
        with_tracker(mission, word)
    except InputError:
        return False
    return True


def sizes(missions: Sequence[Mission], variants: int, seeds: int) -> Iterator[Problem]:
    """Yield what is wrong with how many there are of everything."""
    if not missions:
        yield Problem("missions", "at least one is needed")
    if not variants:
        yield Problem("trackers", "at least one is needed, and at least one wind")
    if seeds < 1:
        yield Problem("seeds", f"must be at least 1, found {seeds}")
    if (flights := len(missions) * variants * seeds) > MOST:
        yield Problem("", f"these are {flights} flights; allowed: at most {MOST}")
    for mission in missions:
        if mission.seed + seeds - 1 > LAST_SEED:
            yield Problem(mission.name, f"its seed, {mission.seed}, and {seeds} more exceed {LAST_SEED}")
    for name, count in Counter(mission.name for mission in missions).items():
        if count > 1:
            yield Problem(name, f"is the name of {count} missions: give each its own `name`")


def badly_written(trackers: Sequence[str], winds: Sequence[str]) -> Iterator[Problem]:
    """Yield what is wrong with words, whatever the mission."""
    for word in trackers:
        try:
            tracker_document(word)
        except InputError as error:
            yield from error.problems
    for word in winds:
        try:
            wind_of(word, "enu")
        except InputError as error:
            yield from error.problems


def unplannable(mission: Mission) -> list[Problem]:
    """Return why a mission cannot be planned."""
    try:
        mission.build()
    except (InputError, Infeasible) as error:
        return [Problem(mission.name, str(problem)) for problem in error.problems]
    return []
