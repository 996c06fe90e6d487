"""The table of the avoidance benchmark, written out."""

from crosstrack.campaign.avoidance.score import SLOWEST, Score
from crosstrack.campaign.ranking import Spread

HEADINGS = (
    "family",
    "contestant",
    "succeeded",
    "95 % interval",
    "otherwise",
    "least clearance, m",
    "length / optimum",
    "time / optimum",
    "mean speed, m/s",
    "planning, ms",
    "replans",
    "interventions",
    "decision, ms",
    "99 %, ms",
)
EXPLAINED = (
    f"Succeeded: arrived without a collision within {SLOWEST:g} times the time of the optimum; where no way exists, "
    "ended by saying so.\n"
    "Optimum: the shortest way that keeps 0.25 m, at cruise speed. Clearance: the least of all flights, swept. Others: "
    "medians (greatest); lengths, times and speeds of flights that arrived, 99 % the greatest."
)


def cells(row: Score) -> tuple[str, ...]:
    """Return what the table says of a score, for every heading."""
    low, high = row.interval
    return (
        row.family,
        row.contestant,
        f"{row.succeeded} of {row.flights}",
        f"{100 * low:.0f} to {100 * high:.0f} %",
        otherwise(row),
        "" if row.clearance is None else f"{row.clearance.least:.3f}",
        written(row.length, ".3f"),
        written(row.time, ".2f"),
        "" if row.speed is None else f"{row.speed.median:.2f}",
        written(row.planning, ".0f", 1e3),
        written(row.replans, "g"),
        written(row.interventions, "g"),
        "" if row.decision is None else f"{1e3 * row.decision.median:.2f}",
        "" if row.slowest_decision is None else f"{1e3 * row.slowest_decision.greatest:.2f}",
    )


def otherwise(row: Score) -> str:
    """Return how the flights ended that did not succeed."""
    rest = row.flights - row.succeeded - row.collided - row.late - row.lost
    counts = {"collided": row.collided, "late": row.late, "lost": row.lost, "not arrived": rest}
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count)


def written(found: Spread | None, style: str, factor: float = 1.0) -> str:
    """Write the median, and the greatest where it is another."""
    if found is None:
        return ""
    middle, most = (format(factor * value, style) for value in (found.median, found.greatest))
    return middle if middle == most else f"{middle} ({most})"
