"""The local map against the world that the scans were made in, and its distances against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.local_map import LocalMap
from crosstrack.types import Array, Scan, State
from crosstrack.world.generate import Forest
from crosstrack.world.grids import Relief
from crosstrack.world.shapes import Box, Cylinder, Sphere
from crosstrack.world.world import World

LIDAR = Lidar(columns=900, noise=0.0)


def at(position: Array | list[float], time: float = 0.0, yaw: float = 0.0, pitch: float = 0.0) -> State:
    q = np.array([0.0, np.sin(pitch / 2), 0.0, np.cos(pitch / 2)])
    c, s = np.cos(yaw / 2), np.sin(yaw / 2)
    attitude = np.array([c * q[0] - s * q[1], c * q[1] + s * q[0], c * q[2] + s * q[3], c * q[3] - s * q[2]])
    return State(time, np.array(position, dtype=float), np.zeros(3), attitude, np.zeros(3))


def flown(
    world: World, start: list[float], end: list[float], scans: int, lidar: Lidar = LIDAR, told: World | None = None
) -> LocalMap:
    """Return the map after scans from a straight line, with the vehicle rocking and turning a little."""
    local, random = LocalMap.around([lidar], told or World()), np.random.default_rng(0)
    for i, part in enumerate(np.linspace(0, 1, scans)):
        place = np.array(start) + part * (np.array(end) - np.array(start))
        state = at(place, 0.1 * i, 0.3 * np.sin(0.5 * i), 0.15 * np.sin(0.9 * i))
        local.add(lidar.look(world, state, random), state)
    return local


def scattered(points: Array, time: float = 0.0) -> tuple[Scan, State]:
    """Return a scan from the middle of points that hits each of them, and nothing else."""
    middle = points.mean(axis=0)
    ranges = np.linalg.norm(points - middle, axis=1)
    directions = (points - middle) / ranges[:, None]
    return Scan(time, np.zeros(3), directions, ranges, 40.0), at(middle.tolist(), time)


def brute(points: Array, start: Array, end: Array) -> float:
    """Return the least distance from a segment to points."""
    along = end - start
    part = np.clip((points - start) @ along / max(float(along @ along), 1e-300), 0, 1)
    return float(np.linalg.norm(points - start - part[:, None] * along, axis=1).min(initial=np.inf))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 3000), spread=st.floats(0.3, 8.0))
def test_distances_are_those_to_the_points_held(seed: int, count: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    local = LocalMap(20.0, 0.1, World(ground=-99))
    local.add(*scattered(rng.uniform(-5, 5, size=3) + np.clip(spread * rng.normal(size=(count + 1, 3)), -7, 7)))
    held = local.points
    asked = rng.uniform(-12, 12, size=(200, 3))
    tree = cKDTree(held)
    expected, nearest = tree.query(asked)
    np.testing.assert_allclose(local.distance(asked), np.minimum(expected, 5.0), atol=1e-9)
    away = (asked - held[nearest]) / expected[:, None]
    np.testing.assert_allclose(local.gradient(asked), np.where(expected[:, None] < 5, away, 0), atol=1e-6)
    for a, b in zip(asked[:50], asked[50:100], strict=True):
        end = a + (b - a) * rng.uniform(0, 0.5)
        assert local.swept(a, end) == pytest.approx(min(brute(held, a, end), 5.0), abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), cell=st.floats(0.1, 0.5), reach=st.floats(0.3, 3.0))
def test_a_field_is_the_distance_at_the_points_of_a_lattice(seed: int, cell: float, reach: float) -> None:
    rng = np.random.default_rng(seed)
    local = LocalMap(20.0, 0.1, World(ground=-99))
    local.add(*scattered(rng.uniform(-5, 5, size=(int(rng.integers(2, 2000)), 3))))
    counts = (int(rng.integers(1, 30)), int(rng.integers(1, 30)), int(rng.integers(1, 12)))
    low = rng.uniform(-6, 0, size=3)
    field = local.field(low, cell, counts, reach)
    assert field.shape == counts
    assert field.dtype == np.float32
    lattice = low + cell * np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1)
    np.testing.assert_allclose(field, np.minimum(local.distance(lattice), reach), atol=2e-5)


def test_the_window_moves_and_forgets() -> None:
    rng = np.random.default_rng(3)
    local = LocalMap(10.0, 0.1, World(ground=-99))
    for turn in range(60):
        middle = np.array([1.7 * turn, -0.9 * turn, 5 * np.sin(turn)])
        points = middle + rng.uniform(-4, 4, size=(300, 3))
        local.add(*scattered(points, 100.0 * turn))
        held = local.points
        assert np.abs(held - middle).max() < 10.0 + 1.6
        near = points[np.abs(points - middle).max(axis=1) < 3.5]
        assert cKDTree(held).query(near)[0].max() < 0.1 * np.sqrt(3)
        asked = middle + rng.uniform(-5, 5, size=(50, 3))
        np.testing.assert_allclose(local.distance(asked), np.minimum(cKDTree(held).query(asked)[0], 5.0), atol=1e-9)


def seen_well(world: World, position: Array, points: Array, distance: Array) -> NDArray[np.bool_]:
    """Return whether the nearest surface to points is in view from a position: in front, not slanted, not hidden."""
    normal = world.gradient(points)
    surface = points - distance[:, None] * normal
    sight = position - surface
    far = np.linalg.norm(sight, axis=1)
    clear = np.array([world.swept(position, spot) > -1e-6 for spot in surface + 0.01 * normal])
    facing = np.sum(sight * normal, axis=1) > 0.3 * far
    seen: NDArray[np.bool_] = clear & facing & (np.abs(sight[:, 2]) < 0.4 * far)
    return seen


@pytest.mark.parametrize("seed", range(3))
def test_what_was_seen_is_never_farther_than_it_is(seed: int) -> None:
    world = World(Forest(seed=seed, size=(24, 12, 3), density=0.3, radius=(0.2, 0.5), clear=((2, 6),)).shapes())
    random = np.random.default_rng(seed)
    local, position, checked = LocalMap.around([LIDAR], World()), np.array([2.0, 6.0, 1.5]), 0
    worst = -np.inf
    for i in range(60):
        state = at(position, 0.1 * i, 0.3 * np.sin(0.5 * i), 0.15 * np.sin(0.9 * i))
        local.add(LIDAR.look(world, state, random), state)
        near = position + random.uniform(-1, 1, size=(150, 3)) * [1.0, 1.0, 0.4]
        true = world.distance(near)
        ask = seen_well(world, position, near, true) & (true >= local.clearance) & (true < 0.6)
        if i > 15 and ask.any():
            worst = max(worst, float((local.distance(near[ask]) - true[ask]).max()))
            checked += int(ask.sum())
        step = np.array([0.25, 0.2 * np.sin(0.3 * i), 0.0])
        position = position + step + 0.3 * world.gradient(position) * max(0.0, 0.6 - float(world.distance(position)))
    assert checked > 500
    assert worst <= local.optimism


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_thin_wall_stays_shut(noise: float) -> None:
    wall = Relief(np.ones((1, 80), dtype=bool), (6.0, -4.0), 0.1, (0.0, 3.0))
    world, lidar = World(grids=(wall,)), replace(LIDAR, noise=noise)
    rng = np.random.default_rng(1)
    for route in ([[0, -3, 1.5], [5.5, 3, 1.5]], [[5.7, -3.8, 1.2], [5.7, 3.8, 1.8]], [[5.7, 3.8, 1.2], [7, 6, 1.2]]):
        local = flown(world, route[0], route[1], 40, lidar)
        across = rng.uniform([5, -2.5, 0.5], [5.5, 2.5, 2.5], size=(200, 3))
        beyond = across + rng.uniform([1.5, -0.5, -0.3], [2.0, 0.5, 0.3], size=(200, 3))
        assert max(local.swept(a, b) for a, b in zip(across, beyond, strict=True)) < 0.2


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_gap_stays_as_wide_as_it_is(noise: float) -> None:
    boxes = (Box((5, -4, 0), (5.2, -0.25, 3)), Box((5, 0.25, 0), (5.2, 4, 3)))
    local = flown(World(boxes), [0, 1, 1.5], [4, 0, 1.5], 40, replace(LIDAR, noise=noise))
    clearance = local.swept(np.array([4.0, 0, 1.5]), np.array([6.0, 0, 1.5]))
    assert clearance == pytest.approx(0.25, abs=0.005 + 2.5 * noise)


@pytest.mark.parametrize("sensor", [LIDAR, Lidar(), DepthCamera(noise=0.0)])
def test_what_moved_away_vanishes(sensor: Lidar | DepthCamera) -> None:
    local, random = LocalMap.around([sensor], World()), np.random.default_rng(2)
    back = Box((9, -9, 0), (9.5, 9, 9))
    for i in range(70):
        state = at([0, 0, 1.5], 0.1 * i, 0.02 * min(i, 30))
        shapes = (back, Cylinder((5, 0), 0.4, (0, 3))) if i < 10 else (back, Cylinder((5, 3), 0.4, (0, 3)))
        local.add(sensor.look(World(shapes), state, random), state)
        if i == 9:
            assert local.distance(np.array([4.0, 0.0, 1.5])) < 0.7
    assert local.distance(np.array([5.0, 0.0, 1.5])) > 2.0
    assert local.distance(np.array([5.0, 3.0, 1.5])) < 0.6


def test_what_stands_is_not_worn_away() -> None:
    pole = Cylinder((6, 1.0), 0.05, (0, 3))
    world = World((pole, Sphere((4, -2, 1.5), 0.4), Box((2, 2, 0), (12, 2.1, 1.6))))
    local = flown(world, [0, 0, 1.5], [8, 0.2, 1.5], 100)
    for shape in world.shapes:
        tree = cKDTree(local.points)
        vertices = shape.mesh()[0]
        middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
        middle[2] = min(middle[2], 1.5)
        assert tree.query(middle)[0] < 0.45
    along = np.stack([np.linspace(2.5, 8, 50), np.full(50, 2.0), np.full(50, 1.2)], axis=-1)
    assert cKDTree(local.points).query(along)[0].max() < 0.12


def test_dropouts_neither_show_nor_clear() -> None:
    world = World((Box((4, -2, 0), (5, 2, 3)),))
    lidar = replace(LIDAR, dropouts=0.5)
    local, state = flown(world, [0, 0, 1.5], [1, 0, 1.5], 10, lidar), at([1, 0, 1.5], 2.0)
    before = len(local.points)
    scan = lidar.look(world, state, np.random.default_rng(0))
    nothing = replace(scan, ranges=np.full(len(scan.ranges), np.nan))
    for _ in range(10):
        local.add(nothing, state)
    assert before == len(local.points) > 100


def test_the_ground_is_no_obstacle() -> None:
    local = flown(World(ground=-0.5), [0, 0, 1], [3, 0, 1], 20, Lidar(noise=0.03), World(ground=-0.5))
    assert len(local.points) == 0
    assert local.ground == -0.5
    assert local.distance(np.zeros((2, 2, 3))).tolist() == [[5.0, 5.0], [5.0, 5.0]]
    assert not local.gradient(np.zeros((1, 3))).any()
    assert local.swept(np.zeros(3), np.ones(3)) == 5.0
    assert (local.field(np.zeros(3), 0.2, (3, 3, 3), 1.0) == 1.0).all()
    assert local.cast(np.zeros(3), np.eye(3), 9.0).tolist() == [np.inf] * 3


def test_only_what_was_not_told_is_held() -> None:
    told = World((Box((4, -2, 0), (5, 2, 3)), Cylinder((2, 3), 0.4, (0, 3))))
    world = World((*told.shapes, Sphere((2, -1.5, 1.5), 0.3)))
    local = flown(world, [0, 0, 1.5], [2, 0, 1.5], 20, Lidar(), told)
    assert len(local.points) > 20
    assert np.abs(np.linalg.norm(local.points - [2, -1.5, 1.5], axis=1) - 0.3).max() < 0.1


def test_rays_stop_at_what_was_seen() -> None:
    local = flown(World((Box((4, -2, 0), (5, 2, 3)),)), [0, 0, 1.5], [2, 0, 1.5], 20)
    rays = np.array([[1.0, 0, 0], [-1.0, 0, 0], [1.0, 0.2, 0.1] / np.sqrt(1.05)])
    hits = local.cast(np.array([1.0, 0, 1.5]), rays, 10.0)
    np.testing.assert_allclose(hits[[0, 2]] * rays[[0, 2], 0], 3.0, atol=0.12)
    assert hits[1] == np.inf
