"""One decision, from the scan to the command: `python -m benchmarks.decision`.

A lidar of 16 x 900 beams flies at 3 m/s through forests of 40 x 20 x 3 m that the vehicle was not told of. Each
decision that has a scan is timed as it is flown, by `flight/pilot.py`: the scan into the local map, what moves, whether
the course is still good, the tracker, the avoiders. The scan itself and new plans are not in it. Times are processor
time of the thread.
"""

import time
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import numpy as np

import crosstrack as ct
from crosstrack.avoid.potential import Potential
from crosstrack.avoid.safety import Safety
from crosstrack.flight import loop
from crosstrack.flight.navigation import Navigator
from crosstrack.flight.pilot import Pilot
from crosstrack.sense.local_map import LocalMap
from crosstrack.sense.movers import Movers
from crosstrack.types import Array, Command, Others, Scan, State

DENSITIES = (0.1, 0.2, 0.4)
SEEDS = 2
CHAINS = ("[{kind: safety}]", "[{kind: potential}, {kind: safety}]")
PARTS: dict[str, tuple[type, str]] = {
    "map": (LocalMap, "add"),
    "movers": (Movers, "step"),
    "course": (Navigator, "again"),
    "potential": (Potential, "step"),
    "safety": (Safety, "step"),
    "together": (Pilot, "decide"),
    "plan": (Navigator, "planned"),
}
MISSION = """
start: {{position: [2, 10, 1.5]}}
goal: [38, 10, 1.5]
speed: 3
map: unknown
sensors: [{{kind: lidar, rings: 16, columns: 900}}]
planner: {{kind: auto}}
avoid: {avoid}
world:
  generate: {{kind: forest, seed: {seed}, size: [40, 20, 3], density: {density}, radius: [0.2, 0.5],
    clear: [[2, 10], [38, 10]]}}
"""


def timed(function: Callable[..., Any], spent: dict[str, float], part: str) -> Callable[..., Any]:
    """Return a function that also adds to what a part has spent (s)."""

    @wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        began = time.thread_time()
        try:
            return function(*given, **named)
        finally:
            spent[part] += time.thread_time() - began

    return call


def decisions(density: float, seed: int, avoid: str) -> Array:
    """Fly through one forest; return what its decisions with a scan took, (n, parts) ms, plans left out."""
    plan = ct.loads(MISSION.format(avoid=avoid, seed=seed, density=density)).build()
    loop.warm_up(plan)
    spent, rows = dict.fromkeys(PARTS, 0.0), []
    kept: dict[str, Callable[..., Any]] = {part: getattr(owner, name) for part, (owner, name) in PARTS.items()}

    def decide(pilot: Pilot, state: State, scans: Sequence[Scan], vehicles: Others) -> Command:
        spent.update(dict.fromkeys(PARTS, 0.0))
        command: Command = whole(pilot, state, scans, vehicles)
        if scans:
            planned = spent["plan"]
            rows.append([spent[part] - planned * (part in {"course", "together"}) for part in PARTS if part != "plan"])
        return command

    for part, (owner, name) in PARTS.items():
        setattr(owner, name, timed(kept[part], spent, part))
    whole: Callable[..., Command] = Pilot.decide
    setattr(Pilot, "decide", decide)  # noqa: B010 - what is measured is what is flown
    try:
        loop.fly(plan)
    finally:
        for part, (owner, name) in PARTS.items():
            setattr(owner, name, kept[part])
    return 1e3 * np.array(rows)


def main() -> None:
    """Print median, 99th percentile and maximum of each part, at each density and with each chain of avoiders."""
    print(f"{'trees per m²':>12}  {'part':>9}  {'median':>8}  {'99 %':>8}  {'most':>8}   ms")
    for avoid in CHAINS:
        print(f"avoid: {avoid}")
        for density in DENSITIES:
            taken = np.concatenate([decisions(density, seed, avoid) for seed in range(SEEDS)])
            for part, column in zip((part for part in PARTS if part != "plan"), taken.T, strict=True):
                middle, high = np.quantile(column, [0.5, 0.99])
                if high > 0.0:
                    print(f"{density:12.1f}  {part:>9}  {middle:8.3f}  {high:8.3f}  {column.max():8.3f}")


if __name__ == "__main__":
    main()
