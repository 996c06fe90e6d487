"""Evaluate a policy: missions in worlds that it was never trained in, beside other ways to fly them."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from crosstrack.campaign.avoidance.bench import MOST
from crosstrack.campaign.complete import Watch, finished
from crosstrack.campaign.ranking import Loss
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.task import Done, Task
from crosstrack.errors import InputError, Problem
from crosstrack.learn.arenas import HELD_OUT, TESTED
from crosstrack.learn.evaluation.missions import BESIDE, FOREST, POLICY, ROUTE, WORLDS, Where
from crosstrack.learn.evaluation.score import Score, scores
from crosstrack.learn.evaluation.trial import digest, trial_task
from crosstrack.policy.card import Card
from crosstrack.policy.file import ENDING, load
from crosstrack.policy.flying import Pilot
from crosstrack.policy.policy import Policy

USUAL_DENSITY = 0.1
"""trees per m²"""
DENSEST = 1.0
"""trees per m²"""
ALONE = "none"
"""said instead of contestants, where the policy flies alone"""
LABELS = ("world", "seed", "contestant")


@dataclass(frozen=True)
class Setup:
    """What an evaluation flies."""

    name: str
    """of the policy: its file, or its own where it ships"""
    policy: Policy
    worlds: tuple[Where, ...]
    seeds: range
    contestants: tuple[str, ...]

    @property
    def card(self) -> Card:
        """What the policy is."""
        return self.policy.card

    def tasks(self) -> list[Task]:
        """Return the flights: every contestant in the same worlds."""
        file = str(Path(self.name).resolve()) if self.name.lower().endswith(ENDING) else self.name
        known = digest(self.policy)
        return [
            trial_task(file, known, where, seed, contestant)
            for where in self.worlds
            for seed in self.seeds
            for contestant in self.contestants
        ]

    def judged(self, asked: Sequence[Task], done: Sequence[Done]) -> "Evaluation":
        """Return the evaluation that the results of flights make, in their order."""
        lost = [Loss(task.payload["labels"], one.error) for task, one in zip(asked, done, strict=True) if one.error]
        return Evaluation(self, tuple(one.value for one in done if one.value is not None), tuple(lost))


@dataclass(frozen=True)
class Evaluation:
    """What came of an evaluation."""

    setup: Setup
    results: tuple[Mapping[str, Any], ...]
    """what `trial.fly` returned for each flight"""
    losses: tuple[Loss, ...] = ()
    """flights that an error ended"""

    @property
    def scores(self) -> list[Score]:
        """Every contestant in the worlds of every kind."""
        return scores(self.results, self.losses)

    def document(self) -> dict[str, Any]:
        """Return everything but paths as plain values for JSON."""
        setup, card = self.setup, self.setup.card
        failures = [result for result in self.results if result["outcome"] != "arrived"]
        return {
            "policy": setup.name,
            "task": card.task,
            "algorithm": card.algorithm,
            "network": card.network,
            "training": card.training,
            "maps": len(setup.seeds),
            "seed": setup.seeds.start,
            "scores": [asdict(row) for row in self.scores],
            "failures": [{**result["labels"], "outcome": result["outcome"]} for result in failures],
            "lost": [asdict(loss) for loss in self.losses],
        }

    def write_csv(self, path: str | Path) -> None:
        """Write a row for each flight: labels, outcome and every number of its summary."""
        rows = [
            {**result["labels"], "outcome": result["outcome"], **(result["summary"] or {})} for result in self.results
        ]
        columns = list(dict.fromkeys([*LABELS, "outcome", *(name for values in rows for name in values), "error"]))
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)
            writer.writerows({**loss.labels, "error": loss.error} for loss in self.losses)


def setup(
    policy: str,
    *,
    maps: int = 100,
    seed: int = TESTED,
    densities: Sequence[float] | None = None,
    families: Sequence[str] | None = None,
    beside: Sequence[str] | None = None,
) -> Setup:
    """Return what an evaluation flies, see `evaluate`.

    Raises:
        InputError: everything that is wrong.
    """
    problems = list(numbers(maps, seed))
    try:
        found = readable(policy)
    except InputError as error:
        found = None
        problems += [
            Problem(f"{error.source}: {one.place}" if one.place else policy, one.message) for one in error.problems
        ]
    task = found.card.task if found else "avoid"
    problems += [*places(task, densities, families), *unknown(task if found else None, beside)]
    if problems or found is None:
        raise InputError("evaluate", problems)
    rivals = BESIDE[task] if beside is None else tuple(dict.fromkeys(word for word in beside if word != ALONE))
    return Setup(policy, found, worlds(task, densities, families), range(seed, seed + maps), (POLICY, *rivals))


def readable(name: str) -> Policy:
    """Return a policy that flies missions.

    Raises:
        InputError: there is none, or it does not.
    """
    policy = load(name)
    task = policy.card.task
    if task not in BESIDE:
        message = f"is a policy to {task}, and missions are flown by policies to {' or '.join(BESIDE)}"
        raise InputError(name, [Problem("", message)])
    Pilot(name, policy, task)
    return policy


def numbers(maps: int, seed: int) -> list[Problem]:
    """Return what is wrong with how many worlds there are, and which."""
    found, last = [], HELD_OUT - min(max(maps, 1), MOST)
    if not 1 <= maps <= MOST:
        found.append(Problem("maps", f"must be from 1 to {MOST}, found {maps}"))
    if not 0 <= seed <= last:
        message = f"must be from 0 to {last}: worlds of later seeds are trained in; found {seed}"
        found.append(Problem("seed", message))
    return found


def places(task: str, densities: Sequence[float] | None, families: Sequence[str] | None) -> list[Problem]:
    """Return what is wrong with the kinds of worlds."""
    if task == "follow":
        given = {"density": densities, "family": families}
        message = "is of worlds with obstacles; a policy that follows is flown along routes in the open"
        return [Problem(word, message) for word, value in given.items() if value is not None]
    known = f"known: {', '.join(WORLDS)}"
    found = [
        Problem("family", f"there is no such family, {word}; {known}") for word in families or () if word not in WORLDS
    ]
    if densities is not None and families is not None and FOREST not in families:
        found.append(Problem("density", f"is of the family {FOREST}, which is not among {', '.join(families)}"))
    found += [
        Problem("density", f"must be from 0 to {DENSEST:g} trees per m², found {density:g}")
        for density in densities or ()
        if not (math.isfinite(density) and 0 <= density <= DENSEST)
    ]
    return found


def unknown(task: str | None, beside: Sequence[str] | None) -> list[Problem]:
    """Return what is wrong with the contestants; any will do where the task is not known."""
    if task is None:
        known: tuple[str, ...] = tuple(name for names in BESIDE.values() for name in names)
    else:
        known = BESIDE[task]
    message = f"there is no such contestant; known: {', '.join(known)}; {ALONE} for the policy alone"
    return [Problem(f"beside: {word}", message) for word in beside or () if word not in {*known, ALONE}]


def worlds(task: str, densities: Sequence[float] | None, families: Sequence[str] | None) -> tuple[Where, ...]:
    """Return the kinds of worlds: forests of all densities, then the other families."""
    if task == "follow":
        return (Where(ROUTE),)
    chosen = list(dict.fromkeys(families if families is not None else (FOREST,)))
    dense = list(dict.fromkeys(densities if densities is not None else (USUAL_DENSITY,)))
    forests = [Where(FOREST, float(density)) for density in dense] if FOREST in chosen else []
    return (*forests, *(Where(family) for family in chosen if family != FOREST))


def evaluate(
    policy: str,
    *,
    maps: int = 100,
    seed: int = TESTED,
    densities: Sequence[float] | None = None,
    families: Sequence[str] | None = None,
    beside: Sequence[str] | None = None,
    runner: Runner | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
) -> Evaluation:
    """Fly missions with a policy and with others beside it, and return how each of them did.

    Args:
        policy: a file, or the name of one that ships
        maps: how many worlds of each kind, from the seed on
        seed: of the first
        densities: trees per m² of forests
        families: see `missions.WORLDS`; forests by default
        beside: see `missions.BESIDE`; all that fit the task by default
        runner: what flies; by default worker processes, one for every core
        store: a file to keep results in: called again after an interruption, what is there is not flown again
        watch: is shown every result as it comes

    Raises:
        InputError: everything that is wrong.
        KeyboardInterrupt: Ctrl-C; what finished is in the store.
    """
    said = setup(policy, maps=maps, seed=seed, densities=densities, families=families, beside=beside)
    asked = said.tasks()
    return said.judged(asked, finished(asked, runner, store, watch))
