"""Corridors and limits at every instant: against a cone solver at a fine grid, and against the definition itself."""

from itertools import pairwise

import numpy as np
import pytest
from cone_oracle import least_cost
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from crosstrack.errors import Infeasible
from crosstrack.trajectory.certified.extremes import largest_norm
from crosstrack.trajectory.constrained.bounded import Solution, solve
from crosstrack.trajectory.constrained.corridor import Boxes, Corridor, Polytopes, Tube, subdivide
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.types import Array

GRID = np.linspace(0.0, 1.0, 301)


def tour(seed: int, count: int, dimensions: int) -> tuple[Array, Array]:
    """Return waypoints of a random walk, and times."""
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.uniform(-2, 2, (count, dimensions)), axis=0)
    return points, np.r_[0.0, np.cumsum(rng.uniform(0.6, 1.4, count - 1))]


def corridor_of(kind: str, points: Array, radius: float, seed: int) -> Corridor:
    """Return a corridor around the chords."""
    if kind == "tube":
        return Tube(radius)
    if kind == "boxes":
        low, high = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
        return Boxes(low - radius, high + radius)
    rng, faces = np.random.default_rng(seed), []
    for start, end in pairwise(points):
        normals = rng.normal(size=(3, points.shape[1]))
        normals = np.concatenate([normals, np.eye(points.shape[1]), -np.eye(points.shape[1])])
        faces.append((normals, np.maximum(normals @ start, normals @ end) + radius))
    return Polytopes(faces)


def outside(found: Solution, corridor: Corridor | None, limits: MotionLimits | None, points: Array) -> float:
    """Return the largest excess at a dense grid, negative inside."""
    curve, worst = found.curve, -np.inf
    powers = GRID[:, None] ** np.arange(curve.degree + 1)
    for i, span in enumerate(curve.durations):
        p = powers @ (curve.coefficients[i] * span ** np.arange(curve.degree + 1)[:, None])
        if isinstance(corridor, Tube):
            chord = points[i + 1] - points[i]
            foot = np.clip((p - points[i]) @ chord / (chord @ chord), 0, 1)
            excess = np.linalg.norm(p - points[i] - foot[:, None] * chord, axis=1) - corridor.radius
            worst = max(worst, float(excess.max()))
        elif isinstance(corridor, Boxes):
            low, high = np.asarray(corridor.low)[i], np.asarray(corridor.high)[i]
            worst = max(worst, float(np.maximum(p - high, low - p).max()))
        elif isinstance(corridor, Polytopes):
            normals, offsets = corridor.faces[i]
            worst = max(worst, float((p @ np.asarray(normals).T - np.asarray(offsets)).max()))
    times = np.linspace(0, curve.duration, 4001)
    for bound in limits.bounds(points.shape[1]) if limits else ():
        norm = np.linalg.norm(curve(times, bound.order)[:, bound.axes], axis=1)
        worst = max(worst, float(norm.max() - bound.most))
    return worst


CASES = [
    ("tube", 2, 3, 4, None),
    ("tube", 3, 2, 5, None),
    ("tube", 3, 3, 4, 0.95),
    ("boxes", 2, 3, 5, None),
    ("boxes", 3, 4, 4, 0.95),
    ("polytopes", 2, 4, 4, None),
    ("polytopes", 3, 3, 5, 0.95),
    (None, 2, 3, 4, 0.97),
    (None, 3, 4, 3, 0.95),
]


@pytest.mark.parametrize(("kind", "dimensions", "s", "count", "share"), CASES)
def test_cost_is_the_least_of_a_cone_program(
    kind: str | None, dimensions: int, s: int, count: int, share: float | None
) -> None:
    points, times = tour(7, count, dimensions)
    corridor = corridor_of(kind, points, 0.4, 1) if kind else None
    free = solve(points, times, s, corridor=corridor).curve if kind else minimum(points, times, s)
    limits = None
    if share is not None:
        limits = MotionLimits(speed=share * largest_norm(free, 1).value, acceleration=1.3 * largest_norm(free, 2).value)
    found = solve(points, times, s, corridor=corridor, limits=limits)
    least = least_cost(points, times, s, corridor, limits, free.cost(s))
    assert least is not None
    assert found.cost >= least * (1 - 1e-6)
    assert found.cost <= least * 1.01
    assert (1 - found.gap) * found.cost <= found.curve.cost(s) * (1 + 1e-12)
    assert found.gap <= 1e-3
    assert outside(found, corridor, limits, points) <= 0.0
    assert min(found.margins.values()) >= 0.0
    assert found.jump < 1e-9
    np.testing.assert_allclose(found.curve(np.array([0.0, times[-1]])), points[[0, -1]], atol=1e-9)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(["tube", "boxes", "polytopes"]),
    radius=st.floats(0.02, 2.0),
    speed=st.floats(2.0, 20.0),
)
def test_nothing_is_exceeded_at_any_instant(seed: int, kind: str, radius: float, speed: float) -> None:
    points, times = tour(seed, 5, 2)
    knots, moments = subdivide(points, times, 0.6)
    corridor, limits = corridor_of(kind, knots, radius, seed), MotionLimits(speed=speed, acceleration=12.0 * speed)
    try:
        found = solve(knots, moments, corridor=corridor, limits=limits)
    except Infeasible:
        assume(False)
    assert outside(found, corridor, limits, knots) <= 0.0
    assert min(found.margins.values()) >= 0.0
    assert 0.0 <= found.gap <= 1e-3


def test_the_multipliers_bound_every_other_curve_within_the_tube() -> None:
    """Whatever lies in the tube costs at least (1 - gap) times as much: the curves of tighter tubes too."""
    knots, times = subdivide(*tour(3, 4, 2), 0.5)
    best = solve(knots, times, corridor=Tube(0.3))
    for radius in (0.29, 0.25, 0.1):
        assert solve(knots, times, corridor=Tube(radius)).cost >= (1 - best.gap) * best.cost


def test_vertical_limits_hold_the_third_axis_alone() -> None:
    points, times = np.array([[0.0, 0, 0], [2, 0, 1], [3, 0, 2], [4, 1, 1], [6, 1, 0]]), np.arange(5.0)
    climb = largest_norm(minimum(points, times), 1, (2,)).value
    found = solve(points, times, limits=MotionLimits(speed_vertical=0.99 * climb))
    assert largest_norm(found.curve, 1, (2,)).value <= 0.99 * climb
    np.testing.assert_allclose(
        found.curve.coefficients[:, :, :2], minimum(points, times).coefficients[:, :, :2], atol=2e-3
    )


def test_waypoints_led_through_are_met_within_the_tube() -> None:
    points, times = tour(5, 5, 3)
    through = [False, False, True, False, False]
    found = solve(points, times, corridor=Tube(1.0), through=through)
    np.testing.assert_allclose(found.curve(times[2]), points[2], atol=1e-9)
    assert solve(points, times, corridor=Tube(1.0)).cost < found.cost


def test_a_guide_and_a_tube_together_cost_the_least_of_both() -> None:
    points, times = subdivide(*tour(11, 4, 2), 0.7)
    plain, guided = (solve(points, times, corridor=Tube(0.4), guide=weight) for weight in (None, 1e4))
    assert guided.curve.cost(3) > plain.curve.cost(3)
    assert guided.margins["corridor"] >= 0.0
    assert guided.gap <= 1e-3
