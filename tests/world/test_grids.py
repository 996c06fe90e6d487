"""Signed distance of grids against the union of their cells, found by brute force."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.types import Array
from crosstrack.world.grids import PLANE_OPTIMISM, SPACE_OPTIMISM, Grid, Occupied, Relief, Voxels, signed_distance
from crosstrack.world.shapes import Box, Shape
from crosstrack.world.world import World


def to_cells(points: Array, occupied: Occupied, margin: int = 0) -> Array:
    """Distance (n,) from points (n, d) in cells to the union of the set cells as closed unit boxes."""
    low = np.argwhere(occupied) - margin
    gap = np.maximum(0, np.maximum(low - points[:, None], points[:, None] - low - 1))
    return np.asarray(np.linalg.norm(gap, axis=2).min(axis=1))


def true_distance(points: Array, occupied: Occupied) -> Array:
    """Signed distance (n,) to the union, the free space around the grid included."""
    free = np.pad(~occupied, 1, constant_values=True)
    outside = to_cells(points, occupied)
    return np.where(outside > 0, outside, -to_cells(points, free, 1))


@pytest.mark.parametrize("shape", [(6, 5), (1, 1), (1, 4), (5, 4, 3), (3, 1, 2)])
@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
def test_distance_at_the_corners_is_exact_inside_and_outside(shape: tuple[int, ...], share: float) -> None:
    rng = np.random.default_rng(len(shape))
    occupied = rng.uniform(size=shape) < share
    occupied[(0,) * len(shape)] = True
    corners = np.stack(np.meshgrid(*[np.arange(n + 1) for n in shape], indexing="ij"), axis=-1)
    expected = true_distance(corners.reshape(-1, len(shape)).astype(float), occupied)
    np.testing.assert_allclose(signed_distance(occupied, 0.5).ravel(), 0.5 * expected, atol=1e-12)


@pytest.mark.parametrize(("dimensions", "bound"), [(2, PLANE_OPTIMISM), (3, SPACE_OPTIMISM)])
def test_optimism_is_the_worst_over_all_neighbouring_cells(dimensions: int, bound: float) -> None:
    corners = np.array(list(product((0.0, 1.0), repeat=dimensions)))
    steps = np.linspace(0, 1, 41)
    points = np.stack(np.meshgrid(*[steps] * dimensions, indexing="ij"), axis=-1).reshape(-1, dimensions)
    weights = np.prod(np.where(corners == 1, points[:, None], 1 - points[:, None]), axis=2)
    worst = 0.0
    for low in product(range(-2, 3), repeat=dimensions):
        if any(low):
            cell = np.array(low, dtype=float)
            far, near = (
                np.linalg.norm(np.maximum(0, np.maximum(cell - x, x - cell - 1)), axis=1) for x in (corners, points)
            )
            worst = max(worst, float((weights @ far - near).max()))
    assert bound - 2e-4 < worst <= bound + 1e-12


def random_grid(seed: int, share: float) -> tuple[Relief, Voxels]:
    rng = np.random.default_rng(seed)
    plane, space = rng.uniform(size=(7, 6)) < share, rng.uniform(size=(5, 4, 6)) < share
    plane[3, 2] = space[1, 2, 3] = True
    return Relief(plane, (-1.0, 2.0), 0.5, (-1.0, 2.0)), Voxels(space, (1.0, -2.0, 0.5), 0.25)


def truth(grid: Grid, points: Array) -> Array:
    """Signed distance to the union of cells, by another route than the library's."""
    if isinstance(grid, Voxels):
        return np.asarray(grid.cell * true_distance((points - grid.origin) / grid.cell, grid.occupied))
    flat = grid.cell * true_distance((points[:, :2] - grid.origin) / grid.cell, grid.occupied)
    high = np.abs(points[:, 2] - np.mean(grid.z)) - np.ptp(grid.z) / 2
    return np.asarray(np.where((flat > 0) & (high > 0), np.hypot(flat, high), np.maximum(flat, high)))


