"""The nearest of many obstacles, and the least distance along a segment."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from obstacles import mixed

from crosstrack.types import Array
from crosstrack.world.grids import Occupied, Relief, Voxels
from crosstrack.world.shapes import Box, Cylinder, Prism, Sphere
from crosstrack.world.world import World

Triple = tuple[float, float, float]


def lumps() -> tuple[Relief, Voxels]:
    rng = np.random.default_rng(8)
    return (
        Relief(rng.uniform(size=(12, 9)) < 0.2, (-12.0, -3.0), 0.5, (0.0, 3.0)),
        Voxels(rng.uniform(size=(6, 7, 8)) < 0.1, (3.0, 3.0, -2.0), 0.4),
    )


SHAPES = World(mixed(60, 1))
EVERYTHING = World(mixed(20, 2), lumps())


@pytest.mark.parametrize("count", [1, 2, 5, 60, 700])
def test_the_tree_finds_the_least_over_all_obstacles(count: int) -> None:
    shapes = mixed(count, 5)
    points = np.random.default_rng(6).uniform(-14, 14, size=(300, 3))
    each = np.array([World((shape,)).distance(points) for shape in shapes])
    np.testing.assert_array_equal(World(tuple(shapes)).distance(points), each.min(axis=0))


def test_gradient_is_that_of_the_nearest_obstacle() -> None:
    shapes = mixed(40, 5)
    points = np.random.default_rng(6).uniform(-14, 14, size=(200, 3))
    worlds = [World((shape,)) for shape in shapes]
    nearest = np.argmin([world.distance(points) for world in worlds], axis=0)
    expected = [worlds[i].gradient(p) for i, p in zip(nearest, points, strict=True)]
    np.testing.assert_array_equal(World(tuple(shapes)).gradient(points), expected)


def test_union_is_exact_outside_and_no_deeper_than_true_inside() -> None:
    halves = World((Box((0, 0, 0), (1.2, 1, 1)), Box((0.8, 0, 0), (2, 1, 1))))
    whole = World((Box((0, 0, 0), (2, 1, 1)),))
    points = np.random.default_rng(0).uniform(-1, 3, size=(3000, 3))
    union, true = halves.distance(points), whole.distance(points)
    outside = true >= 0
    np.testing.assert_allclose(union[outside], true[outside])
    assert (union[~outside] >= true[~outside] - 1e-12).all()
    assert (union[~outside] < 0).all()


def test_shapes_of_any_leading_axes() -> None:
    points = np.random.default_rng(0).uniform(-5, 5, size=(2, 3, 4, 3))
    assert SHAPES.distance(points).shape == (2, 3, 4)
    assert SHAPES.gradient(points).shape == (2, 3, 4, 3)
    assert SHAPES.distance(points[0, 0, 0]) == SHAPES.distance(points)[0, 0, 0]
    assert SHAPES.distance(np.empty((0, 3))).shape == (0,)


def test_without_obstacles_everything_is_infinitely_far() -> None:
    world = World(grids=(Relief(np.zeros((3, 3), dtype=bool), (0.0, 0.0), 1.0, (0.0, 1.0)),))
    points = np.zeros((2, 5, 3))
    assert (world.distance(points) == np.inf).all()
    assert (world.gradient(points) == 0).all()
    assert world.swept(points[0, 0], points[0, 1]) == np.inf
    assert world.meshes() == []


span = st.floats(-14, 14)
triple = st.tuples(span, span, span)


@settings(max_examples=100, deadline=None)
@given(triple, triple)
def test_distance_to_many_shapes_is_1_lipschitz(a: Triple, b: Triple) -> None:
    one, two = SHAPES.distance(np.array([a, b]))
    assert abs(one - two) <= math.dist(a, b) + 1e-12


def samples(world: World, start: Array, end: Array, count: int) -> float:
    return float(world.distance(start + np.linspace(0, 1, count)[:, None] * (end - start)).min())


@pytest.mark.parametrize(("world", "slope"), [(SHAPES, 1.0), (EVERYTHING, math.sqrt(3))], ids=["shapes", "everything"])
@pytest.mark.parametrize("reach", [0.1, 2.0, 12.0])
def test_swept_agrees_with_dense_samples(world: World, slope: float, reach: float) -> None:
    rng = np.random.default_rng(11)
    for _ in range(150):
        start = rng.uniform(-12, 12, size=3)
        end = start + rng.normal(size=3) * reach
        count = 2001
        found, seen = world.swept(start, end), samples(world, start, end, count)
        gap = slope * float(np.linalg.norm(end - start)) / (count - 1) / 2
        assert seen - gap - 1e-9 <= found <= seen + 1e-3


def test_swept_of_boxes_cylinders_and_spheres_is_finer() -> None:
    world = World(tuple(shape for shape in mixed(60, 1) if not isinstance(shape, Prism)))
    rng = np.random.default_rng(12)
    for _ in range(100):
        start = rng.uniform(-12, 12, size=3)
        end = start + rng.normal(size=3)
        assert world.swept(start, end) <= samples(world, start, end, 2001) + 1.1e-6


@settings(max_examples=60, deadline=None)
@given(st.floats(-4, 4), st.floats(1e-3, 40), st.floats(-1, 1), st.floats(0.001, 1))
def test_a_thin_wall_between_two_points_is_found(place: float, reach: float, tilt: float, part: float) -> None:
    wall = World((Box((place, -200, -200), (place + 1e-3, 200, 200)),))
    direction = np.array([1.0, tilt, -tilt / 2])
    start = np.array([place - part * reach, 0.3, 0.2])
    assert wall.distance(start) > 0
    assert wall.swept(start, start + (reach + 0.01) * direction) == pytest.approx(-5e-4, abs=2e-6)


def test_walls_that_the_middle_of_a_segment_hits_are_found() -> None:
    start, end = np.array([-1.0, 3.0, 1.0]), np.array([1.0, 3.0, 1.0])
    ell = ((-0.1, 0.0), (0.1, 0.0), (0.1, 9.0), (-3.0, 9.0), (-3.0, 8.0), (-0.1, 8.0))
    for shape in (
        Box((-0.1, 0, 0), (0.1, 6, 3)),
        Cylinder((0, 3), 0.1, (0, 3)),
        Sphere((0, 3, 1), 0.1),
        Prism(ell, (0, 3)),
    ):
        assert World((shape,)).swept(start, end) == pytest.approx(-0.1, abs=1e-3)


def test_a_thin_prism_and_a_row_of_voxels_are_found() -> None:
    start, end = np.array([-3.0, 0.1, 1.0]), np.array([4.0, 0.3, 1.1])
    prism = World((Prism(((0, -5), (1e-3, -5), (1e-3, 5), (0, 5)), (0, 2)),))
    occupied = np.ones((1, 40, 10), dtype=bool)
    voxels = World(grids=(Voxels(occupied, (0.0, -5.0, 0.0), 0.25),))
    relief = World(grids=(Relief(occupied[:, :, 0], (0.0, -5.0), 0.25, (0.0, 2.0)),))
    assert prism.swept(start, end) <= 5e-4
    assert voxels.swept(start, end) <= 1e-3
    assert relief.swept(start, end) <= 1e-3


def test_swept_of_a_point_is_its_distance() -> None:
    for p in np.random.default_rng(1).uniform(-12, 12, size=(50, 3)):
        assert EVERYTHING.swept(p, p) == EVERYTHING.distance(p)


def filled(shape: tuple[int, ...], *occupied: tuple[int, ...]) -> Occupied:
    cells = np.zeros(shape, dtype=bool)
    cells[tuple(np.array(occupied).T)] = True
    return cells


SQUARES = [(0, 2), (1, 1), (2, 3), (2, 5), (3, 0), (3, 1), (3, 2), (3, 3), (4, 0), (4, 1), (4, 5), (5, 5)]
PLANE = Relief(filled((6, 6), *SQUARES), (0, 0), 1.0, (-50, 50))
CUBES = [(0, 0, 2), (0, 3, 4), (2, 2, 1), (2, 2, 3), (2, 2, 4), (3, 0, 2)]
SPACE = Voxels(filled((5, 5, 5), *CUBES), (0, 0, 0), 1.0)


@pytest.mark.parametrize(
    ("world", "start", "end"),
    [
        (
            World(grids=(PLANE,)),
            (0.39847938, 3.18645302, 0.0),
            (5.30261887, 0.29995842, 0.0),
        ),
        (
            World(grids=(SPACE,)),
            (6.28095088, 4.17698747, 4.32270156),
            (-0.57412065, 1.70402384, 5.76197375),
        ),
    ],
    ids=["plane", "space"],
)
def test_swept_counts_on_slopes_above_1_in_grids(world: World, start: Triple, end: Triple) -> None:
    a, b = np.array(start), np.array(end)
    assert world.swept(a, b) <= samples(world, a, b, 20_001) + 1e-3


def test_swept_ends_where_rounding_exceeds_its_tolerance() -> None:
    far = np.array([1e13, 0.0, 0.0])
    world = World((Sphere((1e13, 0, 0), 1.0), Cylinder((1e13, 3), 1.0, (0, 1))))
    for seed in range(50):
        start, end = np.random.default_rng(seed).normal(size=(2, 3)) * 3
        assert -1.01 <= world.swept(far + start, far + end) <= 20


def test_swept_takes_very_long_segments() -> None:
    world = World((Sphere((0, 0, 0), 1.0),))
    assert world.swept(np.array([-1e6, 3.0, 0.0]), np.array([2e6, 3.0, 0.0])) == pytest.approx(2.0, abs=1e-5)
