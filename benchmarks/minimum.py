"""Time of the closed form, per segment, beside peers that find the same curve, in the same run.

Run as `python -m benchmarks.minimum`. Speeds drift, so the cases take turns, and ratios are those of a turn. Peers that
are not installed are left out: `pip install minsnap-trajectories drake`.
"""

import statistics
import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from crosstrack.trajectory.banded import COLUMNS, GUIDES, kernel
from crosstrack.trajectory.batch import minimum_batch
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.types import Array

ROUNDS = 11
BATCH = 20_000


def problem(segments: int) -> tuple[Array, Array]:
    """Return waypoints of a random walk and times."""
    rng = np.random.default_rng(segments)
    waypoints = np.cumsum(rng.normal(size=(segments + 1, 3)), axis=0)
    return waypoints, np.cumsum(np.r_[0.0, rng.uniform(0.5, 2, segments)])


def compiled_call(segments: int, s: int, guided: bool) -> Callable[[], object]:
    """Return a call of the kernel alone; its inputs are made anew outside of what is timed."""
    waypoints, times = problem(segments)
    knots = np.full((segments + 1, s, COLUMNS), np.nan)
    knots[:, 0], knots[[0, -1], 1:] = waypoints - waypoints[0], 0.0
    weights = np.full((segments, GUIDES), [1.0, 0.0, 0.0]) if guided else np.empty((0, GUIDES))
    loads, coefficients = np.zeros((len(weights), 2 * s, COLUMNS)), np.empty((segments, 2 * s, COLUMNS))
    durations, least, solve, given = np.diff(times), np.empty(1), kernel(s), knots.copy()

    def call() -> None:
        solve(durations, knots, weights, loads, coefficients, least)

    call.reset = lambda: knots.__setitem__(slice(None), given)  # type: ignore[attr-defined] # the input is also output
    return call


def timed(call: Callable[[], object]) -> float:
    """Return the seconds of one call, the best of a few that take a few milliseconds together."""
    reset = getattr(call, "reset", lambda: None)
    best, spent = float("inf"), 0.0
    while spent < 4e-3:
        reset()
        start = time.perf_counter()
        call()
        took = time.perf_counter() - start
        best, spent = min(best, took), spent + took
    return best


def scipy_spline(segments: int, s: int) -> Callable[[], object]:
    """Return the interpolating spline of degree 2 s - 1, clamped at both ends: the same curve (Schoenberg 1964)."""
    waypoints, times = problem(segments)
    rest = [(order, np.zeros(3)) for order in range(1, s)]
    return lambda: make_interp_spline(times, waypoints, k=2 * s - 1, bc_type=(rest, rest))


def minsnap(segments: int, s: int) -> Callable[[], object]:
    """Return the closed form of minsnap-trajectories."""
    import minsnap_trajectories as peer

    waypoints, times = problem(segments)
    rest = {name: np.zeros(3) for name in ("velocity", "acceleration", "jerk")[: s - 1]}
    inner = [peer.Waypoint(time=t, position=p) for t, p in zip(times[1:-1], waypoints[1:-1], strict=True)]
    ends = [peer.Waypoint(time=times[k], position=waypoints[k], **rest) for k in (0, -1)]
    references = [ends[0], *inner, ends[1]]
    return lambda: peer.generate_trajectory(
        references,
        degree=2 * s - 1,
        idx_minimized_orders=s,
        num_continuous_orders=s,
        algorithm="closed-form",
    )


def drake_cubic(segments: int) -> Callable[[], object]:
    """Return Drake's cubic spline, the curve of minimum acceleration."""
    from pydrake.trajectories import PiecewisePolynomial

    waypoints, times = problem(segments)
    columns, rest = np.ascontiguousarray(waypoints.T), np.zeros(3)
    make: Any = PiecewisePolynomial.CubicWithContinuousSecondDerivatives
    return lambda: make(times, columns, rest, rest)


def report(title: str, cases: dict[str, Callable[[], object]], segments: int) -> None:
    """Time cases in turns and print the time of each with the spread, and its ratio to the first."""
    for case in cases.values():
        case()
    rounds = [{name: timed(case) for name, case in cases.items()} for _ in range(ROUNDS)]
    first = next(iter(cases))
    print(f"\n{title}")
    for name in cases:
        values = sorted(row[name] for row in rounds)
        ratios = sorted(row[name] / row[first] for row in rounds)
        middle = statistics.median(values)
        print(
            f"  {name:<42}{middle * 1e6:10.1f} µs ({values[0] * 1e6:.1f} to {values[-1] * 1e6:.1f})"
            f"{middle / segments * 1e9:10.0f} ns a segment"
            f"{statistics.median(ratios):10.1f} times ({ratios[0]:.1f} to {ratios[-1]:.1f})"
        )


def main() -> None:
    peers = {name: find_spec(name) is not None for name in ("minsnap_trajectories", "pydrake")}
    for name, found in peers.items():
        if not found:
            print(f"{name} is not installed: left out")
    for s, what in ((2, "acceleration"), (3, "jerk"), (4, "snap")):
        for segments in (4, 10, 100, 1000):
            waypoints, times = problem(segments)
            cases: dict[str, Callable[[], object]] = {
                "compiled call": compiled_call(segments, s, guided=False),
                "compiled call, guided": compiled_call(segments, s, guided=True),
                "minimum()": partial(minimum, waypoints, times, s),
                "scipy make_interp_spline": scipy_spline(segments, s),
            }
            if peers["minsnap_trajectories"] and s > 2 and segments <= 10:
                cases["minsnap-trajectories, closed form"] = minsnap(segments, s)
            if peers["pydrake"] and s == 2:
                cases["drake cubic spline"] = drake_cubic(segments)
            report(f"minimum {what}, {segments} segments, 3-D, one thread", cases, segments)
    for s, what in ((3, "jerk"), (4, "snap")):
        batch(s, what)


def batch(s: int, what: str) -> None:
    """Time many ten-segment trajectories in one call of the kernel, and in one of `minimum_batch`."""
    rng = np.random.default_rng(0)
    waypoints = np.cumsum(rng.normal(size=(BATCH, 11, 3)), axis=1)
    times = np.cumsum(np.c_[np.zeros(BATCH), rng.uniform(0.5, 2, (BATCH, 10))], axis=1)
    knots = np.full((BATCH, 11, s, COLUMNS), np.nan)
    knots[:, :, 0], knots[:, [0, -1], 1:] = waypoints, 0.0
    durations, least = np.diff(times, axis=1).ravel(), np.empty(BATCH)
    nothing = np.empty((0, GUIDES)), np.empty((0, 2 * s, COLUMNS))
    out, solve = np.empty((BATCH * 10, 2 * s, COLUMNS)), kernel(s)
    speeds = []
    for _ in range(ROUNDS):
        fresh = knots.reshape(-1, s, COLUMNS).copy()
        start = time.perf_counter()
        solve(durations, fresh, *nothing, out, least)
        middle = time.perf_counter()
        minimum_batch(waypoints, times, s)
        speeds.append((BATCH / (middle - start) / 1e6, BATCH / (time.perf_counter() - middle) / 1e6))
    print(f"\nminimum {what}, {BATCH} trajectories of 10 segments, 3-D, one thread")
    for name, column in zip(("compiled call", "minimum_batch()"), zip(*speeds, strict=True), strict=True):
        print(f"  {name:<42}{statistics.median(column):6.2f} million a second ({min(column):.2f} to {max(column):.2f})")


if __name__ == "__main__":
    main()
