"""Condensed quadratic programs: a linear prediction with the states eliminated, solved with a warm start."""

from dataclasses import dataclass

import daqp
import numpy as np
from numpy.typing import NDArray

from crosstrack.types import Array

Flags = NDArray[np.int32]

UNBOUNDED = 1e30
"""a bound that the solver takes for none"""
ITERATIONS = 300
"""most changes of the active set in one solution"""
ACTIVE, LOWER, SOFT = 1, 2, 8
"""flags of the solver: held with equality, at the lower bound, may be exceeded at a cost"""


@dataclass(frozen=True, eq=False)
class Condensed:
    """The cost and the states of a prediction as functions of the inputs and of the state it begins with.

    With U the inputs of all steps one after another and x₀ the state, the cost is ½ UᵀHU + UᵀFx₀ + (a constant), and
    the states after 1, 2 ... N steps are x_k = A_k x₀ + B_k U.
    """

    hessian: Array
    """(steps m, steps m), H"""
    coupling: Array
    """(steps m, n), F"""
    free: Array
    """(steps, n, n), A_k"""
    forced: Array
    """(steps, n, steps m), B_k"""


def condense(dynamics: Array, inputs: Array, weight: Array, effort: Array, final: Array, steps: int) -> Condensed:
    """Eliminate the states of x_{k+1} = A x_k + B u_k from Σ ½ (x_kᵀQx_k + u_kᵀRu_k) + ½ x_NᵀPx_N, k = 0 ... N-1.

    Args:
        dynamics: (n, n), A
        inputs: (n, m), B
        weight: (n, n), Q
        effort: (m, m), R, positive definite
        final: (n, n), P
        steps: N
    """
    n, m = inputs.shape
    free, forced = np.empty((steps, n, n)), np.zeros((steps, n, steps * m))
    power, response = np.eye(n), np.zeros((n, steps * m))
    hessian, coupling = np.kron(np.eye(steps), effort), np.zeros((steps * m, n))
    for k in range(steps):
        power, response = dynamics @ power, dynamics @ response
        response[:, k * m : (k + 1) * m] = inputs
        free[k], forced[k] = power, response
        cost = weight if k < steps - 1 else final
        hessian += response.T @ cost @ response
        coupling += response.T @ cost @ power
    return Condensed(0.5 * (hessian + hessian.T), coupling, free, forced)


@dataclass(frozen=True, eq=False)
class Solution:
    """What a program answers."""

    inputs: Array
    """(n,)"""
    active: Flags
    """(rows,) flags of the rows that are held with equality: where the next solution begins"""
    found: bool
    """whether this is the optimum; otherwise the solver gave up, and the inputs mean nothing"""
    iterations: int
    """changes of the active set"""


class Program:
    """Minimise ½ uᵀHu + fᵀu while l ≤ Gu ≤ h, again and again with other f, l, h.

    Rows may be soft: exceeding one by ε then costs ½ w ε². The solver (Arnström, Bemporad, Axehill 2022, IEEE TAC
    67(8), a dual active-set method) keeps its matrices between solutions and begins with the active set it is given.
    It changes that set 300 times at most.

    Attributes:
        flags: (m,), of no active set, where a first solution begins
    """

    def __init__(self, hessian: Array, rows: Array, soft: NDArray[np.bool_], price: float) -> None:
        """Prepare the solver.

        Args:
            hessian: (n, n), H, positive definite
            rows: (m, n), G
            soft: (m,) bool, which rows are soft
            price: w
        """
        self.flags = np.where(soft, SOFT, 0).astype(np.int32)
        self.solver = daqp.Model()
        far = np.full(len(rows), UNBOUNDED)
        self.solver.setup(np.ascontiguousarray(hessian), np.zeros(len(hessian)), rows, far, -far, self.flags)
        softness = np.full(len(rows), 1 / price)
        self.solver.soft_weights(softness, softness)
        self.solver.settings = {"iter_limit": ITERATIONS}

    def solve(self, linear: Array, lower: Array, upper: Array, active: Flags) -> Solution:
        """Return the minimum; the same for every active set to begin with, which only saves time.

        Args:
            linear: (n,), f
            lower: (m,), l
            upper: (m,), h
            active: (m,), of the solution before, or `flags`
        """
        self.solver.update(f=linear, bupper=upper, blower=lower, sense=active)
        inputs, _, verdict, about = self.solver.solve()
        held = about["lam"]
        flags = self.flags + np.where(held > 0, ACTIVE, np.where(held < 0, ACTIVE + LOWER, 0)).astype(np.int32)
        return Solution(inputs, flags, verdict > 0, about["iterations"])
