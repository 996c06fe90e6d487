"""The table of an evaluation, written out."""

from crosstrack.learn.evaluation.score import Score

HEADINGS = (
    "world",
    "flown by",
    "success",
    "95 % interval",
    "otherwise",
    "mean speed, m/s",
    "clearance, m",
    "length / route",
    "interventions",
    "cross-track RMS, m",
    "decision, ms",
)
EXPLAINED = (
    "Success: arrived in time without a collision; none of these worlds was trained in. Speed: mean over successes.\n"
    "Clearance: from the vehicle's centre, the least of all flights (median of the least of each). Interventions of\n"
    "the safety layer: a flight. Cross-track: median (what 90 % of flights are below). Others: medians."
)


def cells(row: Score) -> tuple[str, ...]:
    """Return what the table says of a score, for every heading."""
    low, high = row.interval
    return (
        row.world,
        row.contestant,
        f"{row.arrived} of {row.flights}",
        f"{100 * low:.1f} to {100 * high:.1f} %",
        otherwise(row),
        number(row.mean_speed, ".2f"),
        "" if row.clearance is None else f"{row.clearance.least:.3f} ({row.clearance.median:.3f})",
        "" if row.length is None else f"{row.length.median:.3f}",
        number(row.interventions, ".2f"),
        "" if row.cross_track is None else f"{row.cross_track.median:.3f} ({row.cross_track_90:.3f})",
        "" if row.decision is None else f"{1e3 * row.decision.median:.2f}",
    )


def otherwise(row: Score) -> str:
    """Return how the flights ended that did not succeed."""
    counts = {
        "collided": row.collided,
        "left bounds": row.left_bounds,
        "late or stuck": row.late,
        "otherwise": row.otherwise,
        "lost": row.lost,
    }
    return ", ".join(f"{count} {word}" for word, count in counts.items() if count)


def number(value: float | None, style: str) -> str:
    """Write a number; nothing for None."""
    return "" if value is None else format(value, style)
