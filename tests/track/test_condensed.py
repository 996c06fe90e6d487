"""Condensed programs against Riccati recursions and against the same problems solved uncondensed by a conic solver."""

from typing import Any

import clarabel
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.linalg import solve_discrete_are

from crosstrack.track import condensed
from crosstrack.track.condensed import UNBOUNDED, Program, condense
from crosstrack.types import Array

SEEDS = st.integers(0, 2**32 - 1)


def optimum(cost: Array, linear: Array, rows: Array, upper: Array, equal: int = 0) -> Array:
    """Minimise ½ xᵀPx + qᵀx while the first rows hold with equality and the others are at most their bounds."""
    options: Any = clarabel.DefaultSettings()
    options.verbose = False
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = 1e-10
    cones = [clarabel.ZeroConeT(equal), clarabel.NonnegativeConeT(len(rows) - equal)]
    triangle = sparse.triu(sparse.csc_matrix(cost), format="csc")
    solver = clarabel.DefaultSolver(triangle, linear, sparse.csc_matrix(rows), upper, cones, options)
    found = solver.solve()
    assert str(found.status) == "Solved"
    return np.array(found.x)


def plant(rng: np.random.Generator) -> tuple[Array, Array, Array, Array]:
    """Return dynamics, inputs, and weights of state and input, of 3 states and 2 inputs."""
    root = rng.normal(size=(3, 3))
    return np.eye(3) + 0.3 * rng.normal(size=(3, 3)), rng.normal(size=(3, 2)), root @ root.T, np.diag([1.0, 0.5])


def lqr(a: Array, b: Array, q: Array, r: Array, p: Array, steps: int) -> list[Array]:
    """Return the gains of finite horizon by the Riccati recursion, first step first."""
    gains = []
    for _ in range(steps):
        gain = np.asarray(np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a), np.float64)
        p = q + a.T @ p @ (a - b @ gain)
        gains.append(gain)
    return gains[::-1]


@given(SEEDS)
@settings(max_examples=30)
def test_without_bounds_it_is_the_lqr_of_finite_horizon(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, q, r = plant(rng)
    made = condense(a, b, q, r, 2 * q, 7)
    start: Array = rng.normal(size=3)
    inputs = -np.linalg.solve(made.hessian, made.coupling @ start).reshape(7, 2)
    state = start
    for k, gain in enumerate(lqr(a, b, q, r, 2 * q, 7)):
        np.testing.assert_allclose(inputs[k], -gain @ state, atol=1e-8 * (1 + np.abs(state).max()))
        state = a @ state + b @ inputs[k]
        predicted = made.free[k] @ start + made.forced[k] @ inputs.ravel()
        np.testing.assert_allclose(predicted, state, atol=1e-8 * (1 + np.abs(state).max()))


@pytest.mark.parametrize("steps", [1, 3, 10])
def test_the_cost_to_go_makes_every_horizon_infinite(steps: int) -> None:
    a, b, q, r = plant(np.random.default_rng(5))
    p = solve_discrete_are(a, b, q, r)
    made = condense(a, b, q, r, p, steps)
    forever = np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a)
    np.testing.assert_allclose(np.linalg.solve(made.hessian, made.coupling)[:2], forever, rtol=1e-8, atol=1e-9)


