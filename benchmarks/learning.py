"""Decisions a second of the environments to learn in, on one core, beside a bare body in MuJoCo, in the same run.

Run as `python benchmarks/learning.py`. Speeds drift, so the cases take turns, and ratios are those of a turn. A
decision is 50 ms in ten steps of the rotors; for MuJoCo, ten steps of one vehicle without autopilot.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np
from kernel import oracle

from crosstrack.learn.avoid import Avoid
from crosstrack.learn.follow import Follow
from crosstrack.learn.hover import Hover
from crosstrack.learn.vector import STEP, Vector
from crosstrack.policy.action import SIZES

ROUNDS = 9
VEHICLES = 1024
DECISION = 0.05
"""s"""
STEPS = 10


def environment(vector: Vector, calls: int = 40) -> Callable[[], float]:
    """Return a round of `calls` decisions of all vehicles that answers with decisions a second."""
    vector.reset(seed=0)
    rng = np.random.default_rng(0)
    middle = np.zeros(SIZES[vector.task.action])
    if vector.task.name != "hover":
        middle[0] = 0.7
    actions = [middle + rng.normal(0, 0.2, (vector.num_envs, len(middle))) for _ in range(calls)]
    for action in actions * 3:
        vector.step(action)

    def run() -> float:
        start = time.perf_counter()
        for action in actions:
            vector.step(action)
        return vector.num_envs * calls / (time.perf_counter() - start)

    return run


def main() -> None:
    steps = oracle(600)
    cases = {
        "MuJoCo, one body": lambda: steps() / STEPS,
        f"avoid, {VEHICLES}, 32 rays": environment(Vector(Avoid(), VEHICLES)),
        f"follow, {VEHICLES}, no rays": environment(Vector(Follow(), VEHICLES)),
        f"hover, {VEHICLES}, no rays": environment(Vector(Hover(), VEHICLES)),
        "avoid, 1, 32 rays": environment(Vector(Avoid(maps=16), 1), 2000),
    }
    rounds = [{name: run() for name, run in cases.items()} for _ in range(ROUNDS)]
    base, *_ = cases
    print(f"decisions of {DECISION} s in {STEPS} steps of {STEP} s")
    print(f"{'':26} {'decisions/s':>12} {'least':>9} {'most':>9} {'to MuJoCo: median':>18} {'least':>7} {'most':>7}")
    for name in cases:
        speeds = [one[name] for one in rounds]
        ratios = [one[name] / one[base] for one in rounds]
        print(
            f"{name:26} {statistics.median(speeds):12,.0f} {min(speeds):9,.0f} {max(speeds):9,.0f} "
            f"{statistics.median(ratios):18.1f} {min(ratios):7.1f} {max(ratios):7.1f}"
        )


if __name__ == "__main__":
    main()
