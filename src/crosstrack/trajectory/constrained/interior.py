"""Least cost within convex constraints, by a primal-dual interior-point method that also proves when there is none.

    min ½ xᵀ P x + qᵀ x,   N x + c θ + s = b,   s in a product of cones

in the homogeneous embedding of Goulart and Chen (Clarabel: an interior-point solver for conic programs with quadratic
objectives, 2024): all is scaled by a number τ > 0, and beside the optimum it finds rays z with Nᵀ z = 0, bᵀ z < 0 that
prove that nothing meets all constraints. Steps are those of Mehrotra with the scaling of Nesterov and Todd.
"""

from typing import NamedTuple

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory.constrained import chain, cones, newton
from crosstrack.trajectory.constrained.cones import Flags, Rows
from crosstrack.trajectory.constrained.newton import Point, System
from crosstrack.types import Array

MOST_STEPS = 100
TO_THE_WALL = 0.99
"""of the longest step that stays in the cones"""
SHORTEST = 1e-6
"""step that is no progress"""
LOOSE = 100.0
"""times the accuracy, what the gradient may be off by: rounding grows with the multipliers over the slacks"""
DONE, NEAR = 1e-4, 1e-2
"""times the accuracy, gap, and error of the gradient, below which no step gains anything"""
BLURRED = 0.01
"""times the accuracy, error of the gradient from which on systems are solved twice"""
RAY, DIM_RAY = 1e-8, 1e-5
"""‖Nᵀ z‖ relative to -bᵀ z at which z proves that there is no solution, at once and where no step gains anything"""
SOLVED, INFEASIBLE, STALLED = 0, 1, 2


class Program(NamedTuple):
    """A quadratic cost of a chain of knots, and constraints."""

    forms: Array
    """(N, 2 s, 2 s) of each segment, the same for every axis"""
    slope: Array
    """(N + 1, s, d) q"""
    fixed: Flags
    """(N + 1, s d) bool, unknowns that stay zero"""
    rows: Rows


class Measures(NamedTuple):
    """How far a point is from a solution."""

    primal: float
    """largest |N x + c θ + s - b|, relative"""
    dual: float
    """largest |P x + q + Nᵀ z| and |cᵀ z|, relative"""
    gap: float
    """between primal and dual cost, relative"""


def solved(program: Program, accuracy: float) -> tuple[int, int, Point, Measures]:
    """Return status, number of steps, and the solution, or in its z a ray where there is none."""
    at, off, side, step, right, spare = (room(program) for _ in range(6))
    levels, rows = np.ones(2), program.rows
    system = newton.room(rows, program.fixed)
    degree = int(len(rows.bounds) + 1 - np.maximum(rows.round - 1, 0).sum())
    begin(program, at)
    before, measures, ray, steps = (at, levels), Measures(np.inf, np.inf, np.inf), np.inf, 0
    while True:
        status, now, off_tau, off_ray = judge(program, accuracy, at, levels, off)
        if not np.isfinite(now).all():
            at, levels = before
            break
        before = Point(*(part.copy() for part in at)), levels.copy()
        measures, ray = Measures(*now), off_ray
        done = measures.gap <= DONE * accuracy and measures.dual <= NEAR
        if status != STALLED or done or steps == MOST_STEPS or not levels[0] > 0.0:
            break
        twice = measures.dual > BLURRED * accuracy
        if not move(program, system, degree, at, levels, off, off_tau, side, step, right, spare, twice) > SHORTEST:
            break
        steps += 1
    if status == STALLED and ray <= DIM_RAY and levels[0] < levels[1]:
        status = INFEASIBLE
    over = 1.0 if status == INFEASIBLE else 1.0 / levels[0]
    return status, steps, Point(*(part * over for part in at)), measures


def room(program: Program) -> Point:
    """Return a point of zeros."""
    total, count = len(program.rows.bounds), len(program.rows.piece)
    return Point(np.zeros(program.slope.shape), np.zeros(count), np.zeros(total), np.zeros(total))


