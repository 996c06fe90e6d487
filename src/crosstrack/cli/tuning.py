"""What `crosstrack tune` does."""

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from crosstrack import mission as missions
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.tune import Tuned, tune
from crosstrack.campaign.tune_cost import Cost
from crosstrack.campaign.tune_search import Axis, Trial
from crosstrack.campaign.tune_setup import Tuning, tuning
from crosstrack.campaign.words import OWN
from crosstrack.cli import codes
from crosstrack.cli.comparing import show
from crosstrack.cli.tally import Tally
from crosstrack.cli.verbs import made, named
from crosstrack.cli.watch import say
from crosstrack.errors import InputError, Problem
from crosstrack.mission.load import dump

NAMING = ("route", "world", "planner")
"""fields of a mission that can name files"""
EDGE = 0.01
"""of the range of a parameter: a value so near to an end might be better beyond it"""


def run(
    file: Path,
    tracker: str | None,
    parameters: Sequence[str],
    cost: str | None,
    winds: Sequence[str],
    seeds: int | None,
    budget: int,
    runner: Runner,
    out: Path | None,
    settings: Sequence[str],
    as_json: bool,
) -> int:
    """Tune a tracker, write the mission with what was found, and tell how much better it is."""
    mission = missions.load(file, settings)
    what = tuning(mission, tracker, parameters=parameters, cost=cost, winds=winds or [OWN], seeds=seeds, budget=budget)
    path = claimed(out or Path("runs") / "tune" / f"{mission.name}.yaml", file)
    try:
        with runner as workers, Count(what) as count:
            found = tune(what, workers, count)
    except KeyboardInterrupt:
        say("interrupted before the present values were measured: nothing is written")
        raise
    try:
        with named(path):
            write(found, mission, path)
    finally:  # also where the disk is full by now: flights are not flown for nothing
        tell(found, path, as_json)
    for remark in remarks(found):
        say(f"note: {remark}")
    return codes.INTERRUPTED if found.interrupted else codes.DONE


def claimed(path: Path, mission: Path) -> Path:
    """Return a path after trying that it and the page beside it can be written, before anything flies.

    Raises:
        InputError: it is no YAML file, or the mission that is tuned, with the comments that its author wrote.
        OSError: it cannot be written.
    """
    if path.suffix not in {".yaml", ".yml"} or path.is_dir():
        raise InputError("--out", [Problem(str(path), "must be a file that ends in .yaml")])
    if path.exists() and path.samefile(mission):
        raise InputError("--out", [Problem(str(path), "is the mission that is tuned: name another file")])
    made(path.parent)
    for file in (path, path.with_suffix(".html")):
        new = not file.exists()
        with file.open("ab"):
            pass
        if new:
            file.unlink()
    return path


def write(found: Tuned, mission: missions.Mission, path: Path) -> None:
    """Write the mission with the values found, and the page of the flights before and after."""
    from crosstrack.show.comparison import comparison_page

    document = found.mission.document()
    folder = mission.files if isinstance(mission.files, Path) else Path()
    moved = {name: os.path.relpath(folder / name, path.parent) for name in mission.names}
    document |= {key: renamed(document[key], moved) for key in NAMING if key in document}
    path.write_text(headline(found) + dump(document), encoding="utf-8")
    comparison_page(found.results, path.with_suffix(".html"))


def renamed(value: Any, names: dict[str, str]) -> Any:
    """Return a part of a document with other names for its files."""
    if isinstance(value, dict):
        return {key: renamed(inner, names) for key, inner in value.items()}
    if isinstance(value, list):
        return [renamed(inner, names) for inner in value]
    return names.get(value, value) if isinstance(value, str) else value


def headline(found: Tuned) -> str:
    """Return the comment over a tuned mission."""
    names = ", ".join(axis.name for axis in found.tuning.axes)
    return f"# Tuned {names} for {expression(found.tuning)}: {found.before.cost} before, {found.after.cost} after.\n"


def expression(what: Tuning) -> str:
    """Write the cost that is minimised."""
    return " + ".join((f"{term.weight:g}*" if term.weight != 1 else "") + term.metric for term in what.terms)


