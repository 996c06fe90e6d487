"""Discrete linear-quadratic regulation: exact discretisation, and the Riccati equation at rest and backwards in time.

For x(k+1) = A x(k) + B u(k) and the cost Σ xᵀ Q x + uᵀ R u, the cost to go is xᵀ P x and the best input -K x with

    K = (R + Bᵀ P B)⁻¹ Bᵀ P A,    P(k) = Q + Aᵀ P(k+1) (A - B K)

Anderson, Moore 1990 (Optimal Control: Linear Quadratic Methods), ch. 2.
"""

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from crosstrack.errors import InputError, Problem
from crosstrack.types import Array


def discretised(a: Array, b: Array, period: float) -> tuple[Array, Array]:
    """Return A and B of x' = a x + b u sampled every `period` (s) with the input held, exactly.

    They are the upper blocks of exp([a b; 0 0] T) (Van Loan 1978).

    Args:
        a: (..., n, n) 1/s
        b: (..., n, m) 1/s
        period: s
    """
    states, inputs = b.shape[-2:]
    both = np.zeros((*a.shape[:-2], states + inputs, states + inputs))
    both[..., :states, :states], both[..., :states, states:] = a * period, b * period
    exact = expm(both)
    return exact[..., :states, :states], exact[..., :states, states:]


def stationary(a: Array, b: Array, q: Array, r: Array) -> tuple[Array, Array]:
    """Return gain K (m, n) and cost to go P (n, n) of the infinite horizon.

    Args:
        a: (n, n), of one step
        b: (n, m), of one step
        q: (n, n), cost of the state at a step
        r: (m, m), cost of the input at a step

    Raises:
        InputError: the costs are so far apart that there is no answer in floating point.
    """
    try:
        p = solve_discrete_are(a, b, q, r)
    except (np.linalg.LinAlgError, ValueError) as error:
        message = f"the Riccati equation has no answer, allowed deviations are too far apart: {error}"
        raise InputError("tracker", [Problem("weights", message)]) from None
    return np.linalg.solve(r + b.T @ p @ b, b.T @ p @ a), p


def backwards(a: Array, b: Array, q: Array, r: Array, cost: Array) -> tuple[Array, Array]:
    """Return the gains (steps, m, n) of a stretch of time, and the cost to go (n, n) at its beginning.

    Args:
        a: (steps, n, n), of each step
        b: (steps, n, m), of each step
        q: (steps, n), costs of the squared states
        r: (steps, m), costs of the squared inputs
        cost: (n, n), to go at the end
    """
    gains = np.empty((len(a), b.shape[2], b.shape[1]))
    for k in reversed(range(len(a))):
        pa, pb = cost @ a[k], cost @ b[k]
        gains[k] = np.linalg.solve(np.diag(r[k]) + b[k].T @ pb, b[k].T @ pa)
        cost = np.diag(q[k]) + a[k].T @ (pa - pb @ gains[k])
        cost = 0.5 * (cost + cost.T)
    return gains, cost