def around(grid: Grid, count: int, reach: float) -> Array:
    size = np.array(grid.occupied.shape) * grid.cell
    low = np.array([*grid.origin, grid.z[0]]) if isinstance(grid, Relief) else np.array(grid.origin)
    high = low + ([*size, np.ptp(grid.z)] if isinstance(grid, Relief) else size)
    return np.random.default_rng(5).uniform(low - reach, high + reach, size=(count, 3))


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9])
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("reach", [0.3, 5.0])
def test_distance_is_never_more_optimistic_than_stated(which: int, share: float, reach: float) -> None:
    for seed in range(4):
        grid = random_grid(seed, share)[which]
        points = around(grid, 1000, reach)
        world = World(grids=(grid,))
        found, true = world.distance(points), truth(grid, points)
        assert world.optimism == grid.optimism > 0
        outside = true > 1e-9
        assert (found[outside] <= true[outside] + grid.optimism + 1e-12).all()
        assert (found[true < -1e-9] <= 0).all()
        assert (found[outside] >= 0).all()
        assert (found >= true - math.sqrt(3) / 2 * grid.cell - 1e-12)[np.abs(true) < grid.cell / 2].all()


def test_a_flat_wall_of_voxels_has_exact_distance_and_gradient() -> None:
    world = World(grids=(Voxels(np.ones((4, 20, 20), dtype=bool), (0.0, 0.0, 0.0), 0.5),))
    points = np.random.default_rng(0).uniform([-4, 4, 4], [0, 6, 6], size=(200, 3))
    np.testing.assert_allclose(world.distance(points), -points[:, 0], atol=1e-12)
    np.testing.assert_allclose(world.gradient(points), [[-1, 0, 0]] * 200, atol=1e-12)
    inside = np.array([[0.3, 5.1, 5.2], [1.4, 5, 5]])
    np.testing.assert_allclose(world.distance(inside), [-0.3, -0.6], atol=1e-12)


@pytest.mark.parametrize("which", [0, 1])
def test_gradient_is_the_slope_of_the_interpolation(which: int) -> None:
    grid = random_grid(3, 0.2)[which]
    world, points, step = World(grids=(grid,)), around(random_grid(3, 0.2)[which], 3000, 2.0), 1e-6
    ahead = np.stack([world.distance(points + step * axis) for axis in np.eye(3)], axis=1)
    behind = np.stack([world.distance(points - step * axis) for axis in np.eye(3)], axis=1)
    smooth = (np.abs(ahead + behind - 2 * world.distance(points)[:, None]) < 1e-9).all(axis=1)
    assert smooth.mean() > 0.98
    np.testing.assert_allclose(world.gradient(points)[smooth], ((ahead - behind) / (2 * step))[smooth], atol=1e-5)


@pytest.mark.parametrize("which", [0, 1])
@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0, 1))
def test_slope_is_within_what_the_swept_check_counts_on(which: int, seed: int, share: float) -> None:
    grid = random_grid(seed, share)[which]
    world, points = World(grids=(grid,)), around(grid, 400, 1.0)
    steepest = math.sqrt(2 + which)
    assert (np.linalg.norm(world.gradient(points), axis=1) <= steepest + 1e-9).all()
    step = np.random.default_rng(seed).normal(size=points.shape) * 0.1
    change = np.abs(world.distance(points + step) - world.distance(points))
    assert (change <= steepest * np.linalg.norm(step, axis=1) + 1e-9).all()


@pytest.mark.parametrize("which", [0, 1])
def test_distance_far_from_a_grid_is_that_to_its_obstacles(which: int) -> None:
    grid = random_grid(1, 0.1)[which]
    points = np.random.default_rng(2).normal(size=(200, 3))
    points *= 1000 / np.linalg.norm(points, axis=1, keepdims=True)
    true = truth(grid, points)
    found = World(grids=(grid,)).distance(points)
    assert (found <= true + 1e-9).all()
    assert (found >= true - 2.0).all()


def test_grids_and_shapes_stand_together() -> None:
    grid, box = random_grid(1, 0.2)[1], Box((3, 0, 0), (4, 1, 1))
    shapes: tuple[Shape, ...] = (box,)
    points = around(grid, 500, 3.0)
    apart = np.minimum(World(grids=(grid,)).distance(points), World(shapes).distance(points))
    np.testing.assert_array_equal(World(shapes, (grid,)).distance(points), apart)
