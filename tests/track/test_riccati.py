"""Discretisation against integration in time, the Riccati recursion against one problem of least squares."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from crosstrack.track.riccati import backwards, discretised
from crosstrack.types import Array


def random_system(seed: int, states: int = 5, inputs: int = 2) -> tuple[Array, Array, Array, Array, Array]:
    """Return A, B of six steps, costs of each, and a cost at the end."""
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(6, states, states)), rng.normal(size=(6, states, inputs))
    end = rng.normal(size=(states, states))
    return a, b, rng.uniform(0.1, 3, (6, states)), rng.uniform(0.1, 3, (6, inputs)), end @ end.T


@given(st.integers(0, 2**32 - 1))
def test_the_recursion_is_the_least_squares_answer_over_all_inputs_at_once(seed: int) -> None:
    a, b, q, r, end = random_system(seed)
    gains, cost = backwards(a, b, q, r, end)
    x0 = np.random.default_rng(seed + 1).normal(size=5)
    # Every state is linear in the start and the inputs: stack the roots of all costs.
    free, forced, rows, right = np.eye(5), np.zeros((5, 12)), [], []
    for k in range(6):
        rows.append(np.sqrt(q[k])[:, None] * forced)
        right.append(np.sqrt(q[k]) * (free @ x0))
        weight = np.zeros((2, 12))
        weight[:, 2 * k : 2 * k + 2] = np.diag(np.sqrt(r[k]))
        rows.append(weight)
        right.append(np.zeros(2))
        free, forced = a[k] @ free, a[k] @ forced
        forced[:, 2 * k : 2 * k + 2] += b[k]
    values, vectors = np.linalg.eigh(end)
    root = np.sqrt(np.maximum(values, 0))[:, None] * vectors.T
    rows.append(root @ forced)
    right.append(root @ free @ x0)
    inputs, _, _, _ = np.linalg.lstsq(np.vstack(rows), -np.concatenate(right), rcond=None)
    np.testing.assert_allclose(-gains[0] @ x0, inputs[:2], rtol=1e-6, atol=1e-8)
    least = np.sum((np.vstack(rows) @ inputs + np.concatenate(right)) ** 2)
    assert x0 @ cost @ x0 == pytest.approx(least, rel=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_discretisation_is_the_solution_with_the_input_held(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = 3 * rng.normal(size=(6, 6)), 3 * rng.normal(size=(6, 2))
    x, u = rng.normal(size=6), rng.normal(size=2)
    after = solve_ivp(lambda _, y: a @ y + b @ u, (0, 0.05), x, rtol=1e-11, atol=1e-12).y[:, -1]
    exact_a, exact_b = discretised(a, b, 0.05)
    np.testing.assert_allclose(exact_a @ x + exact_b @ u, after, atol=1e-8)
