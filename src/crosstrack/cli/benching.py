"""What `crosstrack bench avoid` does."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from crosstrack.campaign.avoidance.bench import Benchmark, judged, tasks
from crosstrack.campaign.avoidance.score import Score
from crosstrack.campaign.complete import complete, kept
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.store import Store
from crosstrack.campaign.task import Done
from crosstrack.cli import codes
from crosstrack.cli.comparing import show
from crosstrack.cli.tally import Tally
from crosstrack.cli.verbs import compiled_before, made, named
from crosstrack.cli.watch import say

RESULTS, TABLE = "results.jsonl", "results.csv"


def avoid(
    families: Sequence[str],
    contestants: Sequence[str],
    maps: int,
    seed: int,
    runner: Runner,
    out: Path | None,
    as_json: bool,
) -> int:
    """Fly the benchmark of obstacle avoidance, and write and print how each contestant did."""
    asked = tasks(words(families), words(contestants), maps, seed)
    say("Getting ready ..." if compiled_before() else "Getting ready; the first run compiles for some two minutes ...")
    folder = made(out or Path("runs") / "bench" / "avoid")
    with named(folder), Store(folder / RESULTS) as store:
        before = kept(asked, store)
        try:
            with runner as workers, Count(len(asked), before) as count:
                found = judged(asked, complete(asked, workers, store, count))
        except KeyboardInterrupt:
            say(
                f"{kept(asked, store)} of {len(asked)} flights are kept in {folder}; the same command flies the others."
            )
            raise
        page = write(found, folder)
    tell(found, page, as_json)
    for loss in found.losses:
        say(f"lost: {', '.join(f'{name} {value}' for name, value in loss.labels.items())}: {loss.error}")
    return codes.FLIGHTS_LOST if found.losses else codes.DONE


def words(texts: Sequence[str]) -> list[str]:
    """Return the words of lists such as `forest,maze`."""
    return [word.strip() for text in texts for word in text.split(",")]


def write(found: Benchmark, folder: Path) -> Path:
    """Write the table, the page and the pictures of every failure; return the page's path."""
    from crosstrack.show.bench_page import benchmark_page

    found.write_csv(folder / TABLE)
    return benchmark_page(found, folder)


def tell(found: Benchmark, page: Path, as_json: bool) -> None:
    """Print the scores."""
    from crosstrack.show.bench_table import EXPLAINED

    if as_json:
        print(json.dumps(found.document(), indent=2))
        return
    several = len({row.family for row in found.scores}) > 1
    show([table(found.scores), *([table(found.totals)] if several else [])])
    print(f"{EXPLAINED}\nPage: {page}")


def table(rows: Sequence[Score]) -> Any:
    """Return scores as a table; columns in which there is nothing are left out."""
    from rich.table import Table

    from crosstrack.show.bench_table import HEADINGS, cells

    shown = Table()
    written = [cells(row) for row in rows]
    filled = [k for k in range(len(HEADINGS)) if any(line[k] for line in written)]
    for k in filled:
        shown.add_column(HEADINGS[k], justify="left" if k < 2 else "right", overflow="fold")
    for line in written:
        shown.add_row(*(line[k] for k in filled))
    return shown


class Count(Tally):
    """Show how many flights are done, and how many of them were lost."""

    def __init__(self, total: int, before: int) -> None:
        super().__init__(total, before)
        self.done, self.lost = before, 0

    def __enter__(self) -> Self:
        """Say what is to be done."""
        kept = f", {self.done} of them kept from before" if self.done else ""
        say(f"Flights of the benchmark: {self.total}{kept}.")
        return super().__enter__()

    def __call__(self, done: Done) -> None:
        """Count a flight, and show it when it is due."""
        self.done += 1
        self.lost += done.error is not None
        lost = f", {self.lost} lost" if self.lost else ""
        self.show(self.done, f"flights{lost}", f"{self.done} of {self.total} flights{lost}")
