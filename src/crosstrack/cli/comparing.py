"""What `crosstrack compare` does."""

import io
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crosstrack import mission as missions
from crosstrack.campaign.cluster import Cluster
from crosstrack.campaign.compare import Comparison, compared
from crosstrack.campaign.grid import badly_written, fitting, grid
from crosstrack.campaign.local import Local
from crosstrack.campaign.ranking import Row, Spread
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.words import OWN, tracker_words
from crosstrack.cli.campaigns import TABLE, flown, told
from crosstrack.cli.verbs import announce, made
from crosstrack.errors import InputError, Problem

PAGE, PICTURE = "comparison.html", "comparison.png"
ORDER = (
    "Errors: median (least to greatest) of the flights, cross-track from capture on.\n"
    "Ranked by arrivals, then cross-track error; tracking error where every flight has a trajectory."
)
NAME = 24
"""columns that the name of a tracker is given at least, where it needs them"""
WIDTH = 160
"""columns of a table that is not shown in a terminal"""


def compare(
    files: Sequence[Path],
    trackers: Sequence[str],
    winds: Sequence[str],
    seeds: int,
    runner: Runner,
    out: Path | None,
    settings: Sequence[str],
    as_json: bool,
    png: bool,
) -> int:
    """Fly missions with several trackers, and write and print how each did."""
    words = [word for text in trackers for word in tracker_words(text)]
    chosen = loaded(files, settings, words, winds)
    announce("Getting ready")
    tasks = grid(chosen, words or fitting(chosen), winds or [OWN], seeds)
    folder = made(out or Path("runs") / "compare")
    with flown("Flights to compare", tasks, runner, folder) as done:
        comparison = compared(tasks, done)
        write(comparison, folder, png)
    tell(comparison, folder, as_json)
    return told(comparison.losses)


def runner_for(workers: int | None, cluster: str | None) -> Runner:
    """Return what flies: processes of this machine, or a cluster.

    Raises:
        InputError: a number of workers that cannot be, both, or a cluster that cannot be used.
    """
    if cluster is None:
        return Local(workers)
    if workers is not None:
        raise InputError("--workers", [Problem("", "a cluster given by --cluster has its own workers: leave one out")])
    return Cluster(cluster)


def loaded(
    files: Sequence[Path], settings: Sequence[str], words: Sequence[str], winds: Sequence[str]
) -> list[missions.Mission]:
    """Return missions.

    Raises:
        InputError: everything that is wrong with all of them; then also what is wrong with trackers and winds by
            themselves.
    """
    found, errors = [], list[InputError]()
    for file in files:
        try:
            found.append(missions.load(file, settings))
        except InputError as error:
            errors.append(error)
    if not errors:
        return found
    others = list(badly_written(words, winds))
    if len(errors) == 1 and not others:
        raise errors[0]
    problems = [Problem(error.source, str(problem)) for error in errors for problem in error.problems]
    raise InputError("compare", [*problems, *others])


def write(comparison: Comparison, folder: Path, png: bool) -> None:
    """Write the table and the page of a comparison, and its picture where asked."""
    from crosstrack.show.comparison import comparison_page

    comparison.write_csv(folder / TABLE)
    comparison_page(comparison.results, folder / PAGE, comparison.losses)
    if png:
        from crosstrack.show.comparison_picture import comparison_picture

        comparison_picture(comparison.results, folder / PICTURE)


def tell(comparison: Comparison, folder: Path, as_json: bool) -> None:
    """Print the rankings."""
    if as_json:
        print(json.dumps(comparison.document(), indent=2))
        return
    names = comparison.missions
    shown = [table(comparison.ranking(name), name) for name in names] if len(names) > 1 else []
    show([*shown, table(comparison.ranking(), "all missions" if len(names) > 1 else names[0])])
    print(f"{ORDER}\nPage: {folder / PAGE}")


def show(tables: Sequence[Any]) -> None:
    """Print tables on standard output, with a question mark for what its encoding lacks.

    They are rendered first: an output that is closed or full is then met by `print`, as anywhere else.
    """
    from rich.console import Console

    terminal = sys.stdout is not None and sys.stdout.isatty()
    encoding = sys.stdout.encoding if sys.stdout is not None else "utf-8"
    with io.TextIOWrapper(io.BytesIO(), encoding, errors="replace", newline="\n") as page:
        console = Console(
            file=page, force_terminal=terminal, width=None if terminal else WIDTH,
            markup=False, highlight=False, emoji=False, soft_wrap=False,
        )  # fmt: skip
        for each in tables:
            console.print(each)
        page.seek(0)
        print(page.read(), end="")


def table(rows: Sequence[Row], title: str) -> Any:
    """Return a ranking as a table; columns in which there is nothing are left out."""
    from rich.table import Table

    shown = Table(title=title, title_justify="left")
    shown.add_column("", justify="right")
    shown.add_column("tracker", overflow="fold", min_width=min(NAME, max(len(row.tracker) for row in rows)))
    cells = {
        "arrived": [f"{row.arrived} of {row.flights}" for row in rows],
        "collided": [str(row.collided or "") for row in rows],
        "lost": [str(row.lost or "") for row in rows],
        "cross-track RMS, m": [between(row.cross_track_rms) for row in rows],
        "largest, m": ["" if row.cross_track_max is None else length(row.cross_track_max) for row in rows],
        "tracking RMS, m": [between(row.tracking_rms) for row in rows],
        "time ratio": ["" if row.time_ratio is None else f"{row.time_ratio.median:.3f}" for row in rows],
    }
    filled = [heading for heading, column in cells.items() if any(column)]
    for heading in filled:
        shown.add_column(heading, justify="right")
    for k, row in enumerate(rows):
        shown.add_row(str(k + 1), row.tracker, *(cells[heading][k] for heading in filled))
    return shown


def between(spread: Spread | None) -> str:
    """Return median, least and greatest of errors."""
    if spread is None:
        return ""
    alone = spread.least == spread.greatest
    return length(spread.median) + ("" if alone else f" ({length(spread.least)} to {length(spread.greatest)})")


def length(error: float) -> str:
    """Return an error in metres; one from capture on is infinite where the route was never captured."""
    return f"{error:.3f}" if error < float("inf") else "never"


def filled(headings: Sequence[str], written: Sequence[Sequence[str]]) -> Any:
    """Return lines of cells as a table; columns in which there is nothing are left out."""
    from rich.table import Table

    shown = Table()
    kept = [k for k in range(len(headings)) if any(line[k] for line in written)]
    for k in kept:
        shown.add_column(headings[k], justify="left" if k < 2 else "right", overflow="fold")
    for line in written:
        shown.add_row(*(line[k] for k in kept))
    return shown
