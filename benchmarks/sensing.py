"""Scans, the local map that takes them in, and what it answers: `python -m benchmarks.sensing`.

A lidar of 16 x 900 beams flies 6 m through forests of 40 x 20 x 3 m with trunks of 0.2 to 0.5 m. MuJoCo casts the same
rays against the same trunks, and scipy's k-d tree searches the same points, each between two of our calls. Times are
processor time of the thread, medians with the spread from a tenth to nine tenths of the calls; ratios are of calls next
to each other.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import mujoco
import numpy as np
from scipy.spatial import cKDTree

from crosstrack.sense.lidar import Lidar
from crosstrack.sense.local_map import LocalMap
from crosstrack.types import Array, State
from crosstrack.world.generate import Forest
from crosstrack.world.shapes import Cylinder
from crosstrack.world.world import World

LIDAR = Lidar(rings=16, columns=900)
SCANS = 60
DENSITIES = (0.1, 0.2, 0.4)


def milliseconds(call: Callable[[], object]) -> float:
    start = time.thread_time()
    call()
    return 1e3 * (time.thread_time() - start)


def spread(values: list[float], unit: str = "") -> str:
    low, middle, high = np.quantile(values, [0.1, 0.5, 0.9])
    return f"{middle:8.3g}{unit} ({low:.3g} to {high:.3g})"


def peer(world: World) -> tuple[Any, Any]:
    """Return the trunks as MuJoCo holds them."""
    geoms = []
    for shape in world.shapes:
        assert isinstance(shape, Cylinder)
        (x, y), radius, (low, high) = shape.center, shape.radius, shape.z
        size, middle = f"{radius} {(high - low) / 2}", f"{x} {y} {(high + low) / 2}"
        geoms.append(f'<geom type="cylinder" size="{size}" pos="{middle}"/>')
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{''.join(geoms)}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def peer_cast(model: Any, data: Any, origin: Array, rays: Array) -> Array:
    names, ranges = np.empty(len(rays), np.int32), np.empty(len(rays))
    mujoco.mj_multiRay(model, data, origin, rays.ravel(), None, 1, -1, names, ranges, None, len(rays), LIDAR.range)
    return ranges


def states() -> list[State]:
    made = []
    for i in range(SCANS):
        yaw = 0.3 * np.sin(0.2 * i)
        attitude = np.array([0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        made.append(State(0.1 * i, np.array([17 + 0.1 * i, 10, 1.5]), np.zeros(3), attitude, np.zeros(3)))
    return made


def scans(density: float) -> LocalMap:
    """Print what scans of a forest cost, and return the map made of them."""
    corridor = tuple((x, 10.0) for x in np.arange(16.0, 25.0, 1.0).tolist())
    forest = Forest(seed=1, size=(40, 20, 3), density=density, radius=(0.2, 0.5), clear=corridor, clear_radius=1.0)
    world, random = World(forest.shapes()), np.random.default_rng(0)
    model, data = peer(world)
    local = LocalMap.around([LIDAR], World())
    rays, looks, adds, ratios, wrong = [], [], [], [], 0.0
    for state in states():
        mine: list[Any] = []
        theirs: list[Any] = []
        cast = partial(world.cast, state.position, LIDAR.directions, LIDAR.range)
        rays.append(milliseconds(lambda: mine.append(cast())))  # noqa: B023 - called at once
        peers = milliseconds(lambda: theirs.append(peer_cast(model, data, state.position, LIDAR.directions)))  # noqa: B023
        ratios.append(rays[-1] / peers)
        hit = np.isfinite(mine[0])
        wrong = max(wrong, float(np.abs(mine[0] - theirs[0])[hit].max()))
        looks.append(milliseconds(lambda: mine.append(LIDAR.look(world, state, random))))  # noqa: B023
        adds.append(milliseconds(partial(local.add, mine[1], state)))
    count = f"{len(world.shapes)} trunks, {len(local.points)} points"
    print(f"density {density}: {count}; ranges differ from MuJoCo's by at most {wrong:.1g} m")
    print(f"  rays            {spread(rays[2:], ' ms')}   to MuJoCo {spread(ratios[2:])}")
    print(f"  a scan, in all  {spread(looks[2:], ' ms')}   into the map {spread(adds[2:], ' ms')}")
    return local


def answers(local: LocalMap) -> None:
    """Print what questions to a map cost."""
    random = np.random.default_rng(1)
    tree = cKDTree(local.points)
    asked = random.uniform([15, 5, 0.5], [25, 15, 2.5], size=(1000, 3))
    ends = asked + random.uniform([2, -1, -0.3], [3, 1, 0.3], size=asked.shape)
    local.distance(asked), local.swept(asked[0], ends[0])
    points, ratios = [], []
    for _ in range(20):
        points.append(milliseconds(partial(local.distance, asked)))
        ratios.append(points[-1] / milliseconds(partial(tree.query, asked)))
    print(f"  distance        {spread(points, ' µs')}   to a k-d tree {spread(ratios)}")
    swept = [1e3 * milliseconds(partial(local.swept, a, b)) for a, b in zip(asked, ends, strict=True)]
    print(f"  swept 2 to 3 m  {spread(swept, ' µs')}")
    for reach in (0.25, 0.4, 0.8):
        ask = partial(local.field, np.array([8.0, 0.0, 0.0]), 0.144, (167, 140, 21), reach)
        ask()
        times = spread([milliseconds(ask) for _ in range(7)], " ms")
        print(f"  field to {reach:4} m {times}   of 24 x 20 x 3 m at 0.144 m")


def main() -> None:
    for density in DENSITIES:
        answers(scans(density))


if __name__ == "__main__":
    main()
