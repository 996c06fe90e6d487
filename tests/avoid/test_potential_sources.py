"""What repels is the same wherever it is known from: a map, its distances on a lattice, or a scan."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.avoid.potential_sources import DistanceField, near_map, near_others, near_scan
from crosstrack.types import Array, Others, Scan, State
from crosstrack.world.shapes import Box, Cylinder, Sphere
from crosstrack.world.world import World

WORLD = World(
    (
        Cylinder((2.0, 0.5), 0.4, (-50.0, 50.0)),
        Sphere((-1.5, 1.0, 0.5), 0.6),
        Box((-3.0, -2.5, -3.0), (3.0, -2.0, 3.0)),
    )
)
HERE = np.array([0.2, -0.1, 0.3])


def expected(point: Array) -> list[float]:
    """Return the distances to the three obstacles, nearest first."""
    trunk = float(np.hypot(*(point[:2] - [2.0, 0.5]))) - 0.4
    ball = float(np.linalg.norm(point - [-1.5, 1.0, 0.5])) - 0.6
    return sorted([trunk, ball, point[1] + 2.0])


def test_map_gives_the_nearest_point_of_each_obstacle() -> None:
    near = near_map(WORLD, HERE, 3.0)
    faced = near.gaps[near.facing > 0.995]
    for gap in expected(HERE):
        assert np.abs(faced - gap).min() < 0.01
    assert near.gaps[0] == pytest.approx(expected(HERE)[0])
    assert (np.diff(near.gaps) >= 0).all()


def test_nothing_within_reach_is_nothing() -> None:
    assert len(near_map(WORLD, HERE, 0.5).gaps) == 0
    assert len(near_map(World(), HERE, 5.0).gaps) == 0


def test_distances_on_a_lattice_say_what_the_map_says() -> None:
    low, cell, counts = np.array([-4.0, -4.0, -2.0]), 0.1, (81, 81, 41)
    axes = [low[k] + cell * np.arange(counts[k]) for k in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    field = DistanceField(WORLD.distance(points).astype(np.float32), low, cell)
    spots = np.random.default_rng(3).uniform(-1.5, 1.5, (200, 3))
    assert np.abs(field.distance(spots) - WORLD.distance(spots)).max() < 0.06
    near, told = near_map(WORLD, HERE, 3.0), near_map(field, HERE, 3.0)
    assert told.gaps[0] == pytest.approx(near.gaps[0], abs=0.02)
    assert told.away[0] @ near.away[0] > 0.99


def test_scan_gives_the_same_as_the_map_however_the_vehicle_is_turned() -> None:
    count = 20000
    random = np.random.default_rng(0)
    ways = random.normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    attitude = np.array([0.2, -0.1, 0.5, 0.0])
    attitude[3] = np.sqrt(1 - attitude @ attitude)
    ranges = WORLD.cast(HERE, ways, 6.0)
    # The body sees a world that is turned the other way: quaternions xyzw, v' = v + 2 w q x v + 2 q x (q x v).
    q, w = -attitude[:3], attitude[3]
    seen = ways + 2 * w * np.cross(q, ways) + 2 * np.cross(q, np.cross(q, ways))
    scan = Scan(0.0, np.zeros(3), seen, ranges, 6.0)
    state = State(0.0, HERE, np.zeros(3), attitude, np.zeros(3))
    near, told = near_map(WORLD, HERE, 3.0), near_scan(scan, state, 3.0)
    assert told.gaps[0] == pytest.approx(near.gaps[0], abs=0.01)
    assert told.away[0] @ near.away[0] > 0.99
    for gap in expected(HERE):
        assert np.abs(told.gaps - gap).min() < 0.02


@settings(max_examples=40)
@given(st.floats(-3, 3), st.floats(-20, 20), st.floats(-20, 20))
def test_what_repels_turns_and_moves_with_the_world(angle: float, x: float, y: float) -> None:
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    shift = np.array([x, y, 0.0])
    middles = np.array([[2.0, 0.5, 0.0], [-0.7, 1.6, 0.0]])
    there = turn @ HERE + shift
    moved = World(tuple(Cylinder((float(m[0]), float(m[1])), 0.4, (-50.0, 50.0)) for m in middles @ turn.T + shift))
    near = near_map(moved, there, 3.0, planar=True)
    offsets = middles @ turn.T + shift - there
    gaps = np.linalg.norm(offsets[:, :2], axis=1) - 0.4
    nearest = int(np.argmin(gaps))
    assert near.gaps[0] == pytest.approx(gaps[nearest], abs=1e-9)
    assert near.away[0, :2] == pytest.approx(-offsets[nearest, :2] / (gaps[nearest] + 0.4), abs=1e-6)
    assert np.abs(near.gaps - gaps.max()).min() < 0.05


def test_moving_balls_repel_from_their_surface() -> None:
    others = Others(
        np.array([[2.2, -0.1, 0.3], [9.0, 0.0, 0.0]]), np.array([[-1.0, 0, 0], [0, 0, 0]]), np.array([0.5, 0.5]),
        np.array([True, False]),
    )  # fmt: skip
    near, velocity = near_others(others, HERE, 3.0)
    assert near.gaps == pytest.approx([1.5])
    assert near.away == pytest.approx(np.array([[-1.0, 0.0, 0.0]]))
    assert velocity == pytest.approx(np.array([[-1.0, 0.0, 0.0]]))
