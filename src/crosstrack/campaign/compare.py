"""Trackers compared: missions flown with each of them, in several winds and from several seeds."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from crosstrack.campaign.complete import Watch, finished
from crosstrack.campaign.grid import fitting, grid
from crosstrack.campaign.ranking import Loss, Row, ranking
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.task import Done, Task
from crosstrack.campaign.words import OWN
from crosstrack.mission.mission import Mission

LABELS = ("mission", "tracker", "wind", "seed")


@dataclass(frozen=True)
class Comparison:
    """Flights of the same missions with several trackers."""

    results: tuple[Mapping[str, Any], ...]
    """what `campaign.flights.fly` returned for each: labels, summary, trace, route"""
    losses: tuple[Loss, ...] = ()
    """flights that an error in the program ended"""

    @property
    def missions(self) -> list[str]:
        """Return the names of the missions."""
        labels = [*(result["labels"] for result in self.results), *(loss.labels for loss in self.losses)]
        return list(dict.fromkeys(str(one["mission"]) for one in labels))

    def ranking(self, mission: str | None = None) -> list[Row]:
        """Return a row for each tracker over one mission, or all of them, the best first; see `campaign.ranking`."""
        results = [result for result in self.results if mission in {None, result["labels"]["mission"]}]
        return ranking(results, [loss for loss in self.losses if mission in {None, loss.labels["mission"]}])

    def document(self) -> dict[str, Any]:
        """Return rankings and losses as plain values for JSON; null where an error is infinite."""
        return {
            "flights": len(self.results) + len(self.losses),
            "ranking": [_finite(asdict(row)) for row in self.ranking()],
            "missions": {name: [_finite(asdict(row)) for row in self.ranking(name)] for name in self.missions},
            "lost": [asdict(loss) for loss in self.losses],
        }

    def write_csv(self, path: str | Path) -> None:
        """Write a row for each flight: its labels, every number of its summary, and the error of one that was lost."""
        rows = [{**result["labels"], **result["summary"]} for result in self.results]
        columns = list(dict.fromkeys([*LABELS, *(name for row in rows for name in row), "error"]))
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            writer.writerows(rows)
            writer.writerows({**loss.labels, "error": loss.error} for loss in self.losses)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(inner) for name, inner in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def compared(tasks: Sequence[Task], done: Sequence[Done]) -> Comparison:
    """Return the comparison that the results of flights make, in their order."""
    lost = [Loss(task.payload["labels"], one.error) for task, one in zip(tasks, done, strict=True) if one.error]
    return Comparison(tuple(one.value for one in done if one.value is not None), tuple(lost))


def compare(
    missions: Sequence[Mission],
    trackers: Sequence[str] = (),
    *,
    winds: Sequence[str] = (OWN,),
    seeds: int = 1,
    runner: Runner | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
) -> Comparison:
    """Fly missions with several trackers side by side, and return how each of them did.

    Args:
        missions: each of a name of its own
        trackers: `NAME` with its defaults, `NAME:FIELD=VALUE,...`, or `mission` for the mission's own; by default the
            mission's own and all registered that can fly every mission
        winds: `calm`, `E,N,U` or `E,N,U,GUSTS` (m/s), or `mission` for the mission's own
        seeds: how many, from that of the mission on
        runner: what flies; by default worker processes, one for every core. Workers know the parts of this package and
            of installed ones, not those that a script registers
        store: a file to keep results in: called again after an interruption, what is there is not flown again
        watch: is shown every result as it comes

    Raises:
        InputError: everything that is wrong, with mission and tracker.
        KeyboardInterrupt: Ctrl-C; what finished is in the store.
    """
    tasks = grid(missions, trackers or fitting(missions), winds, seeds)
    return compared(tasks, finished(tasks, runner, store, watch))
