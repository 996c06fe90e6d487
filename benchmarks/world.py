"""Time distance, gradient and swept clearance: `python benchmarks/world.py`."""

from collections.abc import Callable
from time import perf_counter

import numpy as np

from crosstrack.world.cloud import voxelise
from crosstrack.world.generate import City, Forest
from crosstrack.world.grids import Relief
from crosstrack.world.world import World


def microseconds(call: Callable[[int], object], count: int) -> float:
    call(0)
    start = perf_counter()
    for i in range(count):
        call(i)
    return (perf_counter() - start) / count * 1e6


def main() -> None:
    rng = np.random.default_rng(0)
    walls = rng.uniform(size=(400, 200)) < 0.01
    worlds = {
        "empty": World(),
        "forest of 400": World(Forest(seed=1, size=(50, 40, 10), density=0.2).shapes()),
        "forest of 10,000": World(Forest(seed=1, size=(250, 200, 10), density=0.2).shapes()),
        "city of 64": World(City(seed=1, size=(200, 200, 40)).shapes()),
        "image of 400 x 200": World(grids=(Relief(walls, (0.0, 0.0), 0.125, (0.0, 10.0)),)),
        "cloud of 1,000,000": World(grids=(voxelise("cloud", rng.uniform(0, 40, size=(1_000_000, 3)) ** 2 / 40, 0.3),)),
    }
    print(f"{'µs a call':20}{'point':>8}{'gradient':>10}{'swept 0.1 m':>13}{'swept 20 m':>12}{'points, each':>14}")
    for name, world in worlds.items():
        points = rng.uniform([0, 0, 0], [50, 40, 12], size=(20_000, 3))
        direction = rng.normal(size=points.shape)
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        near, far = points + 0.1 * direction, points + 20 * direction
        cells = [
            microseconds(lambda i: world.distance(points[i]), 2000),  # noqa: B023 - called within the turn
            microseconds(lambda i: world.gradient(points[i]), 2000),  # noqa: B023
            microseconds(lambda i: world.swept(points[i], near[i]), 20_000 - 1),  # noqa: B023
            microseconds(lambda i: world.swept(points[i], far[i]), 2000),  # noqa: B023
            microseconds(lambda _: world.distance(points), 3) / len(points),  # noqa: B023
        ]
        print(f"{name:20}{cells[0]:8.2f}{cells[1]:10.2f}{cells[2]:13.2f}{cells[3]:12.2f}{cells[4]:14.3f}")


if __name__ == "__main__":
    main()
