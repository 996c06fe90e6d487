"""What the verbs that fly many missions share: results that are kept, and what is said of them."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Self

from crosstrack.campaign.complete import complete, kept
from crosstrack.campaign.ranking import Loss
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.store import Store
from crosstrack.campaign.task import Done, Task
from crosstrack.cli import codes
from crosstrack.cli.tally import Tally
from crosstrack.cli.verbs import named
from crosstrack.cli.watch import say

RESULTS, TABLE = "results.jsonl", "results.csv"


@contextmanager
def flown(heading: str, tasks: Sequence[Task], runner: Runner, folder: Path) -> Iterator[list[Done]]:
    """Fly the tasks of which the folder has no result, and lend what came of all; the folder is locked meanwhile."""
    with named(folder), Store(folder / RESULTS) as store:
        before = kept(tasks, store)
        try:
            with runner as workers, Count(heading, len(tasks), before) as count:
                done = complete(tasks, workers, store, count)
        except KeyboardInterrupt:
            say(
                f"{kept(tasks, store)} of {len(tasks)} flights are kept in {folder}; the same command flies the others."
            )
            raise
        yield done


def told(losses: Sequence[Loss]) -> int:
    """Say which flights were lost, and return the exit code."""
    for loss in losses:
        say(f"lost: {', '.join(f'{name} {value}' for name, value in loss.labels.items())}: {loss.error}")
    return codes.FLIGHTS_LOST if losses else codes.DONE


class Count(Tally):
    """Show how many flights are done, and how many of them were lost."""

    def __init__(self, heading: str, total: int, before: int) -> None:
        super().__init__(total, before)
        self.heading, self.done, self.lost = heading, before, 0

    def __enter__(self) -> Self:
        """Say what is to be done."""
        before = f", {self.done} of them kept from before" if self.done else ""
        longest = " The first ones take longest." if self.done < self.total else ""
        say(f"{self.heading}: {self.total}{before}.{longest}")
        return super().__enter__()

    def __call__(self, done: Done) -> None:
        """Count a flight, and show it when it is due."""
        self.done += 1
        self.lost += done.error is not None
        lost = f", {self.lost} lost" if self.lost else ""
        self.show(self.done, f"flights{lost}", f"{self.done} of {self.total} flights{lost}")
