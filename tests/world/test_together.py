"""Several maps as one."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.world.shapes import Box, Cylinder, Sphere
from crosstrack.world.together import Together
from crosstrack.world.world import World

ONE = World((Box((0, 0, 0), (2, 1, 3)), Sphere((6, 2, 2), 1.0)), ground=0.5, bounds=np.array([[-9.0] * 3, [9.0] * 3]))
TWO = World((Cylinder((3, 4), 0.5, (0, 3)),))
BOTH, MERGED = Together((ONE, TWO)), World((*ONE.shapes, *TWO.shapes))
SEEDS = st.integers(0, 10_000)


@given(SEEDS)
def test_the_union_is_the_world_of_all_shapes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-3, 9, size=(4, 5, 3))
    np.testing.assert_allclose(BOTH.distance(points), MERGED.distance(points), atol=1e-12)
    np.testing.assert_allclose(BOTH.gradient(points), MERGED.gradient(points), atol=1e-12)
    start, end = rng.uniform(-3, 9, size=(2, 3))
    assert BOTH.swept(start, end) == MERGED.swept(start, end)
    directions = rng.normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    outside = np.array([-4.0, -4.0, 5.0])
    np.testing.assert_allclose(BOTH.cast(outside, directions, 20.0), MERGED.cast(outside, directions, 20.0), atol=1e-9)


def test_the_lattice_is_that_of_the_merged_world() -> None:
    low, counts = np.array([-1.0, -1.0, 0.0]), (40, 30, 20)
    np.testing.assert_allclose(BOTH.field(low, 0.25, counts, 1.0), MERGED.field(low, 0.25, counts, 1.0), atol=1e-6)


def test_ground_and_bounds_are_those_of_the_first() -> None:
    assert BOTH.ground == 0.5
    assert BOTH.bounds is ONE.bounds
    assert BOTH.optimism == 0.0