def tell(found: Tuned, path: Path, as_json: bool) -> None:
    """Print what was found."""
    if as_json:
        print(json.dumps(document_of(found, path), indent=2))
        return
    from rich.table import Table

    shown = Table(title=f"{found.tuning.mission.name}, {expression(found.tuning)}", title_justify="left")
    for heading in ("", "before", "after", "searched"):
        shown.add_column(heading, justify="right" if heading else "left")
    for axis in found.tuning.axes:
        shown.add_row(
            axis.name, f"{axis.value:.4g}", f"{found.after.values[axis.name]:.4g}", f"{axis.low:.4g} to {axis.high:.4g}"
        )
    shown.add_section()
    for label, before, after in costs(found):
        shown.add_row(label, str(before), str(after))
    show([shown])
    print(f"Mission: {path}\nPage: {path.with_suffix('.html')}")


def costs(found: Tuned) -> list[tuple[str, Cost, Cost]]:
    """Return what is measured on which seeds, before and after."""
    what = found.tuning
    first, last = what.mission.seed, what.mission.seed + what.seeds - 1
    rows = [(f"cost, {span(first, last)}", found.before.cost, found.after.cost)]
    if found.held_out:
        before, after = found.held_out
        rows.append((f"cost, held-out {span(last + 1, last + what.seeds)}", before.cost, after.cost))
    return rows


def span(first: int, last: int) -> str:
    """Write a range of seeds."""
    return f"seed {first}" if first == last else f"seeds {first} to {last}"


def document_of(found: Tuned, path: Path) -> dict[str, Any]:
    """Return what was found as plain values for JSON."""
    before, after = found.held_out or (None, None)
    return {
        "mission": str(path),
        "page": str(path.with_suffix(".html")),
        "cost": expression(found.tuning),
        "parameters": {
            axis.name: {
                "before": axis.value,
                "after": found.after.values[axis.name],
                "low": axis.low,
                "high": axis.high,
            }
            for axis in found.tuning.axes
        },
        "tuning": {"before": plain(found.before), "after": plain(found.after)},
        "held_out": None if before is None else {"before": plain(before), "after": plain(after)},
        "seeds": found.tuning.seeds,
        "winds": list(found.tuning.winds),
        "flights": found.flights,
        "interrupted": found.interrupted,
    }


def plain(trial: Trial | None) -> dict[str, Any] | None:
    """Return what a trial costs as plain values; null for the mean where all flights missed."""
    if trial is None:
        return None
    return {"mean": trial.cost.mean if math.isfinite(trial.cost.mean) else None, "missed": trial.cost.missed}


def remarks(found: Tuned) -> list[str]:
    """Say what is odd about what was found."""
    told = []
    if found.after is found.before:
        told.append("no better values were found; the mission written has the present ones")
    told += [f"{axis.name} is at an end of its range" for axis in found.tuning.axes if at_end(axis, found)]
    if found.errors:
        told.append(f"{len(found.errors)} flights broke, the first by: {found.errors[0]}")
    if found.held_out and found.held_out[1].cost > found.held_out[0].cost:
        told.append("on held-out seeds it costs more than before: tune over more --seeds")
    if found.interrupted:
        told.append("interrupted: the best so far was kept")
    return told


def at_end(axis: Axis, found: Tuned) -> bool:
    """Return whether the best value of a parameter, not the present one, is at an end of its range."""
    return found.after is not found.before and not EDGE < axis.unit(found.after.values[axis.name]) < 1 - EDGE


class Count(Tally):
    """Show how many flights are flown, and the best cost."""

    def __init__(self, what: Tuning) -> None:
        super().__init__(what.budget)
        self.what = what

    def __enter__(self) -> Self:
        """Say what is to be done."""
        names = ", ".join(axis.name for axis in self.what.axes)
        say(f"Tuning {names} in up to {self.what.budget} flights; the first ones take longest. Ctrl-C keeps the best.")
        return super().__enter__()

    def __call__(self, flown: int, best: Trial | None) -> None:
        """Count a flight, and show it when it is due."""
        told = f"best cost {best.cost}" if best else "measuring the present values"
        self.show(flown, told, f"{flown} of {self.total} flights, {told}")
