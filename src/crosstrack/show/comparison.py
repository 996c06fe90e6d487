"""The page of a comparison: one HTML file that needs nothing else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs

from crosstrack.campaign.ranking import Loss
from crosstrack.show.comparison_figures import boxes, plan_view, speeds, times
from crosstrack.show.comparison_flights import Flown, Group, Look, flown, groups, looks, weather
from crosstrack.show.comparison_table import BROKEN, HEADINGS, Standing, failures, standings
from crosstrack.show.report import environment, script_safe
from crosstrack.show.traces import Figure

DRAWN = 100_000
"""samples of all flights drawn, about: each is kept in 50 bytes"""
FEW = 3
"""missions that a title names"""
LISTED = 200
"""flights that failed that are listed"""
STROKES = {"solid": "", "dash": "7 4", "dot": "2 3", "dashdot": "8 3 2 3"}
"""dashes of the legend"""
CAPTURED, TRACKING = "cross_track_rms_captured_m", "tracking_rms_m"


@dataclass(frozen=True)
class Section:
    """What the page shows of one mission in one wind."""

    title: str
    rows: list[Standing]
    note: str


def comparison_page(results: Sequence[Mapping[str, Any]], path: str | Path, losses: Sequence[Loss] = ()) -> Path:
    """Write the page of a comparison and return its path.

    Args:
        results: of flights: labels (mission, tracker, wind, seed), summary, trace and route; may be none
        path: the HTML file; its folder is made where it is missing
        losses: flights of which there is only an error

    Raises:
        OSError: the file cannot be written.
    """
    path, flights = Path(path), flown(results)
    found, failed = groups(flights), failures(flights, losses)
    known = looks([*(flight.tracker for flight in flights), *(loss.labels["tracker"] for loss in losses)])
    rows = max(40, DRAWN // max(1, sum(len({flight.tracker for flight in group.flights}) for group in found)))
    text = (
        environment()
        .get_template("comparison.html")
        .render(
            title=title(flights),
            sentence=sentence(flights, losses),
            headings=HEADINGS,
            overall=standings(flights, losses),
            timed=all(flight.summary[TRACKING] is not None for flight in flights),
            sections=[section(group, found, losses) for group in found],
            looks=known,
            strokes=STROKES,
            failures=failed[:LISTED],
            unlisted=len(failed[LISTED:]),
            plotly=get_plotlyjs() if flights else "",
            data=script_safe({"groups": [drawn(group, flights, known, rows) for group in found]}),
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def title(flights: Sequence[Flown]) -> str:
    """Return the names of a few missions, or how many there are."""
    names = list(dict.fromkeys(flight.mission for flight in flights))
    return ", ".join(names) or "Nothing flown" if len(names) <= FEW else counted(len(names), "mission")


def sentence(flights: Sequence[Flown], losses: Sequence[Loss]) -> str:
    """Return what was compared, in numbers."""
    broken = f" {counted(len(losses), 'flight')} {BROKEN}." if losses else ""
    if not flights:
        return f"No flight came back: there is nothing to compare.{broken}"
    kinds = [
        counted(len({getattr(flight, name) for flight in flights}), word)
        for name, word in (("tracker", "tracker"), ("mission", "mission"), ("wind", "wind"), ("seed", "seed"))
    ]
    arrived = sum(flight.arrived for flight in flights)
    return f"{counted(len(flights), 'flight')} of {', '.join(kinds)}; {arrived} arrived.{broken}"


def counted(count: int, word: str) -> str:
    """Return a count and a word, in the plural where it is due."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def section(group: Group, found: Sequence[Group], losses: Sequence[Loss]) -> Section:
    """Return what the page shows of a group beside its figures."""
    several = len({other.wind for other in found}) > 1
    name = f"{group.mission}, {weather(group.wind)}" if several else group.mission
    seeds = len({flight.seed for flight in group.flights})
    middle = f"Of the {seeds} seeds of each tracker, the flight in the middle from best to worst is drawn. "
    crosses = "Crosses mark where flights ended that did not arrive, from any seed."
    lost = any(not flight.arrived for flight in group.flights)
    note = (middle if seeds > 1 else "") + (crosses if lost else "")
    mine = [loss for loss in losses if (loss.labels["mission"], loss.labels["wind"]) == (group.mission, group.wind)]
    return Section(name, standings(group.flights, mine), note)


def drawn(group: Group, flights: Sequence[Flown], known: Mapping[str, Look], rows: int) -> dict[str, Figure | None]:
    """Return the figures of a group; the boxes are those of its mission in all winds."""
    mission = [flight for flight in flights if flight.mission == group.mission]
    order = [row.tracker for row in standings(mission)]
    return {
        "plan": plan_view(group, known, rows),
        "times": times(group, known, rows),
        "speeds": speeds(group, known),
        "boxes": boxes(mission, known, order, CAPTURED, "RMS once captured (m)"),
        "tracking": boxes(mission, known, order, TRACKING, "RMS distance to its point (m)"),
    }
