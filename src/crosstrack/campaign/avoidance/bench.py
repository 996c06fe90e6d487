"""The benchmark of obstacle avoidance: contestants in arenas from seeds."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from crosstrack.campaign.avoidance.contestants import CONTESTANTS, contestants
from crosstrack.campaign.avoidance.families import families
from crosstrack.campaign.avoidance.score import Score, score, scores, succeeded, time_ratio
from crosstrack.campaign.avoidance.trial import trial_task
from crosstrack.campaign.complete import Watch, finished
from crosstrack.campaign.ranking import Loss
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.task import Done, Task
from crosstrack.errors import InputError, Problem

LABELS = ("family", "seed", "contestant")
MOST = 10_000
"""maps of a family"""
EVERYTHING = "all"
"""what the results of all families are called together"""


@dataclass(frozen=True)
class Benchmark:
    """What came of the benchmark."""

    results: tuple[Mapping[str, Any], ...]
    """what `trial.fly` returned for each flight"""
    losses: tuple[Loss, ...] = ()
    """flights that an error ended"""

    @property
    def scores(self) -> list[Score]:
        """Every contestant in every family."""
        return scores(self.results, self.losses)

    @property
    def totals(self) -> list[Score]:
        """Every contestant over all families."""
        labels = [*(result["labels"] for result in self.results), *(loss.labels for loss in self.losses)]
        return [
            score(
                EVERYTHING,
                name,
                [result for result in self.results if result["labels"]["contestant"] == name],
                sum(loss.labels["contestant"] == name for loss in self.losses),
            )
            for name in CONTESTANTS
            if any(one["contestant"] == name for one in labels)
        ]

    @property
    def failures(self) -> list[Mapping[str, Any]]:
        """The flights that did not succeed."""
        return [result for result in self.results if not succeeded(result)]

    def document(self) -> dict[str, Any]:
        """Return everything but paths and pictures as plain values for JSON."""
        return {
            "flights": len(self.results) + len(self.losses),
            "scores": [asdict(row) for row in self.scores],
            "totals": [asdict(row) for row in self.totals],
            "failures": [{**result["labels"], "outcome": result["outcome"]} for result in self.failures],
            "lost": [asdict(loss) for loss in self.losses],
        }

    def write_csv(self, path: str | Path) -> None:
        """Write a row for each flight: labels, whether it succeeded, the optimum and every number of its summary."""
        rows = [row(result) for result in self.results]
        columns = list(dict.fromkeys([*LABELS, *(name for values in rows for name in values), "error"]))
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)
            writer.writerows({**loss.labels, "error": loss.error} for loss in self.losses)


def row(result: Mapping[str, Any]) -> dict[str, Any]:
    """Return a flight as a row of a table."""
    best, numbers = result["optimum"], result["summary"]
    return {
        **result["labels"],
        "succeeded": succeeded(result),
        "outcome": result["outcome"],
        "optimum_m": best["length"] if best else None,
        "optimum_time_ratio": time_ratio(result) if best and numbers else None,
        **(numbers or {}),
    }


def tasks(words: Sequence[str], names: Sequence[str], maps: int, seed: int) -> list[Task]:
    """Return the flights of a benchmark: every contestant in so many arenas of every family.

    Raises:
        InputError: no such family or contestant, or a number that cannot be.
    """
    problems: list[Problem] = []
    if not 1 <= maps <= MOST:
        problems.append(Problem("maps", f"must be from 1 to {MOST}, found {maps}"))
    if not 0 <= seed < 2**31:
        problems.append(Problem("seed", f"must be from 0 to {2**31 - 1}, found {seed}"))
    for known, said in ((families, words), (contestants, names)):
        try:
            known(said)
        except InputError as error:
            problems += [Problem(f"{error.source}: {problem.place}", problem.message) for problem in error.problems]
    if problems:
        raise InputError("bench avoid", problems)
    return [
        trial_task(family, seed + k, one.name)
        for family in families(words)
        for k in range(maps)
        for one in contestants(names)
    ]


def judged(asked: Sequence[Task], done: Sequence[Done]) -> Benchmark:
    """Return the benchmark that the results of flights make, in their order."""
    lost = [Loss(task.payload, one.error) for task, one in zip(asked, done, strict=True) if one.error]
    return Benchmark(tuple(one.value for one in done if one.value is not None), tuple(lost))


def bench(
    families: Sequence[str] = (),
    contestants: Sequence[str] = (),
    *,
    maps: int = 1,
    seed: int = 1,
    runner: Runner | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
) -> Benchmark:
    """Fly contestants in arenas from seeds, and return how each of them did.

    Args:
        families: see `families.FAMILIES`; all by default
        contestants: see `contestants.CONTESTANTS`; all by default
        maps: how many of each family, from the seed on
        seed: of the first map
        runner: what flies; by default worker processes, one for every core
        store: a file to keep results in: called again after an interruption, what is there is not flown again
        watch: is shown every result as it comes

    Raises:
        InputError: everything that is wrong.
        KeyboardInterrupt: Ctrl-C; what finished is in the store.
    """
    asked = tasks(families, contestants, maps, seed)
    return judged(asked, finished(asked, runner, store, watch))
