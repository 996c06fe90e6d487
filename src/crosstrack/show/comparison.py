"""The page of a comparison: one HTML file that needs nothing else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plotly.offline import get_plotlyjs

from crosstrack.show.comparison_figures import boxes, plan_view, speeds, times
from crosstrack.show.comparison_flights import Flown, Group, Look, flown, groups, looks
from crosstrack.show.comparison_table import COLUMNS, Standing, short, standings
from crosstrack.show.report import environment, script_safe
from crosstrack.show.traces import Figure

DRAWN = 100_000
"""samples of all flights drawn, about: each is kept in 50 bytes"""
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


def comparison_page(results: Sequence[Mapping[str, Any]], path: str | Path) -> Path:
    """Write the page of a comparison and return its path.

    Args:
        results: of flights: labels (mission, tracker, wind, seed), summary, trace and route; may be none
        path: the HTML file; its folder is made where it is missing

    Raises:
        OSError: the file cannot be written.
    """
    path, flights = Path(path), flown(results)
    found, known = groups(flights), looks(flights)
    rows = max(40, DRAWN // max(1, sum(len({flight.tracker for flight in group.flights}) for group in found)))
    lost = [flight for flight in flights if not flight.arrived]
    text = (
        environment()
        .get_template("comparison.html")
        .render(
            title=", ".join(dict.fromkeys(flight.mission for flight in flights)) or "Nothing flown",
            sentence=sentence(flights),
            headings=[heading for _, heading, _ in COLUMNS],
            overall=standings(flights),
            sections=[section(group, found) for group in found],
            looks=known,
            strokes=STROKES,
            lost=lost[:LISTED],
            unlisted=len(lost[LISTED:]),
            short=short,
            plotly=get_plotlyjs() if flights else "",
            data=script_safe({"groups": [drawn(group, flights, known, rows) for group in found]}),
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def sentence(flights: Sequence[Flown]) -> str:
    """Return what was compared, in numbers."""
    if not flights:
        return "No flight came back: there is nothing to compare."
    kinds = [
        counted(len({getattr(flight, name) for flight in flights}), word)
        for name, word in (("tracker", "tracker"), ("mission", "mission"), ("wind", "wind"), ("seed", "seed"))
    ]
    arrived = sum(flight.arrived for flight in flights)
    return f"{counted(len(flights), 'flight')} of {', '.join(kinds)}; {arrived} arrived."


def counted(count: int, word: str) -> str:
    """Return a count and a word, in the plural where it is due."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def section(group: Group, found: Sequence[Group]) -> Section:
    """Return what the page shows of a group beside its figures."""
    several = len({other.wind for other in found}) > 1
    title = f"{group.mission}, wind {group.wind}" if several else group.mission
    seeds = len({flight.seed for flight in group.flights})
    note = (
        f"Of {counted(seeds, 'seed')}, the flight in the middle of each tracker is drawn, from best to worst by "
        "arrival and error; crosses mark where flights ended that did not arrive, from any seed."
    )
    return Section(title, standings(group.flights), note)


def drawn(group: Group, flights: Sequence[Flown], known: Mapping[str, Look], rows: int) -> dict[str, Figure | None]:
    """Return the figures of a group; the boxes are those of its mission in all winds."""
    mission = [flight for flight in flights if flight.mission == group.mission]
    order = [row.tracker for row in standings(mission)]
    return {
        "plan": plan_view(group, known, rows),
        "times": times(group, known, rows),
        "speeds": speeds(group, known),
        "boxes": boxes(mission, known, order, CAPTURED, "cross-track error, RMS once captured (m)"),
        "tracking": boxes(mission, known, order, TRACKING, "distance to the trajectory's point, RMS (m)"),
    }