@given(SEEDS)
@settings(max_examples=30)
def test_bounded_as_the_uncondensed_problem(seed: int) -> None:
    """Inputs within ±0.5, and the first state at most 1 at every step, at a price where it cannot be."""
    rng, steps, price = np.random.default_rng(seed), 5, 50.0
    a, b, q, r = plant(rng)
    start: Array = 2 * rng.normal(size=3)
    made = condense(a, b, q, r, 3 * q, steps)
    program = Program(
        made.hessian, np.vstack([np.eye(10), made.forced[:, 0]]), np.repeat([False, True], [10, steps]), price
    )
    lower = np.concatenate([np.full(10, -0.5), np.full(steps, -UNBOUNDED)])
    upper = np.concatenate([np.full(10, 0.5), 1 - made.free[:, 0] @ start])
    found = program.solve(made.coupling @ start, lower, upper, program.flags)
    assert found.found
    # Variables: the inputs, the states after each step, the excesses.
    cost = np.zeros((30, 30))
    cost[:10, :10] = np.kron(np.eye(steps), r)
    cost[10:25, 10:25] = np.kron(np.diag([1.0] * (steps - 1) + [3.0]), q)
    cost[25:, 25:] = price * np.eye(steps)
    step = np.zeros((15, 30))
    step[:, :10] = np.kron(np.eye(steps), -b)
    step[:, 10:25] = np.eye(15) - np.kron(np.eye(steps, k=-1), a)
    first = np.concatenate([a @ start, np.zeros(12)])
    reach = np.zeros((steps, 30))
    reach[:, 10:25], reach[:, 25:] = np.kron(np.eye(steps), [1.0, 0, 0]), -np.eye(steps)
    box = np.eye(10, 30)
    rows = np.vstack([step, box, -box, reach])
    best = optimum(cost, np.zeros(30), rows, np.concatenate([first, np.full(20, 0.5), np.ones(steps)]), equal=15)
    np.testing.assert_allclose(found.inputs, best[:10], atol=1e-6)


def random_program(rng: np.random.Generator) -> tuple[Program, list[tuple[Array, Array, Array]], Array, Array]:
    """Return a program half of whose rows are soft, and two questions to it; its matrices."""
    root, rows = rng.normal(size=(8, 8)), rng.normal(size=(20, 8))
    hessian = root @ root.T + np.eye(8)
    program = Program(hessian, rows, np.arange(20) >= 10, 100.0)
    questions = []
    for _ in range(2):
        upper = rng.uniform(-0.5, 1.0, 20)
        upper[:10] = np.abs(upper[:10])  # so that the hard rows allow zero
        lower = np.where(rng.random(20) < 0.5, -UNBOUNDED, np.minimum(-0.1, upper - 0.2))
        linear: Array = 10 * rng.normal(size=8)
        questions.append((linear, lower, upper))
    return program, questions, hessian, rows


@given(SEEDS)
@settings(max_examples=40)
def test_soft_and_hard_rows_as_with_slack_written_out(seed: int) -> None:
    program, ((linear, lower, upper), _), hessian, rows = random_program(np.random.default_rng(seed))
    answer = program.solve(linear, lower, upper, program.flags)
    slack = np.vstack([np.zeros((10, 10)), np.eye(10)])
    cost = np.block([[hessian, np.zeros((8, 10))], [np.zeros((10, 8)), 100 * np.eye(10)]])
    sides, bounds = np.block([[rows, -slack], [-rows, -slack]]), np.concatenate([upper, -lower])
    near = bounds < UNBOUNDED
    best = optimum(cost, np.concatenate([linear, np.zeros(10)]), sides[near], bounds[near])
    np.testing.assert_allclose(answer.inputs, best[:8], atol=1e-6)
    hard = (rows @ answer.inputs)[:10]
    assert (hard <= upper[:10] + 1e-5).all()
    assert (hard >= lower[:10] - 1e-5).all()


@given(SEEDS)
@settings(max_examples=40)
def test_where_it_begins_changes_the_work_only(seed: int) -> None:
    program, (first, second), _, _ = random_program(np.random.default_rng(seed))
    cold = program.solve(*second, program.flags)
    before = program.solve(*first, program.flags)
    warm = program.solve(*second, before.active)
    again = program.solve(*second, warm.active)
    program.solve(*first, program.flags)
    replayed = program.solve(*second, before.active)
    np.testing.assert_allclose(warm.inputs, cold.inputs, atol=1e-9)
    np.testing.assert_allclose(again.inputs, cold.inputs, atol=1e-9)
    assert again.iterations <= 2
    np.testing.assert_array_equal(replayed.inputs, warm.inputs)  # what it solved in between leaves no trace


def test_giving_up_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(condensed, "ITERATIONS", 2)
    program = Program(np.eye(6), np.eye(6), np.zeros(6, bool), 1.0)
    ones = np.ones(6)
    within: Array = 0.5 * ones
    assert program.solve(within, -ones, ones, program.flags).found
    assert not program.solve(7 * np.arange(6.0), -ones, ones, program.flags).found
