"""One decision, from the scan to the command: `python -m benchmarks.decision`.

A lidar of 16 x 900 beams flies at 3 m/s through forests of 40 x 20 x 3 m that it was not told of. Each decision takes a
scan into the local map, deflects the velocity asked for by the potential field, and has the safety layer check it.
Times are processor time of the thread; the scan itself is not in them.
"""

import time
from typing import Any

import numpy as np

from crosstrack.avoid.potential import Potential
from crosstrack.avoid.safety import Safety
from crosstrack.path.pace import course_of
from crosstrack.protocols import Scenario, Surroundings
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.local_map import LocalMap
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.types import Air, Array, Limits, Noise, Setpoint, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.generate import Forest
from crosstrack.world.world import World

LIDAR = Lidar(rings=16, columns=900)
START, GOAL, CRUISE, PERIOD = np.array([2.0, 10.0, 1.5]), np.array([38.0, 10.0, 1.5]), 3.0, 0.1
DENSITIES = (0.1, 0.2, 0.4)
SEEDS = 3
UNTIMED = 5
"""decisions at the beginning of each flight, which compile what they need and fill the memory"""
PARTS = ("map", "potential", "safety", "together")


def decisions(density: float, seed: int) -> Array:
    """Fly through one forest; return what its decisions took, (n, 4) ms, in `PARTS`."""
    trees = Forest(seed=seed, density=density, radius=(0.2, 0.5), clear=((2.0, 10.0), (38.0, 10.0))).shapes()
    world, bare = World(tuple(trees)), World()
    scenario = Scenario(START, 0.0, world, CRUISE, Limits(), Wind(), Air(), Noise(), PERIOD, seed, sensors=(LIDAR,))
    vehicle = Quadrotor()
    session, local = vehicle.launch(scenario), LocalMap.around((LIDAR,), bare)
    straight = minimum(np.array([START, GOAL]), np.array([0.0, float(np.linalg.norm(GOAL - START)) / CRUISE]), 3)
    course = course_of(straight, vehicle.envelope(scenario))
    laws: tuple[Any, ...] = (Potential(), Safety())
    known = Surroundings(local)
    memories = [law.start(course, known, session.sense()) for law in laws]
    random, rows = np.random.default_rng(seed), []
    for _ in range(150):
        state = session.sense()
        scan = LIDAR.look(world, session.truth(), random)
        ahead = GOAL - state.position
        command = Setpoint(velocity=ahead * (CRUISE / max(CRUISE, float(np.linalg.norm(ahead)))))
        ticks = [time.thread_time()]
        local.add(scan, state)
        ticks.append(time.thread_time())
        around = Surroundings(local, scans=(scan,))
        for k, law in enumerate(laws):
            command, memories[k] = law.step(memories[k], command, state, around, PERIOD)
            ticks.append(time.thread_time())
        rows.append([*np.diff(ticks), ticks[-1] - ticks[0]])
        for _ in range(5):
            session.advance(command, PERIOD / 5)
        if float(np.linalg.norm(ahead)) < 0.5:
            break
    return 1e3 * np.array(rows[UNTIMED:])


def main() -> None:
    """Print median, 99th percentile and maximum of each part, at each density."""
    decisions(0.2, SEEDS)
    print(f"{'trees per m²':>12}  {'part':>9}  {'median':>8}  {'99 %':>8}  {'most':>8}   ms")
    for density in DENSITIES:
        taken = np.concatenate([decisions(density, seed) for seed in range(SEEDS)])
        for part, column in zip(PARTS, taken.T, strict=True):
            middle, high = np.quantile(column, [0.5, 0.99])
            print(f"{density:12.1f}  {part:>9}  {middle:8.3f}  {high:8.3f}  {column.max():8.3f}")


if __name__ == "__main__":
    main()
