"""The shortest way that keeps a clearance: closed forms, a search on a grid, and what must hold of any."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from crosstrack.campaign.avoidance.families import FAMILIES, Arena
from crosstrack.campaign.avoidance.optimum import optimum
from crosstrack.campaign.avoidance.trial import built
from crosstrack.types import Array
from crosstrack.world.shapes import Box, Cylinder, Shape, Sphere
from crosstrack.world.world import World

TOP = 3.0
START, GOAL = np.array([0.0, 0.0]), np.array([10.0, 0.0])


def disc(x: float, y: float, radius: float) -> Cylinder:
    return Cylinder((x, y), radius, (0.0, TOP))


def box(x0: float, y0: float, x1: float, y1: float) -> Box:
    return Box((x0, y0, 0.0), (x1, y1, TOP))


def world(*shapes: Shape, around: tuple[float, float, float, float] = (-5.0, -20.0, 15.0, 20.0)) -> World:
    return World(shapes, bounds=np.array([[*around[:2], 0.0], [*around[2:], TOP]]))


def length(made: World, clearance: float = 0.25, start: Array = START, goal: Array = GOAL) -> float:
    found = optimum(made, start, goal, clearance)
    return math.inf if found is None else found.length


def test_without_obstacles_it_is_straight() -> None:
    found = optimum(world(), START, GOAL, 0.25)
    assert found is not None
    assert found.length == 10.0
    np.testing.assert_array_equal(found.points, [START, GOAL])


@settings(max_examples=50, deadline=None)
@given(st.floats(0.1, 3.0), st.floats(0.0, 0.5), st.floats(-2.9, 2.9))
def test_one_disc_is_passed_by_tangent_arc_tangent(radius: float, clearance: float, aside: float) -> None:
    """From p to q around a circle of radius R: two tangents, and the arc between where they touch."""
    around = radius + clearance
    reach = math.hypot(5.0, aside)
    expected = 10.0
    if abs(aside) < around:
        turn = 2 * math.atan2(5.0, abs(aside)) - 2 * math.acos(around / reach)
        expected = 2 * math.sqrt(reach**2 - around**2) + around * turn
    assert length(world(disc(5.0, aside, radius)), clearance) == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_a_wall_is_passed_at_its_nearer_end() -> None:
    """Around the corners of a wall: two tangents to circles of the clearance, two arcs, the side of the wall."""
    c, half, end = 0.25, 0.1, 2.0
    reach = math.hypot(5.0 - half, end)
    lift = math.atan2(end, 5.0 - half)
    tangent = math.sqrt(reach**2 - c**2)
    turn = lift + math.asin(c / reach)
    expected = 2 * tangent + 2 * c * turn + 2 * half
    assert length(world(box(5 - half, -3.0, 5 + half, end)), c) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("width", "open_"), [(0.5, True), (0.499, False)])
def test_a_gap_is_passed_where_it_is_twice_the_clearance(width: float, open_: bool) -> None:
    wall = world(box(5, -20, 5.2, 1 - width / 2), box(5, 1 + width / 2, 5.2, 20), around=(-5.0, -20.0, 15.0, 20.0))
    assert (length(wall) < math.inf) is open_


def test_bounds_keep_their_distance_too() -> None:
    blocked = world(disc(5.0, 0.0, 2.0), around=(-1.0, -2.7, 11.0, 2.4))
    below = world(disc(5.0, 0.0, 2.0), around=(-1.0, -20.0, 11.0, 2.4))
    assert length(blocked) == pytest.approx(length(below))
    assert length(world(disc(5.0, 0.0, 2.0), around=(-1.0, -2.4, 11.0, 2.4))) == math.inf
    assert length(world(around=(0.1, -1.0, 11.0, 1.0))) == math.inf


def test_a_start_or_goal_too_near_has_no_way() -> None:
    assert length(world(disc(0.0, 0.6, 0.4))) == math.inf
    assert length(world(box(9.0, -1.0, 11.0, 1.0))) == math.inf
    assert length(world(disc(10.0, 0.0, 3.0), disc(0.0, 0.0, 0.1))) == math.inf


def test_a_goal_behind_four_walls_has_no_way() -> None:
    walls = [box(8, -2, 12, -1.8), box(8, 1.8, 12, 2), box(8, -2, 8.2, 2), box(11.8, -2, 12, 2)]
    assert length(world(*walls)) == math.inf
    assert length(world(*walls[1:])) < math.inf


def test_more_than_upright_obstacles_are_refused() -> None:
    with pytest.raises(ValueError, match="cylinders and boxes"):
        length(world(Sphere((5.0, 0.0, 1.0), 0.5)))
    with pytest.raises(ValueError, match="to the top"):
        length(world(Cylinder((5.0, 0.0), 0.5, (0.0, 2.0))))


def scattered(seed: int, discs: int, boxes: int) -> list[Shape]:
    draw = np.random.default_rng(seed)
    shapes: list[Shape] = [disc(*draw.uniform((1.5, -3.0, 0.1), (8.5, 3.0, 0.8))) for _ in range(discs)]
    for _ in range(boxes):
        corner = draw.uniform((1.5, -3.0), (7.0, 2.0))
        shapes.append(box(*corner, *(corner + draw.uniform(0.1, 1.5, size=2))))
    return shapes


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 10), st.integers(0, 5))
def test_it_keeps_the_clearance_and_is_as_long_as_it_says(seed: int, discs: int, boxes: int) -> None:
    made = world(*scattered(seed, discs, boxes))
    found = optimum(made, START, GOAL, 0.25)
    assert found is not None  # there is room around everything
    points = np.column_stack([found.points, np.full(len(found.points), 1.5)])
    assert made.distance(points).min() >= 0.25 - 1e-6
    chords = np.linalg.norm(np.diff(found.points, axis=0), axis=1).sum()
    assert chords <= found.length + 1e-9
    assert found.length <= chords * 1.001  # an arc of 5 degrees is 0.03 % longer than its chord
    between = [made.swept(a, b) for a, b in pairwise(points)]
    assert min(between) >= 0.25 - 0.0015  # the sagitta of 5 degrees on the largest circle
    assert (found.points[0] == START).all()
    np.testing.assert_allclose(found.points[-1], GOAL, atol=1e-12)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 8), st.integers(0, 4), st.floats(0.01, 0.4), st.floats(0.01, 0.3))
def test_more_clearance_and_more_obstacles_are_never_shorter(
    seed: int, discs: int, boxes: int, clearance: float, more: float
) -> None:
    shapes = scattered(seed, discs, boxes)
    base = length(world(*shapes), clearance)
    assert length(world(*shapes), clearance + more) >= base - 1e-6
    assert length(world(*shapes, *scattered(seed + 1, 1, 1)), clearance) >= base - 1e-6


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 8), st.integers(0, 4))
def test_it_is_the_same_backwards_and_mirrored(seed: int, discs: int, boxes: int) -> None:
    made = world(*scattered(seed, discs, boxes))
    mirrored = [
        disc(one.center[0], -one.center[1], one.radius)
        if isinstance(one, Cylinder)
        else box(one.min[0], -one.max[1], one.max[0], -one.min[1])
        for one in made.shapes
        if isinstance(one, Cylinder | Box)
    ]
    forth = length(made)
    assert length(made, start=GOAL, goal=START) == pytest.approx(forth, abs=1e-7)
    assert length(world(*mirrored)) == pytest.approx(forth, abs=1e-7)


STEPS = [(1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1), (1, 3), (3, 1), (1, -3), (3, -1)]
"""cells; with their opposites, 24 directions at most 18.4 degrees apart"""
DETOUR = 1 / math.cos(math.radians(18.44) / 2)
"""of a way along these directions to the straight one, at most"""


def on_grid(made: World, low: Array, counts: tuple[int, int], cell: float, clearance: float) -> float:
    """Return the length of the shortest way from the first to the last point of a grid, each step kept clear."""
    x, y = np.meshgrid(np.arange(counts[0]) * cell + low[0], np.arange(counts[1]) * cell + low[1], indexing="ij")
    index = np.arange(x.size).reshape(counts)
    rows, columns, weights = [], [], []
    for i, j in STEPS:
        a = index[: counts[0] - i, max(0, -j) : counts[1] - max(0, j)].ravel()
        b = index[i:, max(0, j) : counts[1] + min(0, j)].ravel()
        pieces = np.linspace(0, 1, 9)[:, None]
        px = x.ravel()[a] + pieces * i * cell
        py = y.ravel()[a] + pieces * j * cell
        free = made.distance(np.stack([px, py, np.full_like(px, 1.5)], axis=-1)).min(axis=0) >= clearance
        rows.append(a[free])
        columns.append(b[free])
        weights.append(np.full(free.sum(), math.hypot(i, j) * cell))
    graph = csr_matrix(
        (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns))), shape=(x.size, x.size)
    )
    return float(dijkstra(graph, directed=False, indices=0)[-1])


@pytest.mark.parametrize("seed", range(6))
def test_a_search_on_a_grid_is_a_little_longer(seed: int) -> None:
    """What a grid finds is a way, so not shorter; a way with more clearance can be followed on it, a detour longer."""
    draw, cell, clearance = np.random.default_rng(seed), 0.05, 0.15
    shapes: list[Shape] = [disc(*draw.uniform((0.8, 0.0, 0.1), (5.2, 4.0, 0.5))) for _ in range(9)]
    for _ in range(3):
        corner = draw.uniform((0.8, 0.0), (4.5, 3.5))
        shapes.append(box(*corner, *(corner + draw.uniform(0.1, 1.2, size=2))))
    start, goal = np.array([0.0, 0.0]), np.array([6.0, 4.0])
    found = on_grid(world(*shapes), start, (121, 81), cell, clearance)
    unchecked = 0.5 * math.hypot(3, 1) * cell / 8
    assert length(world(*shapes), clearance - unchecked, start, goal) <= found + 1e-9
    more = clearance + 2 * cell
    upper = length(world(*shapes, around=(-more, -more, 6 + more, 4 + more)), more, start, goal)
    assert found <= upper * DETOUR + 8 * cell


@pytest.mark.parametrize("family", FAMILIES)
def test_arenas_have_a_way_but_the_closed_ones(family: str) -> None:
    found = [shortest(FAMILIES[family](family, seed)) for seed in range(6)]
    assert [one < math.inf for one in found] == [family != "closed"] * 6


def shortest(arena: Arena) -> float:
    return length(built(arena.world), 0.25, np.array(arena.start), np.array(arena.goal))
