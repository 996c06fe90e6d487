"""Certified clearance, against closed forms and true distances."""

import numpy as np
import pytest
from curves import random_curve
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from crosstrack.trajectory.certified.clearance import least_clearance
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.world.grids import Voxels
from crosstrack.world.shapes import Box, Sphere
from crosstrack.world.world import World


def straight(
    start: tuple[float, float, float], end: tuple[float, float, float], duration: float = 10.0
) -> PiecewisePolynomial:
    a, b = np.array(start), np.array(end)
    return PiecewisePolynomial(np.array([duration]), np.array([[a, (b - a) / duration]]))


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-4])
def test_passing_a_sphere(tolerance: float) -> None:
    found = least_clearance(straight((-20, 3, 5), (10, 3, 5)), World((Sphere((0, 0, 5), 1.0),)), tolerance=tolerance)
    assert found.value <= 2.0 <= found.attained
    assert found.attained - found.value <= tolerance + 1e-9
    assert found.time == pytest.approx(20 / 3, abs=2 * tolerance**0.5)
    np.testing.assert_allclose(found.position, [-20 + 3 * found.time, 3, 5], atol=1e-9)


@pytest.mark.parametrize("thickness", [1e-2, 1e-4])
def test_a_thin_wall_between_samples_is_seen(thickness: float) -> None:
    wall = Box((7.3, -5, 0), (7.3 + thickness, 5, 10))
    found = least_clearance(straight((0, 0, 5), (1000, 0, 5), duration=1.0), World((wall,)), tolerance=thickness / 10)
    assert found.attained < 0
    assert found.value == pytest.approx(-thickness / 2, abs=thickness / 5)
    assert found.position[0] == pytest.approx(7.3 + thickness / 2, abs=thickness / 2)


def test_nothing_in_the_way() -> None:
    found = least_clearance(straight((0, 0, 5), (1, 0, 5)), World())
    assert found.value == found.attained == np.inf


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_the_least_distance_is_enclosed(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = random_curve(seed, degree=5, pieces=3, spread=1.0)
    spheres = [Sphere((x, y, z), 0.5) for x, y, z in (rng.normal(size=(4, 3)) * 30).tolist()]
    world = World(tuple(spheres))
    found = least_clearance(curve, world, tolerance=0.05)
    assert found.attained - found.value <= 0.05 + 1e-9
    least = np.inf
    for piece in range(3):
        times = np.linspace(curve.knots[piece], curve.knots[piece + 1], 200)[:-1]
        start = times[np.argmin(world.distance(curve(times)))]
        bounds = max(start - times[1] + times[0], times[0]), min(start + times[1] - times[0], times[-1])
        refined = minimize_scalar(lambda t: float(world.distance(curve(t))), bounds=bounds, method="bounded")
        least = min(least, float(refined.fun))
    assert found.value <= least + 1e-12


def test_what_a_map_says_too_much_is_taken_off() -> None:
    rng = np.random.default_rng(3)
    occupied = rng.uniform(size=(6, 6, 6)) < 0.2
    grid = Voxels(occupied, (0.0, 0.0, 0.0), 1.0)
    cells = World(tuple(Box((x, y, z), (x + 1, y + 1, z + 1)) for x, y, z in np.argwhere(occupied).tolist()))
    for seed in range(20):
        ends = np.random.default_rng(seed).uniform(-3, 9, (2, 3))
        curve = PiecewisePolynomial(np.ones(1), np.array([[ends[0], ends[1] - ends[0]]]))
        true = float(cells.distance(curve(np.linspace(0, 1, 2001))).min())
        found = least_clearance(curve, World(grids=(grid,)), tolerance=1e-3, optimism=grid.optimism)
        assert found.value <= max(true, 0.0)
        assert found.value >= min(true, 0.0) - 1.1 * grid.optimism - 1.0 * (true < 0)


def test_a_bound_broken_off_is_loose_and_says_so() -> None:
    curve, world = straight((0, 0, 5), (100, 0, 5)), World((Box((-10, 2, 0), (110, 3, 10)),))
    rough, fine = (least_clearance(curve, world, tolerance=1e-3, most=most) for most in (100, 1_000_000))
    assert rough.value < fine.value <= 2.0 <= fine.attained <= rough.attained
    assert fine.attained - fine.value <= 1e-3 + 1e-9
    assert rough.attained - rough.value > 1e-3
