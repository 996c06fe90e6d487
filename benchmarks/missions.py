"""How well and how fast the example missions fly; the table of the README.

Run as `python benchmarks/missions.py`. Flights are exactly repeatable, so only the times of the machine have a spread;
a gusty mission is flown from several seeds instead.
"""

import statistics
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

import crosstrack as ct

EXAMPLES = Path(__file__).parents[1] / "examples"
ROUNDS = 7
SEEDS = 10


def rounds(path: Path) -> list[ct.Flight]:
    """Fly an example: from several seeds where the wind or the estimate is random, else several times alike."""
    mission = ct.load(path)
    if mission.wind.gusts == "none" and mission.noise.position == 0:
        return [ct.fly(mission) for _ in range(ROUNDS)]
    return [ct.fly(replace(mission, seed=seed)) for seed in range(1, SEEDS + 1)]


def spread(values: list[float], digits: int) -> str:
    """Return the median, and the least and the greatest where they differ."""
    low, middle, high = min(values), statistics.median(values), max(values)
    text = f"{middle:.{digits}f}"
    return text if f"{low:.{digits}f}" == f"{high:.{digits}f}" else f"{text} ({low:.{digits}f}-{high:.{digits}f})"


def main() -> None:
    table = Table(title="Example missions: median (least-greatest)")
    for column in ("mission", "flights", "time, s", "planned, s", "RMS, m", "captured RMS, m", "max, m", "top, m/s"):
        table.add_column(column, justify="left" if column == "mission" else "right")
    table.add_column("flown / computed", justify="right")
    ct.fly(ct.load(EXAMPLES / "square.yaml"))
    for path in sorted(EXAMPLES.glob("*.yaml")):
        flights = rounds(path)
        metrics = [flight.metrics for flight in flights]
        captured = [m.cross_track_rms_captured_m for m in metrics if m.cross_track_rms_captured_m is not None]
        arrived = sum(flight.outcome is ct.Outcome.ARRIVED for flight in flights)
        table.add_row(
            path.stem,
            f"{arrived}/{len(flights)}",
            spread([m.flight_time_s for m in metrics], 2),
            spread([m.ideal_time_s for m in metrics], 2),
            spread([m.cross_track_rms_m for m in metrics], 3),
            spread(captured, 3) if captured else "-",
            spread([m.cross_track_max_m for m in metrics], 3),
            spread([m.max_speed_mps for m in metrics], 2),
            spread([m.flight_time_s / m.wall_time_s for m in metrics], 0),
        )
    Console(width=150).print(table)


if __name__ == "__main__":
    main()
