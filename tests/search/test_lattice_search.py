"""A* against Dijkstra's search of scipy on the same graph."""

import heapq
import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from crosstrack.protocols import Field
from crosstrack.search.astar import ENCLOSED, FOUND, NONE, search
from crosstrack.search.heap import lower, pop
from crosstrack.search.remaining import remaining

CELL, WANTED, DOUBT = 0.1, 0.25, 3.0


def field(seed: int, counts: tuple[int, int, int], density: float) -> Field:
    """Return distances that vary along the lattice, with some points and all sides barred."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(0.05, 0.5, counts).astype(np.float32)
    values[rng.random(counts) < density] = -1.0
    for side in (0, -1):
        values[side] = values[:, side] = values[:, :, side] = -1.0
    return values


def graph(values: Field) -> coo_matrix:
    """Return the cost, in cells, of going from one point to another."""
    index = np.arange(values.size).reshape(values.shape)
    rows, columns, costs = [], [], []
    for move in itertools.product((-1, 0, 1), repeat=3):
        if move == (0, 0, 0):
            continue
        length = float(np.linalg.norm(move))
        here = tuple(slice(max(-m, 0), n - max(m, 0)) for m, n in zip(move, values.shape, strict=True))
        there = tuple(slice(max(m, 0), n - max(-m, 0)) for m, n in zip(move, values.shape, strict=True))
        a, b = values[here].astype(float), values[there].astype(float)
        free = (a >= 0) & (b >= 0) & (a + b >= length * CELL)
        rows.append(index[here][free])
        columns.append(index[there][free])
        costs.append(length * (1 + DOUBT / WANTED * np.maximum(WANTED - b[free], 0)))
    size = values.size
    return coo_matrix((np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(size, size))


def found(values: Field, start: int, goal: int) -> tuple[int, NDArray[np.int32]]:
    freest = np.ascontiguousarray(values.max(axis=2))
    left = remaining(freest, CELL, WANTED, DOUBT, goal // values.shape[2])
    status, way, _ = search(values, left, CELL, WANTED, DOUBT, start, goal)
    return status, way


@pytest.mark.parametrize("seed", range(12))
def test_the_cheapest_way_of_the_lattice_is_found_or_none_is(seed: int) -> None:
    values = field(seed, (12, 11, 6), 0.1 + 0.06 * seed)
    free = np.flatnonzero(values.ravel() >= 0)
    start, goal = np.random.default_rng(seed).choice(free, 2, replace=False)
    costs = graph(values).tocsr()
    best = dijkstra(costs, indices=start)[goal]
    status, way = found(values, int(start), int(goal))
    assert (status == FOUND) == np.isfinite(best)
    if status == FOUND:
        assert way[0] == start
        assert way[-1] == goal
        paid = np.asarray(costs[way[:-1], way[1:]]).ravel()
        assert (paid > 0).all()
        assert paid.sum() == pytest.approx(best, rel=2e-3)


def test_the_estimate_never_says_too_much() -> None:
    values = field(5, (12, 11, 6), 0.3)
    goal = int(np.flatnonzero(values.ravel() >= 0)[100])
    to_goal = dijkstra(graph(values).tocsr().T, indices=goal)
    left = remaining(np.ascontiguousarray(values.max(axis=2)), CELL, WANTED, DOUBT, goal // 6)
    columns, heights = np.divmod(np.arange(values.size), 6)
    estimate = np.hypot(left[columns], heights - goal % 6)
    reached = np.isfinite(to_goal)
    assert reached.sum() > 100
    assert (estimate[reached] <= to_goal[reached] + 1e-4).all()


def closed_box(around_goal: bool) -> tuple[Field, int, int]:
    values = np.full((60, 60, 20), 0.5, dtype=np.float32)
    for side in (0, -1):
        values[side] = values[:, side] = values[:, :, side] = -1.0
    shell = np.zeros(values.shape, bool)
    shell[40:51, 40:51, 4:15] = True
    shell[41:50, 41:50, 5:14] = False
    values[shell] = -1.0
    inside, outside = np.ravel_multi_index((45, 45, 9), values.shape), np.ravel_multi_index((5, 5, 9), values.shape)
    return (values, int(outside), int(inside)) if around_goal else (values, int(inside), int(outside))


def test_a_goal_in_a_box_is_given_up_after_as_many_points_as_the_box_holds() -> None:
    values, start, goal = closed_box(around_goal=True)
    left = remaining(np.ascontiguousarray(values.max(axis=2)), CELL, WANTED, DOUBT, goal // 20)
    status, inside, seen = search(values, left, CELL, WANTED, DOUBT, start, goal)
    assert status == ENCLOSED
    assert len(inside) == 9**3
    assert seen <= 9**3 + 1


def test_a_start_in_a_box_is_given_up_with_the_points_of_the_box() -> None:
    values, start, goal = closed_box(around_goal=False)
    status, inside = found(values, start, goal)
    assert status == NONE
    assert len(inside) == 9**3


@pytest.mark.parametrize("seed", range(5))
def test_the_heap_gives_cells_in_the_order_of_their_last_keys(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = 300
    heap, place = np.empty(size, np.int32), np.full(size, -1, np.int32)
    keys, count = np.empty(size, np.float32), 0
    expected: dict[int, float] = {}
    for cell in rng.integers(0, size, 900):
        key = float(np.float32(rng.random()))
        if key < expected.get(int(cell), np.inf):
            expected[int(cell)] = key
            count = lower(int(cell), key, heap, place, keys, count)
    order = [(key, cell) for cell, key in expected.items()]
    heapq.heapify(order)
    assert count == len(expected)
    for left in range(count, 0, -1):
        assert keys[pop(heap, place, keys, left)] == heapq.heappop(order)[0]