@compiled
def begin(program: Program, at: Point) -> None:
    """Fill in the reference itself, with slacks moved into the cones, and multipliers of one."""
    for r in range(at.s.size):
        at.s[r] = program.rows.bounds[r]
    enter(program.rows, at.s)
    cones.shift(program.rows, 1.0, at.z)


@compiled
def enter(rows: Rows, u: Array) -> None:
    """Move u into its cones if it is not well inside."""
    deep = cones.inside(rows, u)
    if deep < 1e-3:
        cones.shift(rows, 1.0 - deep, u)


@compiled
def target(program: Program, out: Point) -> None:
    """Fill in -q, zero and b, the right side that τ is multiplied with."""
    for i in np.ndindex(out.x.shape):
        out.x[i] = -program.slope[i]
    for p in range(out.theta.size):
        out.theta[p] = 0.0
    for r in range(out.z.size):
        out.z[r] = program.rows.bounds[r]


@compiled
def add(out: Point, factor: float, by: Point) -> None:
    """Add a multiple of all but the slacks."""
    for i in np.ndindex(out.x.shape):
        out.x[i] += factor * by.x[i]
    for p in range(out.theta.size):
        out.theta[p] += factor * by.theta[p]
    for r in range(out.z.size):
        out.z[r] += factor * by.z[r]


@compiled
def put(out: Point, factor: float, by: Point) -> None:
    """Replace all but the slacks by a multiple."""
    for i in np.ndindex(out.x.shape):
        out.x[i] = factor * by.x[i]
    for p in range(out.theta.size):
        out.theta[p] = factor * by.theta[p]
    for r in range(out.z.size):
        out.z[r] = factor * by.z[r]


@compiled
def judge(
    program: Program, accuracy: float, at: Point, levels: Array, off: Point
) -> tuple[int, tuple[float, float, float], float, float]:
    """Fill in the residuals, that of the slacks in `off.z`.

    Returns:
        status, measures, the residual of τ, and ‖Nᵀ z‖ relative to -bᵀ z
    """
    rows, tau = program.rows, levels[0]
    curved = np.empty(at.x.shape)
    chain.gradient(program.forms, at.x, curved)
    off.x[:] = 0.0
    cones.pulls(rows, at.z, off.x, off.theta)
    cones.products(rows, at.x, at.theta, off.z)
    largest, pulled, cost_scale = 0.0, 0.0, 1.0
    square, linear, bound = 0.0, 0.0, 0.0
    count = at.x.size
    fixed, flat, x = program.fixed.reshape(count), off.x.reshape(count), at.x.reshape(count)
    slope, bent = program.slope.reshape(count), curved.reshape(count)
    for i in range(count):
        square += x[i] * bent[i]
        linear += x[i] * slope[i]
        cost_scale = max(cost_scale, abs(slope[i]))
        if not fixed[i]:
            pulled = max(pulled, abs(flat[i]))
            flat[i] += bent[i] + tau * slope[i]
            largest = max(largest, abs(flat[i]))
    for p in range(rows.piece.size):
        pulled, largest = max(pulled, abs(off.theta[p])), max(largest, abs(off.theta[p]))
    missed, bound_scale = 0.0, 1.0
    for r in range(rows.bounds.size):
        bound += rows.bounds[r] * at.z[r]
        off.z[r] += at.s[r] - tau * rows.bounds[r]
        missed, bound_scale = max(missed, abs(off.z[r])), max(bound_scale, abs(rows.bounds[r]))
    cost = abs(0.5 * square / tau + linear) / tau
    gap = abs(square / tau + linear + bound) / tau / max(1.0, cost)
    measures = (missed / tau / bound_scale, largest / tau / cost_scale, gap)
    status = STALLED
    if max(measures[0], measures[1] / LOOSE, measures[2]) <= accuracy:
        status = SOLVED
    ray = -pulled / bound if bound < 0.0 else np.inf
    if status == STALLED and ray <= RAY:
        status = INFEASIBLE
    return status, measures, linear + bound + levels[1] + square / tau, ray


