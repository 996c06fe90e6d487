"""Rays against obstacles: what they hit first, and where."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obstacles import mixed

from crosstrack.types import Array
from crosstrack.world.generate import Forest
from crosstrack.world.grids import Occupied, Relief, Voxels
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World


def rays(count: int, seed: int) -> Array:
    """Return unit vectors; some along the axes, some level, some steep."""
    rng = np.random.default_rng(seed)
    made = rng.normal(size=(count, 3))
    made[: count // 8] = np.round(made[: count // 8])
    made[count // 8 : count // 4, 2] = 0.0
    made[: count // 8][~made[: count // 8].any(axis=1)] = [0, 0, 1]
    unit: Array = made / np.linalg.norm(made, axis=1, keepdims=True)
    return unit


def boxes(grid: Relief | Voxels) -> World:
    """Return the occupied cells of a grid, each as a box."""
    made = []
    for place in np.argwhere(grid.occupied).tolist():
        low = [o + i * grid.cell for o, i in zip(grid.origin, place, strict=True)]
        high = [x + grid.cell for x in low]
        if isinstance(grid, Relief):
            low, high = [*low, grid.z[0]], [*high, grid.z[1]]
        made.append(Box((low[0], low[1], low[2]), (high[0], high[1], high[2])))
    return World(tuple(made))


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 60), reach=st.floats(1.0, 30.0))
def test_a_ray_ends_on_the_first_surface_and_not_before(seed: int, count: int, reach: float) -> None:
    world = World(mixed(count, seed))
    origin = np.random.default_rng(seed + 1).uniform(-12, 12, size=3)
    for direction, t in zip(d := rays(24, seed), world.cast(origin, d, reach), strict=True):
        if world.distance(origin) <= 0:
            assert t == 0
        elif np.isfinite(t):
            assert 0 < t <= reach
            assert abs(float(world.distance(origin + t * direction))) < 1e-7
            assert world.swept(origin, origin + (t - 1e-6) * direction) > -1e-9
        else:
            assert world.swept(origin, origin + reach * direction) > -1e-9


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.005, 0.5))
@pytest.mark.parametrize("kind", [Relief, Voxels])
def test_a_grid_is_the_union_of_its_cells(kind: type[Relief] | type[Voxels], seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    size = rng.integers(1, 14, size=2 if kind is Relief else 3)
    occupied: Occupied = rng.uniform(size=size) < share
    occupied.flat[0] = True
    grid: Relief | Voxels
    if kind is Relief:
        grid = Relief(occupied, (-1.3, 0.7), 0.37, (0.2, 1.7))
    else:
        grid = Voxels(occupied, (-1.3, 0.7, -0.4), 0.37)
    origin = rng.uniform(-4, 6, size=3)
    d = rays(64, seed)
    np.testing.assert_allclose(World(grids=(grid,)).cast(origin, d, 9.0), boxes(grid).cast(origin, d, 9.0), atol=1e-9)


def test_a_way_through_one_cell_wide_is_seen_through() -> None:
    wall = np.ones((1, 9), dtype=bool)
    wall[0, 4] = False
    world = World(grids=(Relief(wall, (5.0, -0.9), 0.2, (0.0, 3.0)),))
    ahead = np.array([[1.0, 0.0, 0.0]])
    assert world.cast(np.array([0.0, 0.0, 1.0]), ahead, 20.0)[0] == np.inf
    assert world.cast(np.array([0.0, 0.2, 1.0]), ahead, 20.0)[0] == pytest.approx(5.0)


def test_rays_start_inside_at_zero() -> None:
    grids = (Relief(np.ones((3, 3), dtype=bool), (20.0, 0.0), 1.0, (0.0, 3.0)),)
    cube = Voxels(np.ones((3, 3, 3), dtype=bool), (30.0, 0.0, 0.0), 1.0)
    inside: dict[tuple[float, float, float], Shape] = {
        (0.5, 0.5, 0.5): Box((0, 0, 0), (1, 1, 1)),
        (5, 0, 1): Cylinder((5, 0), 1, (0, 2)),
    }
    inside |= {(9, 0, 0): Sphere((9, 0, 0), 1), (14, 1, 1): Prism(((13, 0), (16, 0), (13, 3)), (0, 2))}
    world = World(tuple(inside.values()), (*grids, cube))
    for origin in (*inside, (21.5, 1.5, 1.0), (31.5, 1.5, 1.5)):
        assert not world.cast(np.array(origin, dtype=float), rays(50, 3), 100.0).any()


def test_nothing_beyond_reach_or_behind_is_hit() -> None:
    world = World((Sphere((5, 0, 0), 1),))
    ahead, back = np.array([[1.0, 0, 0]]), np.array([[-1.0, 0, 0]])
    assert world.cast(np.zeros(3), ahead, 4.0 + 1e-12)[0] == pytest.approx(4)
    assert world.cast(np.zeros(3), ahead, 3.99)[0] == np.inf
    assert world.cast(np.zeros(3), back, 100.0)[0] == np.inf
    assert World().cast(np.zeros(3), ahead, 100.0)[0] == np.inf
    assert world.cast(np.zeros(3), np.empty((0, 3)), 10.0).shape == (0,)


def test_mujoco_agrees() -> None:
    shapes = [shape for shape in mixed(160, 11) if not isinstance(shape, Prism)]
    geoms = [geom(shape) for shape in shapes]
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{''.join(geoms)}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    world = World(tuple(shapes))
    rng = np.random.default_rng(5)
    starts = [p for p in rng.uniform(-12, 12, size=(20, 3)) if world.distance(p) > 0]
    assert len(starts) > 10
    for origin in starts:
        d = rays(100, int(1000 * abs(origin[0])))
        hit = np.array([[mujoco.mj_ray(model, data, origin, ray, None, 1, -1, np.zeros(1, np.int32))] for ray in d])
        expected = np.where(hit < 0, np.inf, hit)[:, 0]
        expected[expected > 18] = np.inf
        np.testing.assert_allclose(world.cast(origin, d, 18.0), expected, atol=1e-7)


def geom(shape: Shape) -> str:
    """Return a shape as MuJoCo writes it."""
    match shape:
        case Box():
            low, high = np.array(shape.min), np.array(shape.max)
            kind, size, middle = "box", (high - low) / 2, (high + low) / 2
        case Cylinder(center=(x, y), radius=r, z=(lo, hi)):
            kind, size, middle = "cylinder", np.array([r, (hi - lo) / 2]), np.array([x, y, (lo + hi) / 2])
        case Sphere():
            kind, size, middle = "sphere", np.array([shape.radius]), np.array(shape.center)
        case _:
            raise TypeError(shape)
    numbers = [" ".join(map(repr, values.tolist())) for values in (size, middle)]
    return f'<geom type="{kind}" size="{numbers[0]}" pos="{numbers[1]}"/>'


@pytest.mark.parametrize("count", [1, 40, 20_000])
def test_sectors_do_not_change_what_is_hit(count: int) -> None:
    world = World(Forest(seed=3, size=(30, 30, 3), density=0.3).shapes())
    origin, d = np.array([14.2, 15.1, 1.5]), rays(20_000, 4)
    together = world.cast(origin, d, 12.0)
    parts = np.concatenate(
        [world.cast(origin, d[i : i + count], 12.0) for i in range(0, min(len(d), 60 * count), count)]
    )
    np.testing.assert_array_equal(parts, together[: len(parts)])


def test_a_ray_straight_up_hits_what_is_above() -> None:
    world = World((Cylinder((0, 0), 1, (5, 6)), Box((2, 2, -3), (3, 3, -2)), Sphere((-3, 0, 9), 1)))
    up, down = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 0.0, -1.0]])
    assert world.cast(np.zeros(3), up, 20.0)[0] == pytest.approx(5)
    assert world.cast(np.array([2.5, 2.5, 0.0]), down, 20.0)[0] == pytest.approx(2)
    assert world.cast(np.array([-3.0, 0.5, 0.0]), up, 20.0)[0] == pytest.approx(9 - math.sqrt(0.75))
    assert world.cast(np.zeros(3), down, 20.0)[0] == np.inf
