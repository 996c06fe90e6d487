"""The page of the avoidance benchmark: its table, its shares, and a picture of every failure; needs nothing else."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crosstrack.campaign.avoidance.bench import Benchmark
from crosstrack.campaign.avoidance.contestants import CONTESTANTS
from crosstrack.mission.load import dump
from crosstrack.show.bench_picture import flight_picture, share_picture
from crosstrack.show.bench_table import EXPLAINED, HEADINGS, cells
from crosstrack.show.comparison import counted
from crosstrack.show.report import environment
from crosstrack.types import Outcome

PAGE, SHARES, FAILURES = "benchmark.html", "shares.png", "failures"
SHOWN = 200
"""failures of which the page holds the picture; the others are beside it"""


@dataclass(frozen=True)
class Failure:
    """A flight that did not succeed."""

    name: str
    outcome: str
    """key of the outcome"""
    sentence: str
    picture: str
    """as an address that holds it"""


def benchmark_page(found: Benchmark, folder: Path) -> Path:
    """Write the page, the picture of the shares, and picture and mission of every failure; return the page's path.

    Raises:
        OSError: a file cannot be written.
    """
    shares, failures = folder / SHARES, folder / FAILURES
    failures.mkdir(parents=True, exist_ok=True)
    for stale in (*failures.glob("*.png"), *failures.glob("*.yaml")):
        stale.unlink()
    rows = [*found.scores, *(found.totals if len({row.family for row in found.scores}) > 1 else [])]
    if rows:
        share_picture(found.scores, shares)
    pictured = [failure(result, failures, k < SHOWN) for k, result in enumerate(found.failures)]
    text = environment().get_template("bench.html").render(
        title="Obstacle avoidance",
        sentence=sentence(len(found.results) + len(found.losses), len(found.failures) + len(found.losses)),
        contestants=[CONTESTANTS[name] for name in dict.fromkeys(row.contestant for row in rows)],
        headings=HEADINGS,
        rows=[cells(row) for row in rows],
        explained=EXPLAINED,
        shares=address(shares) if rows else "",
        failures=[one for one in pictured if one is not None],
        unshown=max(0, len(found.failures) - SHOWN),
        losses=found.losses,
        plotly="",
        data="{}",
    )  # fmt: skip
    path = folder / PAGE
    path.write_text(text, encoding="utf-8")
    return path


def sentence(flights: int, failed: int) -> str:
    """Return how many flights there were, and how many failed."""
    return f"{counted(flights, 'flight')}; {failed or 'none'} failed." if flights else "No flight came back."


def failure(result: Mapping[str, Any], folder: Path, shown: bool) -> Failure | None:
    """Write picture and mission of a failure; return what the page shows of it."""
    name, outcome = result["document"]["name"], result["outcome"]
    picture = folder / f"{name}.png"
    flight_picture(result, picture)
    (folder / f"{name}.yaml").write_text(dump(result["document"]), encoding="utf-8")
    sentence = Outcome[outcome.upper()].value
    return Failure(name, outcome, sentence, address(picture)) if shown else None


def address(picture: Path) -> str:
    """Return a picture as an address that holds it."""
    return "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()
