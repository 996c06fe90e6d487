"""The nearest command that no barrier forbids, and the barrier itself."""

import math

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize

from crosstrack.avoid.barrier import least_acceleration, nearest
from crosstrack.types import Array

seeds = st.integers(0, 2**32 - 1)


def half_spaces(seed: int) -> tuple[Array, Array, Array]:
    """Draw half-spaces that have a point in common, and a vector."""
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 5))
    normals = random.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    common = 3 * random.normal(size=3)
    return 5 * random.normal(size=3), normals, normals @ common - random.uniform(0, 1, count)


@given(seeds)
def test_the_projection_is_that_of_a_general_solver(seed: int) -> None:
    asked, normals, least = half_spaces(seed)
    assume((normals @ normals.T).min() > -0.95)
    found = nearest(asked, normals, least)
    limits = {"type": "ineq", "fun": lambda u: normals @ u - least}
    oracle = minimize(lambda u: 0.5 * ((u - asked) ** 2).sum(), asked, constraints=limits, method="SLSQP", tol=1e-12)
    gap = float(np.linalg.norm(found - asked) - np.linalg.norm(oracle.x - asked))
    assert gap < 1e-3 * (1 + np.linalg.norm(asked - found))
    assert (normals @ found - least).min() > -2e-2 * (1 + np.linalg.norm(asked - found))


def test_what_is_allowed_is_left_alone() -> None:
    asked = np.array([1.0, 2.0, 3.0])
    assert (nearest(asked, np.array([[1.0, 0, 0]]), np.array([0.5])) == asked).all()


@given(st.floats(0.5, 12.0), st.floats(0.0, 1.0), st.floats(1.0, 10.0), st.floats(2.0, 10.0))
def test_the_barrier_is_kept_by_a_double_integrator(room: float, share: float, brakes: float, gain: float) -> None:
    """From inside the barrier, pushing on as fast as it allows, the room is used up but never gone beyond."""
    end = brakes / gain**2
    most = gain * room if room <= end else math.sqrt(2 * brakes * (room - end / 2))
    speed, h = -share * most, 1e-3
    for _ in range(6000):
        u = max(-20.0, least_acceleration(room, speed, brakes, gain))
        assert u < 1.05 * brakes + 0.1 or speed > -most * 1e-3
        room, speed = room + speed * h + 0.5 * u * h * h, speed + u * h
        assert room > -2e-3
    assert room < 0.2