@compiled
def move(
    program: Program,
    system: System,
    degree: int,
    at: Point,
    levels: Array,
    off: Point,
    off_tau: float,
    side: Point,
    step: Point,
    right: Point,
    spare: Point,
    twice: bool,
) -> float:
    """Move along Mehrotra's direction; return how far.

    Three systems with one matrix: the response to τ, the step that leaves out centring, and the step.
    """
    rows, (tau, kappa) = program.rows, (levels[0], levels[1])
    cones.scale(rows, at.s, at.z, system.scaling)
    newton.factor(rows, program.forms, program.fixed, system)
    curved = np.empty(at.x.shape)
    chain.gradient(program.forms, at.x, curved)
    bottom, keep, kappa_loss = 0.0, 1.0, tau * kappa
    step_tau, step_kappa, length = 0.0, 0.0, 0.0
    for phase in range(3):
        if phase == 0:
            target(program, step)
        else:
            put(step, -keep, off)
            loss = at.s if phase == 1 else step.s
            for r in range(loss.size):
                step.z[r] += loss[r]
        solve(program, system, twice, step, right, spare)
        lean, bend = along(program, at, curved, tau, step)
        if phase == 0:
            bottom = kappa / tau + bend - lean
            put(side, 1.0, step)
            continue
        step_tau = (keep * off_tau - kappa_loss / tau + lean) / bottom
        step_kappa = -(kappa_loss + kappa * step_tau) / tau
        complete(rows, keep, step_tau, off, side, step)
        length = reach(rows, at, levels, step, step_tau, step_kappa)
        if phase == 1:
            keep = 1.0 - (1.0 - min(1.0, length)) ** 3
            level = tau * kappa
            for r in range(at.s.size):
                level += at.s[r] * at.z[r]
            level *= (1.0 - keep) / degree
            kappa_loss += step_tau * step_kappa - level
            cones.correction(rows, system.scaling, level, at.s, at.z, step.s, step.z, step.s)
    length *= TO_THE_WALL
    levels[0] += length * step_tau
    levels[1] += length * step_kappa
    add(at, length, step)
    for r in range(at.s.size):
        at.s[r] += length * step.s[r]
    return length


@compiled
def solve(program: Program, system: System, twice: bool, step: Point, right: Point, spare: Point) -> None:
    """Replace the right side `step` by the solution, refined once if it is solved twice."""
    put(right, 1.0, step)
    put(spare, 1.0, step)
    put(step, 0.0, step)
    for attempt in range(2 if twice else 1):
        if attempt > 0:
            newton.miss(program.rows, program.forms, program.fixed, system, right, step, spare)
        newton.solve(program.rows, system, program.fixed, spare.x, spare.theta, spare.z)
        add(step, 1.0, spare)


@compiled
def along(program: Program, at: Point, curved: Array, tau: float, step: Point) -> tuple[float, float]:
    """Return (q + 2 P x / τ)ᵀ Δx + bᵀ Δz and xᵀ P x / τ²."""
    lean, bend = 0.0, 0.0
    count = curved.size
    slope, bent, x, by = program.slope.reshape(count), curved.reshape(count), at.x.reshape(count), step.x.reshape(count)
    for i in range(count):
        lean += (slope[i] + 2.0 * bent[i] / tau) * by[i]
        bend += x[i] * bent[i] / (tau * tau)
    for r in range(step.z.size):
        lean += program.rows.bounds[r] * step.z[r]
    return lean, bend


@compiled
def complete(rows: Rows, keep: float, step_tau: float, off: Point, side: Point, step: Point) -> None:
    """Add the response to τ to a direction, and fill in that of the slacks."""
    add(step, step_tau, side)
    cones.products(rows, step.x, step.theta, step.s)
    for r in range(step.s.size):
        step.s[r] = step_tau * rows.bounds[r] - keep * off.z[r] - step.s[r]


@compiled
def reach(rows: Rows, at: Point, levels: Array, step: Point, step_tau: float, step_kappa: float) -> float:
    """Return the longest step, a little more than 1 at most, that stays in the cones."""
    most = 1.0 / TO_THE_WALL
    for u, by in ((at.s, step.s), (at.z, step.z)):
        most = min(most, cones.longest(rows, u, by))
    most = min(most, -levels[0] / step_tau) if step_tau < 0.0 else most
    return min(most, -levels[1] / step_kappa) if step_kappa < 0.0 else most
