"""Planning through forests of 40 x 20 x 3 m: time of field, way and trajectory, length against the optimum, clearance.

Run as `python -m benchmarks.planning [maps]`. The optimum is exact, in the plane, at a clearance of 0.25 m; where the
package ompl is installed, its planners look for ways through the same forests. Times are of the processor, in ms.
"""

import statistics
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import TypeVar

import numpy as np

from crosstrack.campaign.avoidance.optimum import optimum
from crosstrack.errors import Unreachable
from crosstrack.plan.auto import EDGE, Auto, room
from crosstrack.protocols import PlanningTask
from crosstrack.search.taut import length
from crosstrack.search.way import find_way
from crosstrack.trajectory.certified.clearance import least_clearance
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Envelope
from crosstrack.world.generate import Forest
from crosstrack.world.world import World

BOUNDS = np.array([[0.0, 0.0, 0.0], [40.0, 20.0, 3.0]])
ENDS = np.array([[1.0, 10.0, 1.5], [39.0, 10.0, 1.5]])
RADIUS, CLEARANCE, SPEED = 0.2, 0.25, 4.0
ENVELOPE = Envelope(12.0, 4.0, 7.2, 3.0, 0.1)
CHECKS = 20_000
Result = TypeVar("Result")


def forest(seed: int, density: float) -> World:
    """Return a forest in which both ends have half a metre of room."""
    clear = tuple((float(x), float(y)) for x, y, _ in ENDS)
    return World(Forest(seed, (40.0, 20.0, 3.0), density, (0.2, 0.5), clear, 0.5).shapes(), bounds=BOUNDS)


def timed(call: Callable[[], Result]) -> tuple[Result, float]:
    """Return a result and how long it took, ms."""
    began = time.process_time()
    result = call()
    return result, 1e3 * (time.process_time() - began)


def sized(curve: PiecewisePolynomial) -> float:
    """Return the length of a trajectory, m."""
    return length(curve(np.linspace(0.0, curve.duration, 4000)))


def planned(density: float, maps: int) -> None:
    """Print what planning takes and gives at a density."""
    rows, missed = [], 0
    for world, best in with_optimum(density, maps):
        if best is None:
            continue
        task = PlanningTask(ENDS, SPEED, 1.0, ENVELOPE, world, RADIUS)
        box = room(world, RADIUS) + [[-EDGE], [EDGE]]
        _, field = timed(partial(world.field, BOUNDS[0], 0.1, (401, 201, 31), 1.0))
        try:
            way, search = timed(partial(find_way, world, ENDS[0], ENDS[1], CLEARANCE, box))
            curve, whole = timed(partial(Auto().curve, task, np.inf))
        except Unreachable:
            missed += 1
            continue
        clear = least_clearance(curve, world, tolerance=0.002).value
        ratios = length(way) / best, sized(curve) / best
        rows.append((field, search, whole, *ratios, clear, sized(curve) / curve.duration))
    table = np.array(rows)
    middle, least = np.median(table, axis=0), table.min(axis=0)
    print(
        f"{density:.1f} trees/m²: {len(rows)} of {len(rows) + missed} solvable; field at 0.1 m {middle[0]:.0f}, "
        f"way {middle[1]:.0f}, all {middle[2]:.0f} ms (95 %: {np.quantile(table[:, 2], 0.95):.0f}); length of the way "
        f"{middle[3]:.4f}, of the trajectory {middle[4]:.4f} of the optimum (worst {table[:, 4].max():.3f}); "
        f"least clearance {least[5]:.3f} m; {middle[6]:.2f} m/s on average"
    )


def sampled(density: float, maps: int) -> None:
    """Print what the planners of the Open Motion Planning Library give at a density."""
    from crosstrack.search.sampled import PLANNERS, sampled_way

    worlds = [(world, best) for world, best in with_optimum(density, maps) if best is not None]
    for name in PLANNERS:
        times, ratios = [], []
        for world, best in worlds:
            box = room(world, RADIUS)
            try:
                way, took = timed(partial(sampled_way, world, ENDS[0], ENDS[1], CLEARANCE, box, name, CHECKS))
            except Unreachable:
                continue
            times.append(took)
            ratios.append(length(way) / best)
        middle = f"{statistics.median(times):.0f} ms, length {statistics.median(ratios):.4f}" if times else "no times"
        print(f"{density:.1f} trees/m², {name}, {CHECKS} checks: {len(times)} of {len(worlds)}; {middle}")


def with_optimum(density: float, maps: int) -> Iterator[tuple[World, float | None]]:
    """Yield forests and the length of their shortest ways (m), None where there is none."""
    for seed in range(maps):
        world = forest(seed, density)
        best = optimum(world, ENDS[0], ENDS[1], CLEARANCE)
        yield world, None if best is None else best.length


def main() -> None:
    maps = int(sys.argv[1]) if len(sys.argv) > 1 else 50
    Auto().curve(PlanningTask(ENDS, SPEED, 1.0, ENVELOPE, forest(1000, 0.4), RADIUS), np.inf)  # compiles
    for density in (0.1, 0.2, 0.3, 0.4):
        planned(density, maps)
    if find_spec("ompl"):
        for density in (0.2, 0.4):
            sampled(density, min(maps, 10))


if __name__ == "__main__":
    main()
