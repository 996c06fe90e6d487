"""What `crosstrack bench avoid` does."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crosstrack.campaign.avoidance.bench import Benchmark, judged, tasks
from crosstrack.campaign.avoidance.score import Score
from crosstrack.campaign.runner import Runner
from crosstrack.cli.campaigns import TABLE, flown, told
from crosstrack.cli.comparing import filled, show
from crosstrack.cli.verbs import announce, made


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
    announce("Getting ready")
    folder = made(out or Path("runs") / "bench" / "avoid")
    with flown("Flights of the benchmark", asked, runner, folder) as done:
        found = judged(asked, done)
        page = write(found, folder)
    tell(found, page, as_json)
    return told(found.losses)


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
    """Return scores as a table."""
    from crosstrack.show.bench_table import HEADINGS, cells

    return filled(HEADINGS, [cells(row) for row in rows])
