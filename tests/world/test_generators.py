"""Worlds from a seed."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from crosstrack import registry
from crosstrack.types import Array
from crosstrack.world.generate import City, Forest, Gap, Maze, Trap
from crosstrack.world.shapes import Box, Cylinder, Shape
from crosstrack.world.world import World


@pytest.mark.parametrize("kind", ["forest", "maze", "city", "gap", "trap"])
def test_a_seed_always_gives_the_same_world_and_another_seed_another(kind: str) -> None:
    make: Any = registry.find("generator", kind)
    assert make(seed=7).shapes() == make(seed=7).shapes()
    assert make(seed=7).shapes() != make(seed=8).shapes()


@pytest.mark.parametrize("kind", ["forest", "maze", "city", "gap", "trap"])
def test_worlds_stand_on_the_ground_from_their_origin(kind: str) -> None:
    make: Any = registry.find("generator", kind)
    moved, here = make(seed=3, origin=(100, -50)).shapes(20.0), make(seed=3).shapes()
    points = np.random.default_rng(0).uniform(-2, 12, size=(300, 3))
    shifted = World(moved).distance(points + [100, -50, 20])
    np.testing.assert_allclose(shifted, World(here).distance(points), atol=1e-9)
    low = min(float(World((shape,)).table.boxes[0, 2]) for shape in moved)  # type: ignore[union-attr] # not empty
    assert low == 20.0


def trunks(shapes: tuple[Shape, ...]) -> tuple[Array, Array]:
    found = [shape for shape in shapes if isinstance(shape, Cylinder)]
    assert len(found) == len(shapes)
    return np.array([trunk.center for trunk in found]), np.array([trunk.radius for trunk in found])


def test_forest_has_its_density_evenly_and_its_sizes() -> None:
    forest = Forest(seed=1, size=(200, 100, 6), density=0.3, radius=(0.1, 0.4))
    middle, radius = trunks(forest.shapes())
    assert len(middle) == 6000
    squares = (middle // 20).astype(int) @ [5, 1]
    counts = np.bincount(squares, minlength=50)
    assert len(counts) == 50
    assert ((counts - 120) ** 2 / 120).sum() < 86.7  # chi-squared, 49 degrees of freedom: 0.1 %
    assert radius.min() >= 0.1
    assert radius.max() <= 0.4
    assert all(shape.z == (0, 6) for shape in forest.shapes() if isinstance(shape, Cylinder))


def test_forest_keeps_points_clear_and_the_rest_as_it_was() -> None:
    points = ((5.0, 5.0), (30.0, 12.0))
    wild, kept = Forest(seed=2).shapes(), Forest(seed=2, clear=points, clear_radius=3.0).shapes()
    world = World(kept)
    assert set(kept) < set(wild)
    assert all(world.distance(np.array([*point, 1.0])) >= 3.0 for point in points)
    middle, radius = trunks(tuple(set(wild) - set(kept)))
    nearest = np.min([np.linalg.norm(middle - point, axis=1) for point in points], axis=0)
    assert (nearest - radius < 3.0).all()


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 1000), st.integers(1, 9), st.integers(1, 7))
def test_maze_joins_every_cell_by_one_way(seed: int, columns: int, rows: int) -> None:
    maze = Maze(seed=seed, size=(2.0 * columns, 2.0 * rows, 3), cell=2.0, wall=0.2)
    world = World(maze.shapes())
    x, y = np.arange(columns) * 2.0 + 1, np.arange(rows) * 2.0 + 1
    east = np.array([[world.swept(np.array([a, b, 1]), np.array([a + 2, b, 1])) > 0.5 for b in y] for a in x[:-1]])
    north = np.array([[world.swept(np.array([a, b, 1]), np.array([a, b + 2, 1])) > 0.5 for b in y[:-1]] for a in x])
    cells = np.zeros((2 * columns - 1, 2 * rows - 1), dtype=bool)
    cells[::2, ::2] = True
    cells[1::2, ::2] = east.reshape(columns - 1, rows)
    cells[::2, 1::2] = north.reshape(columns, rows - 1)
    assert label(cells)[1] == 1
    assert east.sum() + north.sum() == columns * rows - 1


def test_maze_opens_only_at_its_first_and_last_cell() -> None:
    world = World(Maze(seed=5, size=(10, 8, 3), cell=2.0).shapes())
    y = np.arange(4) * 2.0 + 1
    west = [world.swept(np.array([-1.0, b, 1]), np.array([1.0, b, 1])) > 0 for b in y]
    east = [world.swept(np.array([9.0, b, 1]), np.array([11.0, b, 1])) > 0 for b in y]
    assert west == [True, False, False, False]
    assert east == [False, False, False, True]
    assert world.distance(np.array([1.0, 1.0, 1.0])) == pytest.approx(0.9)


def test_city_keeps_its_streets_and_heights() -> None:
    city = City(seed=4, size=(140, 90, 50), block=15, street=10, lowest=12)
    shapes = city.shapes()
    assert len(shapes) == 5 * 3
    assert {type(shape).__name__ for shape in shapes} == {"Box", "Cylinder", "Prism"}
    world = World(shapes)
    for x in np.arange(6) * 25.0:
        assert world.swept(np.array([x, 0, 5]), np.array([x, 75.0, 5])) >= 5.0
    for y in np.arange(4) * 25.0:
        assert world.swept(np.array([0, y, 5]), np.array([125.0, y, 5])) >= 5.0
    for shape in shapes:
        top = shape.max[2] if isinstance(shape, Box) else shape.z[1]  # type: ignore[union-attr] # no spheres
        assert 12 <= top <= 50


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 1000), st.floats(0.3, 9.9))
def test_gap_is_as_wide_as_it_says_and_the_only_way(seed: int, width: float) -> None:
    shapes = Gap(seed=seed, size=(20, 10, 3), width=width).shapes()
    y = np.linspace(0.0005, 9.9995, 10_000)
    world = World(shapes)
    blocked = world.distance(np.stack([np.full_like(y, 10.0), y, np.ones_like(y)], axis=1)) <= 0
    assert (~blocked).sum() / 1000 == pytest.approx(width, abs=0.0021)
    assert np.abs(np.diff((~blocked).astype(int))).sum() <= 2
    assert world.swept(np.array([0, -0.2, 1]), np.array([20, -0.2, 1])) == pytest.approx(0.2)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_trap_is_open_towards_the_start_and_nowhere_else(seed: int) -> None:
    world = World(Trap(seed=seed, size=(10, 8, 3), wall=0.2).shapes())
    inside = np.array([8.0, 4.0, 1.0])
    angles = np.linspace(-np.pi, np.pi, 721)
    free = np.array([world.swept(inside, inside + 30 * np.array([np.cos(a), np.sin(a), 0])) > 0 for a in angles])
    assert free[np.abs(angles) > np.pi - 0.4].all()
    assert not free[np.abs(angles) < np.pi / 2].any()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Forest(radius=(0.5, 0.2)), ["0.5, 0.2"]),
        (lambda: Forest(size=(1e4, 1e4, 3)), ["20000000 trees", "20000"]),
        (lambda: Maze(size=(1, 20, 3), cell=2, wall=3), ["at least one cell", "wall is 3"]),
        (lambda: Maze(size=(1e4, 1e4, 3), cell=1), ["1e+08 cells"]),
        (lambda: City(size=(10, 10, 5)), ["must hold a block", "lowest is 8"]),
        (lambda: City(size=(1e5, 1e5, 50)), ["blocks; at most"]),
        (lambda: Gap(width=12), ["width is 12", "10"]),
        (lambda: Gap(wall=30), ["wall is 30"]),
        (lambda: Trap(wall=4), ["below 4"]),
    ],
)
def test_impossible_worlds_are_refused(make: Any, words: list[str]) -> None:
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the words are checked below
        make()
    assert all(word in str(caught.value) for word in words), str(caught.value)
