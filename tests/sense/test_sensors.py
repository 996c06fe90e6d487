"""What every registered sensor must do."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from crosstrack import registry
from crosstrack.protocols import Map
from crosstrack.types import Array, State
from crosstrack.world.generate import Forest
from crosstrack.world.shapes import Box, Sphere
from crosstrack.world.world import World

MOUNTS: list[dict[str, Any]] = [{}, {"position": (0.3, -0.1, 0.2)}, {"yaw_deg": 70.0, "pitch_deg": -25.0}]
SENSORS = [(name, mount) for name in registry.names("sensor") for mount in MOUNTS]
WORLD = World(
    (*Forest(seed=5, size=(16, 16, 4), density=0.15).shapes(), Sphere((8, 9, 5), 1), Box((3, 3, 0), (5, 4, 6)))
)


def turned(attitude: Array, vectors: Array) -> Array:
    """Turn vectors by a quaternion: the sandwich product q v q*."""
    u, w = attitude[:3], attitude[3]
    rotated: Array = vectors + 2 * w * np.cross(u, vectors) + 2 * np.cross(u, np.cross(u, vectors))
    return rotated


def somewhere(seed: int, world: Map = WORLD) -> State:
    rng = np.random.default_rng(seed)
    position = rng.uniform([1, 1, 1], [15, 15, 3])
    while world.distance(position) < 0.5:
        position = rng.uniform([1, 1, 1], [15, 15, 3])
    attitude = rng.normal(size=4)
    return State(1.5, position, np.zeros(3), attitude / np.linalg.norm(attitude), np.zeros(3))


def level(x: float, y: float, z: float) -> State:
    return State(0.0, np.array([x, y, z]), np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))


@pytest.mark.parametrize(("kind", "options"), SENSORS)
class TestSensor:
    def test_ranges_end_on_the_first_surface(self, kind: str, options: dict[str, Any]) -> None:
        sensor = registry.find("sensor", kind)(**{**options, "noise": 0.0})
        for seed in range(4):
            state = somewhere(seed)
            scan = sensor.look(WORLD, state, np.random.default_rng(0))
            origin = state.position + turned(state.attitude, scan.origin[None])[0]
            if WORLD.distance(origin) <= 0 or origin[2] <= 0:
                continue
            ends = origin + np.minimum(scan.ranges, scan.max_range)[:, None] * turned(state.attitude, scan.directions)
            hit = np.isfinite(scan.ranges)
            surface = np.minimum(np.abs(WORLD.distance(ends)), np.abs(ends[:, 2]))
            assert surface[hit].max(initial=0.0) < 1e-6
            assert ends[:, 2].min() > -1e-9
            step = max(1, len(ends) // 300)
            assert min(WORLD.swept(origin, end) for end in ends[::step]) > -1e-6

    def test_scans_share_their_directions(self, kind: str, options: dict[str, Any]) -> None:
        sensor = registry.find("sensor", kind)(**options)
        one, two = (sensor.look(WORLD, somewhere(seed), np.random.default_rng(0)) for seed in (1, 2))
        assert one.directions is two.directions
        assert len(one.ranges) == len(one.directions)
        assert len(one.ranges) % one.rows == 0
        np.testing.assert_allclose(np.linalg.norm(one.directions, axis=1), 1, atol=1e-12)
        assert (one.time, one.max_range) == (1.5, sensor.range)

    def test_noise_has_the_deviation_asked_for(self, kind: str, options: dict[str, Any]) -> None:
        sensor = registry.find("sensor", kind)(**{**options, "noise": 0.01})
        quiet = replace(sensor, noise=0.0)
        random = np.random.default_rng(7)
        room = World((Box((-3, -3, -3), (-2, 3, 9)), Box((2, -3, -3), (3, 3, 9)), Box((-2, 2, -3), (2, 3, 9))))
        state = level(0, 0, 2)
        exact = quiet.look(room, state, random).ranges
        hit = np.isfinite(exact)
        count = 3 + 4000 // hit.sum()
        off = np.array([sensor.look(room, state, random).ranges[hit] - exact[hit] for _ in range(count)])
        off = (off / np.broadcast_to(sensor.deviation(exact[hit]), off.shape))[np.isfinite(off)]
        assert np.std(off) == pytest.approx(1.0, abs=0.08)
        assert np.mean(off) == pytest.approx(0.0, abs=0.1)

    def test_dropouts_measure_nothing(self, kind: str, options: dict[str, Any]) -> None:
        sensor = registry.find("sensor", kind)(**{**options, "dropouts": 0.2})
        assert not np.isnan(
            replace(sensor, dropouts=0.0).look(WORLD, somewhere(1), np.random.default_rng(1)).ranges
        ).any()
        random = np.random.default_rng(1)
        seen = [sensor.look(WORLD, somewhere(1), random).ranges for _ in range(1 + 4000 // len(sensor.directions))]
        assert np.isnan(seen).mean() == pytest.approx(0.2, abs=0.04)

    def test_the_seed_decides(self, kind: str, options: dict[str, Any]) -> None:
        sensor = registry.find("sensor", kind)(**{**options, "dropouts": 0.1})
        one, two, other = (sensor.look(WORLD, somewhere(1), np.random.default_rng(seed)).ranges for seed in (4, 4, 5))
        np.testing.assert_array_equal(one, two)
        if np.isfinite(one).sum() > 4:
            assert not np.array_equal(one, other, equal_nan=True)

    def test_mounting_turns_every_beam(self, kind: str, options: dict[str, Any]) -> None:
        part = registry.find("sensor", kind)
        straight = part(**{**options, "yaw_deg": 0.0, "pitch_deg": 0.0}).directions
        left = part(**{**options, "yaw_deg": 90.0, "pitch_deg": 0.0}).directions
        down = part(**{**options, "yaw_deg": 0.0, "pitch_deg": 90.0}).directions
        np.testing.assert_allclose(left, straight @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)
        np.testing.assert_allclose(down, straight @ [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-12)


def test_the_rings_of_a_lidar_are_even() -> None:
    sensor = registry.find("sensor", "lidar")(rings=5, columns=8, lowest_deg=-20.0, highest_deg=10.0)
    up = np.degrees(np.arcsin(sensor.directions[:, 2])).reshape(5, 8)
    np.testing.assert_allclose(up, np.linspace(-20, 10, 5)[:, None] * np.ones(8), atol=1e-9)
    around = np.degrees(np.arctan2(sensor.directions[:, 1], sensor.directions[:, 0])).reshape(5, 8)
    np.testing.assert_allclose(np.diff(around, axis=1), 45)
    narrow = registry.find("sensor", "lidar")(rings=1, columns=9, fov_deg=90.0)
    seen = np.degrees(np.arctan2(narrow.directions[:, 1], narrow.directions[:, 0]))
    np.testing.assert_allclose(seen, np.linspace(-40, 40, 9), atol=1e-9)


def test_a_lidar_upside_down_is_refused() -> None:
    with pytest.raises(ValueError, match="lowest_deg is 10"):
        registry.find("sensor", "lidar")(lowest_deg=10.0, highest_deg=-10.0)


def test_pixels_of_a_depth_camera_are_even_on_a_plane() -> None:
    sensor = registry.find("sensor", "depth_camera")(width=8, height=4, fov_deg=90.0, noise=0.0)
    plane = (sensor.directions / sensor.directions[:, :1]).reshape(4, 8, 3)
    np.testing.assert_allclose(plane[:, :, 1], (0.875 - 0.25 * np.arange(8)) * np.ones((4, 1)), atol=1e-12)
    np.testing.assert_allclose(plane[:, :, 2], (0.375 - 0.25 * np.arange(4))[:, None] * np.ones(8), atol=1e-12)
    wall = World((Box((3, -20, -20), (4, 20, 20)),), ground=-20)
    scan = sensor.look(wall, level(0, 0, 0), np.random.default_rng(0))
    np.testing.assert_allclose(scan.ranges * scan.directions[:, 0], 3, atol=1e-9)


def test_a_ring_begins_ahead_and_goes_left() -> None:
    sensor = registry.find("sensor", "distance_ring")(count=4)
    np.testing.assert_allclose(sensor.directions, [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], atol=1e-12)


def test_the_ground_is_seen_where_it_is() -> None:
    sensor = registry.find("sensor", "lidar")(rings=3, columns=4, lowest_deg=-30.0, highest_deg=30.0, noise=0.0)
    scan = sensor.look(World(ground=1.0), level(0, 0, 3), np.random.default_rng(0))
    np.testing.assert_allclose(scan.ranges.reshape(3, 4), [[2 / math.sin(math.pi / 6)] * 4, [np.inf] * 4, [np.inf] * 4])
    assert not sensor.look(World(ground=4.0), level(0, 0, 3), np.random.default_rng(0)).ranges.any()
