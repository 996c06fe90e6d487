import numpy as np
import pytest

from crosstrack.types import Array
from crosstrack.world.grids import Relief, Voxels
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World

LOW, CELL, COUNTS = np.array([-1.0, -0.7, -0.5]), 0.17, (19, 17, 15)
L_SHAPE = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.4, 0.4), (0.4, 1.2), (0.0, 1.2))
SHAPES: list[Shape] = [
    Box((0.1, 0.2, 0.0), (0.9, 0.5, 1.1)),
    Box((0.5, -0.5, 0.3), (0.51, 1.5, 0.9)),
    Cylinder((0.4, 0.6), 0.35, (0.2, 1.4)),
    Sphere((0.6, 0.4, 0.8), 0.45),
    Prism(L_SHAPE, (0.1, 0.8)),
]


def points() -> Array:
    axes = [low + CELL * np.arange(count) for low, count in zip(LOW, COUNTS, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


@pytest.mark.parametrize("reach", [0.2, 0.8, 5.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_each_shape_is_stamped_exactly(shape: Shape, reach: float) -> None:
    world = World((shape,))
    expected = np.minimum(world.distance(points()), reach)
    np.testing.assert_allclose(world.field(LOW, CELL, COUNTS, reach), expected, atol=1e-6)


def test_the_nearest_of_many_counts_and_grids_too() -> None:
    rng = np.random.default_rng(3)
    grids = (
        Relief(rng.random((6, 5)) < 0.3, (-0.5, -0.4), 0.2, (0.0, 1.0)),
        Voxels(rng.random((5, 4, 6)) < 0.2, (0.3, 0.1, -0.2), 0.15),
    )
    world = World(tuple(SHAPES), grids)
    expected = np.minimum(world.distance(points()), 0.6)
    np.testing.assert_allclose(world.field(LOW, CELL, COUNTS, 0.6), expected, atol=1e-6)


def test_far_from_everything_and_without_anything_it_is_the_reach() -> None:
    for world in (World(), World((Sphere((50.0, 0.0, 0.0), 1.0),))):
        values = world.field(LOW, CELL, COUNTS, 0.5)
        assert values.shape == COUNTS
        assert values.dtype == np.float32
        assert (values == np.float32(0.5)).all()
