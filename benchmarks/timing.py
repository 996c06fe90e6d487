"""Time allocation: effort against the trapezoid's, time under limits, and how long it takes to find them.

Run as `python -m benchmarks.timing`. Routes are 9 points uniform in a 20 m cube, seeds 0-29; limits 4 m/s and 5 m/s².
The peer toppra, where installed, flies the geometry of our fastest trajectory in the least time, with the limits on
each axis alone, which is looser, and jumps of acceleration: a bound on what smoothness costs.
"""

import statistics
import time
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.fastest import fastest
from crosstrack.trajectory.times.optimal import least_effort
from crosstrack.trajectory.times.timing import constant_speed, rescaled, square_root, trapezoid
from crosstrack.types import Array

SEEDS = 30
ROUNDS = 7
LIMITS = MotionLimits(speed=4.0, acceleration=5.0)
ALLOCATIONS: dict[str, Callable[[Array, MotionLimits], Array]] = {
    "constant speed": constant_speed,
    "square root": square_root,
    "trapezoid": trapezoid,
}


def routes() -> list[Array]:
    return [np.random.default_rng(seed).uniform(0, 20, (9, 3)) for seed in range(SEEDS)]


def through(route: Array, durations: Array, s: int) -> PiecewisePolynomial:
    return minimum(route, np.concatenate([[0.0], np.cumsum(durations)]), s)


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """Return what a call returns, and the least time it took of some calls, ms."""
    spent = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        found = call()
        spent.append(time.perf_counter() - start)
    return found, 1e3 * min(spent)


def spread(values: list[float], unit: str = "") -> str:
    return f"{statistics.median(values):9.3g}{unit} ({min(values):.3g} to {max(values):.3g})"


def efforts(s: int) -> None:
    """Print the least effort in the trapezoid's time relative to the trapezoid's."""
    ratios, spent, steps, converged = [], [], [], 0
    for route in routes():
        durations = trapezoid(route, LIMITS)
        total = float(durations.sum())
        found, took = timed(partial(least_effort, route, total, s))
        ratios.append(found.objective / through(route, durations, s).cost(s))
        spent.append(took)
        steps.append(float(found.iterations))
        converged += found.converged
    print(f"s = {s}  effort to trapezoid's {spread(ratios)}   {spread(spent, ' ms')}   Newton steps {spread(steps)}")
    print(f"       converged {converged} of {SEEDS}")


def durations(s: int) -> None:
    """Print the time under limits relative to the fastest found."""
    found, spent = [], []
    for route in routes():
        result, took = timed(partial(fastest, route, LIMITS, s))
        found.append(result.curve)
        spent.append(took)
    print(f"s = {s}  fastest {spread([curve.duration for curve in found], ' s')}   {spread(spent, ' ms')}")
    for name, allocation in ALLOCATIONS.items():
        others = [rescaled(through(route, allocation(route, LIMITS), s), LIMITS).duration for route in routes()]
        print(f"       {name:15} to it {spread([a / b.duration for a, b in zip(others, found, strict=True)])}")
    others = [rescaled(least_effort(route, 30.0, s).curve, LIMITS).duration for route in routes()]
    print(f"       {'least effort':15} to it {spread([a / b.duration for a, b in zip(others, found, strict=True)])}")
    try:
        peers = [toppra_time(curve) for curve in found[:10]]
    except ImportError:
        print("       toppra is not installed: left out")
        return
    ratios = [a / b.duration for a, b in zip(peers, found, strict=False)]
    print(f"       {'toppra':15} to it {spread(ratios)}  (same geometry, no jerk, first {len(ratios)} routes)")


def toppra_time(curve: PiecewisePolynomial) -> float:
    """Return the time toppra needs along the same geometry, with the limits on each axis."""
    toppra, algorithm, constraint = map(import_module, ("toppra", "toppra.algorithm", "toppra.constraint"))
    toppra.setup_logging("ERROR")
    points = curve(np.linspace(0, curve.duration, 4001))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    stations = np.linspace(0, along[-1], 401)
    path = toppra.SplineInterpolator(stations, np.array([np.interp(stations, along, axis) for axis in points.T]).T)
    box = [
        constraint.JointVelocityConstraint(np.full((3, 2), LIMITS.speed) * [-1, 1]),
        constraint.JointAccelerationConstraint(np.full((3, 2), LIMITS.acceleration) * [-1, 1]),
    ]
    return float(algorithm.TOPPRA(box, path, parametrizer="ParametrizeConstAccel").compute_trajectory(0, 0).duration)


def main() -> None:
    for s in (3, 4):
        efforts(s)
    for s in (3, 4):
        durations(s)


if __name__ == "__main__":
    main()
