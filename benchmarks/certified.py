"""Time of certified extremes for a segment and quantity, in random smooth curves through many points.

Run as `python -m benchmarks.certified`. Speeds drift, so the cases take turns.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np

from crosstrack.trajectory.certified.clearance import least_clearance
from crosstrack.trajectory.certified.extremes import axis_range, largest_norm
from crosstrack.trajectory.certified.polyline_distance import deviation_peaks, largest_deviation
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

ROUNDS = 15
SIZES = (4, 10, 100, 1000, 10_000)


def curve_through(count: int) -> tuple[PiecewisePolynomial, Array]:
    """Return a C3 curve of degree 7 through corners 5 m apart, and the corners."""
    rng = np.random.default_rng(count)
    steps = rng.normal(size=(count, 3))
    corners = np.concatenate([np.zeros((1, 3)), np.cumsum(5 * steps / np.linalg.norm(steps, axis=1)[:, None], axis=0)])
    states = np.concatenate([corners[:, None], rng.normal(size=(count + 1, 3, 3)) * [[3.0], [2.0], [3.0]]], axis=1)
    durations = rng.uniform(1, 3, count)
    powers = np.arange(8)
    rows = np.array([[np.prod(powers[j] - np.arange(k)) for j in powers] for k in range(4)])
    ends = np.where(powers >= np.arange(4)[:, None], 1.0, 0.0) * rows
    system = np.concatenate([np.diag([1.0, 1, 2, 6, 0, 0, 0, 0])[:4], ends])
    scale = durations[:, None, None] ** np.arange(4)[:, None]
    sides = np.concatenate([states[:-1] * scale, states[1:] * scale], axis=1)
    unit = np.linalg.solve(np.broadcast_to(system, (count, 8, 8)), sides)
    return PiecewisePolynomial(durations, unit / durations[:, None, None] ** powers[:, None]), corners


def timed(call: Callable[[], object], quantities: int, count: int) -> Callable[[], float]:
    """Return a round that answers with µs per segment and quantity."""
    call()
    repeats = max(1, 200 // count)

    def run() -> float:
        start = time.perf_counter()
        for _ in range(repeats):
            call()
        return (time.perf_counter() - start) / repeats / quantities / count * 1e6

    return run


def rounds(count: int) -> dict[str, Callable[[], float]]:
    """Return what is timed for a number of segments."""
    curve, corners = curve_through(count)
    low, high = corners.min(axis=0) - 20, corners.max(axis=0) + 20
    world = World((Box((low[0], low[1], low[2]), (high[0], high[1], low[2] + 1)),))
    return {
        "largest speed": timed(lambda: largest_norm(curve, 1), 1, count),
        "largest acceleration": timed(lambda: largest_norm(curve, 2), 1, count),
        "largest jerk": timed(lambda: largest_norm(curve, 3), 1, count),
        "range of an axis": timed(lambda: axis_range(curve, 1), 3, count),
        "deviation from chords": timed(lambda: deviation_peaks(curve, corners), 1, count),
        "deviation from route": timed(lambda: largest_deviation(curve, corners), 1, count),
        "clearance, one box": timed(lambda: least_clearance(curve, world), 1, count),
    }


def main() -> None:
    print(f"{'µs a segment and quantity':26}" + "".join(f"{f'{count} segments':>22}" for count in SIZES))
    cases = {count: rounds(count) for count in SIZES}
    taken = [{(count, name): run() for count in SIZES for name, run in cases[count].items()} for _ in range(ROUNDS)]
    for name in cases[SIZES[0]]:
        line = f"{name:26}"
        for count in SIZES:
            times = sorted(one[count, name] for one in taken)
            line += f"{f'{statistics.median(times):.2f} ({times[0]:.2f}-{times[-1]:.2f})':>22}"
        print(line)


if __name__ == "__main__":
    main()
