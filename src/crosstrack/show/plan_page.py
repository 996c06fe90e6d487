"""The page of a planned trajectory: one HTML file that needs nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from plotly.offline import get_plotlyjs

from crosstrack.mission.certified import Certified, Line
from crosstrack.show.planned import figures
from crosstrack.show.report import environment, mission_text, script_safe
from crosstrack.show.words import NOTHING

NOTE = (
    "Certified are bounds over every instant, not over samples: polynomials are enclosed by their Bernstein "
    "coefficients, the clearance by how far the trajectory can be from where it was measured. The curves above are "
    "drawn through samples. Of the vehicle's acceleration the tracker keeps a tenth."
)
CARDS = (
    "duration",
    "length",
    "largest speed",
    "largest acceleration",
    "largest deviation from the route",
    "least clearance",
)
"""the quantities that head the page"""


@dataclass(frozen=True)
class Row:
    """One quantity, written out."""

    label: str
    unit: str
    value: str
    limit: str
    time: str
    verdict: str


def plan_page(found: Certified, path: str | Path) -> Path:
    """Write the page of a planned mission and return its path.

    Args:
        found: the trajectory and its certificate
        path: the HTML file; its folder is made where it is missing

    Raises:
        OSError: the file cannot be written.
    """
    path, rows = Path(path), [row(line) for line in found.lines]
    text = (
        environment()
        .get_template("plan.html")
        .render(
            title=found.plan.name,
            holds=not found.broken,
            sentence=sentence(found.broken),
            cards=[card for card in rows if card.label in CARDS],
            rows=rows,
            note=NOTE,
            mission=mission_text(found.plan.document),
            plotly=get_plotlyjs(),
            data=script_safe(figures(found)),
        )
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def sentence(broken: Sequence[Line]) -> str:
    """Return what the certificate says in a sentence."""
    if not broken:
        return "Every limit holds at every instant."
    return f"Beyond the limit: {', '.join(line.quantity for line in broken)}."


def row(line: Line) -> Row:
    """Write a line out."""
    limit = NOTHING if line.limit is None else f"{line.limit:.3f}"
    if line.limit is not None:
        limit = f"{'≥' if line.least else '≤'} {limit.removeprefix('-') if abs(line.limit) < 5e-4 else limit}"
    return Row(
        label=line.quantity,
        unit=line.unit,
        value=f"{line.value:.3f}",
        limit=limit,
        time=NOTHING if line.time is None else f"{line.time:.2f} s",
        verdict="" if line.limit is None else "holds" if line.holds else "exceeded",
    )
