"""Quadrotors that swap places across a circle of 10 m at one height, flown; beside RVO2, where it is installed.

Run as `python -m benchmarks.swarm [counts ...]`. The points of RVO2 (package `rvo2`) change their velocity at once:
they have it easier. A separation is over the sum of the radii, swept between samples; a time over the straight one.
"""

import importlib
import math
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

import crosstrack as ct
from crosstrack.avoid.orca_choice import choose
from crosstrack.flight.separation import nearest
from crosstrack.types import Array, Outcome

CIRCLE, RADIUS, CRUISE, ACCELERATION, PERIOD = 10.0, 0.2, 2.0, 8.0, 0.02
STRAIGHT = 2 * CIRCLE / CRUISE + CRUISE / ACCELERATION
"""s"""
LONGEST = 4 * STRAIGHT


@dataclass(frozen=True)
class Swap:
    """What became of one swap."""

    arrived: int
    time: float
    """s, until the last has arrived"""
    separation: float
    """m, least between two centres"""
    height: float
    """m, farthest from the common height"""
    wall: float
    """s, of the machine"""


def places(count: int) -> Array:
    angles = 2 * math.pi * np.arange(count) / count
    return CIRCLE * np.column_stack([np.cos(angles), np.sin(angles)])


def flown(count: int) -> Swap:
    """Fly the mission."""
    vehicles = [
        {"name": f"v{k}", "start": {"position": [x, y, 3.0]}, "route": [[-x, -y, 3.0]]}
        for k, (x, y) in enumerate(places(count).tolist())
    ]
    document = {"vehicles": vehicles, "speed": CRUISE, "avoid": [{"kind": "orca"}], "timing": {"timeout": LONGEST}}
    began = time.perf_counter()
    flights = ct.fly_together(ct.from_document(document))
    return Swap(
        sum(flight.outcome is Outcome.ARRIVED for flight in flights),
        max(float(flight.record.time[-1]) for flight in flights),
        min(float(np.min(flight.record.separation)) for flight in flights),
        max(float(np.abs(flight.record.position[:, 2] - 3.0).max()) for flight in flights),
        time.perf_counter() - began,
    )


def peer(count: int, rvo2: Any) -> Swap:
    """Have RVO2 swap points, with the parameters of its own circle example scaled to these radii."""
    simulator = rvo2.PyRVOSimulator(PERIOD, 15 * RADIUS, 10, 5.0, 5.0, RADIUS, CRUISE)
    start = places(count)
    for x, y in start.tolist():
        simulator.addAgent((x, y))
    began, least, arrived, steps = time.perf_counter(), math.inf, 0, 0
    before, radii = np.column_stack([start, np.zeros(count)]), np.full(count, RADIUS)
    while arrived < count and steps * PERIOD < LONGEST:
        for k in range(count):
            way = -start[k] - np.array(simulator.getAgentPosition(k))
            distance = float(np.linalg.norm(way))
            velocity = way * min(1 / PERIOD, CRUISE / max(distance, 1e-9))
            simulator.setAgentPrefVelocity(k, tuple(velocity.tolist()))
        simulator.doStep()
        steps += 1
        now = np.array([[*simulator.getAgentPosition(k), 0.0] for k in range(count)])
        least = min(least, float(nearest(before, now, radii)[0].min()))
        arrived, before = int((np.linalg.norm(now[:, :2] + start, axis=1) <= 0.2).sum()), now
    return Swap(arrived, steps * PERIOD, least, 0.0, time.perf_counter() - began)


def decision(count: int, calls: int = 2000) -> float:
    """Return what one decision among `count` vehicles on a disc takes, in microseconds: the median of calls."""
    rng = np.random.default_rng(0)
    others = np.column_stack([rng.uniform(-5, 5, (count - 1, 2)), np.zeros(count - 1)])
    others = others[np.linalg.norm(others, axis=1) > 2 * RADIUS]
    motion = np.column_stack([rng.uniform(-1, 1, (len(others), 2)), np.zeros(len(others))])
    around = (np.empty((0, 4)), others, motion, np.full(len(others), RADIUS), np.ones(len(others), dtype=bool))
    rule, velocity, taken = (RADIUS, 0.1, 2.0, CRUISE, 0.0), np.array([1.0, 0, 0]), []
    for _ in range(calls):
        began = time.perf_counter()
        choose(np.zeros(3), velocity, np.array([CRUISE, 0, 0]), (0.0, 1.0, 0.0), *around, rule, PERIOD)
        taken.append(time.perf_counter() - began)
    return 1e6 * float(np.median(taken))


def show(name: str, count: int, swap: Swap) -> None:
    print(
        f"{name:10} {count:4} {swap.arrived:4} arrived {swap.time / STRAIGHT:6.2f} of the straight time, "
        f"separation {swap.separation / (2 * RADIUS):6.3f}, height {swap.height:6.3f} m, {swap.wall:6.1f} s",
        flush=True,
    )


def main() -> None:
    counts = [int(word) for word in sys.argv[1:]] or [8, 20, 50, 100]
    for count in counts:
        print(f"one decision among {count}: {decision(count):.1f} µs", flush=True)
    try:
        rvo2 = importlib.import_module("rvo2")
    except ImportError:
        rvo2 = None
        print("rvo2 is not installed")
    for count in counts:
        show("orca", count, flown(count))
        if rvo2 is not None:
            show("RVO2", count, peer(count, rvo2))


if __name__ == "__main__":
    main()
