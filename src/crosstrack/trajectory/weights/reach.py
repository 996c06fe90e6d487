"""What no trajectory can do: a certified lower bound on how far one must exceed what it is allowed.

Of all trajectories of degree 2 s - 1 and C^(s-1) through given waypoints at given times, whatever they minimise and
whatever weights guide them, one has the least excess τ: the largest ratio of a deviation from the chords or a peak to
what is allowed of it. The problem is convex. Any instants t_k, directions n_k and shares μ_k >= 0, Σ μ_k = 1, make it
linear,

    τ >= Σ μ_k (n_k·p⁽ᵏ⁾(t_k) - h_k) / allowed_k,

with h the support function of the chord for deviations and 0 for peaks. A linear program over such cuts finds the
shares for which the right side hardly depends on the trajectory (Kelley 1960, cutting planes); what dependence is
left is bounded by V. Markov's inequality for the derivatives of polynomials. So the bound needs no trust in the
solver.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import prod

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from crosstrack.trajectory import hermite
from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.limits import Bound
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.weights.excess import excesses
from crosstrack.types import Array

ROUNDS = 150
"""linear programs at most"""
INSTANTS = np.array([0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98])
"""of a piece, in unit time, where the first cuts are made"""
GRID = np.linspace(0, 1, 33)
"""of a piece, in unit time, where its peaks are looked for"""
WELL_INSIDE = 0.5
"""excess that needs no better"""
ROUNDING = 1e-12
"""relative to the sum of the sizes of all that is added"""


@dataclass(frozen=True, eq=False)
class Reach:
    """How near to what is allowed the best trajectory comes."""

    at_least: float
    """certified: every trajectory exceeds by this factor; above 1 there is none that meets all"""
    at_most: float
    """certified excess of `curve`; at most 1 where it meets all"""
    curve: PiecewisePolynomial
    binding: tuple[tuple[str, int, float], ...]
    """name of the quantity, segment and share of the bound, largest first"""


def least_excess(
    asked: Conditions,
    points: Array,
    allowed: Sequence[Bound],
    curve: PiecewisePolynomial,
    *,
    gap: float = 0.01,
) -> Reach:
    """Return a certified lower bound on the excess of any trajectory, and the best found.

    Ends where both bounds are within `gap` (relative), or where it is clear that one meets all, or none.

    Args:
        asked: waypoints, times and ends; guides do not matter
        points: (N + 1, d) m
        allowed: the first is the deviation
        curve: one of them, the nearer to the best the better
        gap: relative
    """
    freedom = Freedom.of(asked, points)
    at_most = float(excesses(allowed, curve, points).max())
    at_least, binding = 0.0, np.empty((0, 3))
    cuts = Cuts.joined([freedom.around(row, each) for row, each in enumerate(allowed)])
    cuts = Cuts.joined([cuts, *(freedom.cuts(row, each, curve) for row, each in enumerate(allowed))])
    for _ in range(ROUNDS):
        found = program(cuts, freedom.most(allowed[0].most * at_most))
        if found is None:
            break
        solution, shares = found
        bound = min(proven(cuts, shares, freedom.most(allowed[0].most * at_most)), at_most)
        if bound > at_least:
            at_least, binding = bound, blame(cuts, shares)
        tried = freedom.curve(solution)
        excess = float(excesses(allowed, tried, points).max())
        if excess < at_most:
            at_most, curve = excess, tried
        if at_most <= WELL_INSIDE or at_most <= at_least * (1 + gap) or at_least > 1 + gap:
            break
        fresh = [freedom.cuts(row, each, of, at_least) for row, each in enumerate(allowed) for of in (tried, curve)]
        cuts = Cuts.joined([cuts.tight(solution, freedom.size), *fresh])
    named = tuple((allowed[int(row)].name, int(segment), float(share)) for row, segment, share in binding)
    return Reach(at_least, at_most, curve, named)


@dataclass(frozen=True, eq=False)
class Cuts:
    """Linear lower bounds on the excess, matrix y + level <= τ, of the unknowns y."""

    matrix: Array
    """(m, size)"""
    level: Array
    """(m,)"""
    sizes: Array
    """(m,) sum of the sizes of what was added to the level"""
    origin: NDArray[np.int64]
    """(m, 2) which of what is allowed, and segment"""

    @staticmethod
    def joined(parts: "Sequence[Cuts]") -> "Cuts":
        """Return all cuts of some."""
        return Cuts(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Cuts)))

    def tight(self, solution: Array, spare: int) -> "Cuts":
        """Return the cuts nearest to binding at a solution, four times as many as unknowns."""
        value = self.matrix @ solution + self.level
        return self.where(np.argsort(-value).astype(np.int64)[: 4 * (spare + 1)])

    def where(self, chosen: NDArray[np.int64]) -> "Cuts":
        """Return some of the cuts."""
        return Cuts(self.matrix[chosen], self.level[chosen], self.sizes[chosen], self.origin[chosen])


@dataclass(frozen=True, eq=False)
class Freedom:
    """All trajectories that meet conditions, by the free derivatives at the knots: y = p⁽ᵏ⁾ spanᵏ."""

    asked: Conditions
    points: Array
    """(N + 1, d) m, relative to the first"""
    index: NDArray[np.int64]
    """(N + 1, s) place of the first axis of a derivative among the unknowns, -1 where it is given"""
    spans: Array
    """(N + 1,) s, the shorter of the segments at each knot"""
    size: int

    @staticmethod
    def of(asked: Conditions, points: Array) -> "Freedom":
        """Return those of conditions with waypoints (N + 1, d) m."""
        unknown = np.isnan(asked.knots[:, :, 0])
        d = points.shape[1]
        index = np.where(unknown, d * (np.cumsum(unknown.ravel()) - 1).reshape(unknown.shape), -1)
        durations = asked.durations
        spans = np.minimum(np.append(durations, durations[-1]), np.insert(durations, 0, durations[0]))
        return Freedom(asked, points - points[0], index, spans, d * int(unknown.sum()))

    def curve(self, y: Array) -> PiecewisePolynomial:
        """Return the trajectory of unknowns (size,)."""
        knots = self.asked.knots.copy()
        d = knots.shape[2]
        for i, k in np.argwhere(self.index >= 0):
            at = self.index[i, k]
            knots[i, k] = y[at : at + d] / self.spans[i] ** k
        return closed_form(replace(self.asked, knots=knots, weights=np.empty((0, GUIDES))))

    def most(self, away: float) -> Array:
        """Return bounds (size,) on the unknowns of every trajectory that is nowhere farther from its chords, m.

        An axis of it less the point that runs along the chord is at most M = away + chord, and so its derivative of
        order k at the end of a duration T at most M (2 / T)ᵏ Tₙ⁽ᵏ⁾(1), with Tₙ the Chebyshev polynomial.
        """
        s, d = self.asked.knots.shape[1:]
        lengths = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        longest = lengths.max()
        out = np.empty(self.size)
        n = 2 * s - 1
        for i, k in np.argwhere(self.index >= 0):
            markov = prod((n * n - j * j) / (2 * j + 1) for j in range(k)) * 2.0**k
            out[self.index[i, k] : self.index[i, k] + d] = markov * (away + longest) + longest
        return out

    def around(self, row: int, allowed: Bound) -> Cuts:
        """Return cuts along the axes at some instants of every segment."""
        segments, d = len(self.asked.durations), self.points.shape[1]
        axes = allowed.axes or range(d)
        sides = np.concatenate([np.eye(d)[list(axes)], -np.eye(d)[list(axes)]])
        each = len(sides)
        where = np.repeat(np.arange(segments), len(INSTANTS) * each)
        tau = np.tile(np.repeat(INSTANTS, each), segments)
        return self.rows(row, allowed, where, tau, np.tile(sides, (segments * len(INSTANTS), 1)))

    def cuts(self, row: int, allowed: Bound, curve: PiecewisePolynomial, above: float = 0.0) -> Cuts:
        """Return cuts at the peaks of a trajectory that exceed a factor of what is allowed."""
        count = len(self.asked.durations)
        where, tau = np.repeat(np.arange(count), len(GRID)), np.tile(GRID, count)
        size = np.linalg.norm(self.excess(allowed, curve, where, tau), axis=1).reshape(count, -1)
        before, after = np.pad(size, ((0, 0), (1, 0)))[:, :-1], np.pad(size, ((0, 0), (0, 1)))[:, 1:]
        top = (size >= before) & (size >= after) & (size > above * allowed.most)
        bend = np.where(top, before - 2 * size + after, -1.0)
        step = np.where(bend < 0, 0.5 * (before - after) / np.minimum(bend, -np.finfo(float).tiny), 0.0)
        step[:, [0, -1]] = 0.0
        at = (np.clip(step, -1, 1) * GRID[1] + GRID)[top]
        where = np.nonzero(top)[0]
        found = self.excess(allowed, curve, where, at)
        norm = np.linalg.norm(found, axis=1)
        over = norm > 0
        return self.rows(row, allowed, where[over], at[over], found[over] / norm[over, None])

    def excess(self, allowed: Bound, curve: PiecewisePolynomial, where: NDArray[np.int64], tau: Array) -> Array:
        """Return the vector whose length is bounded, (m, d), at unit times (m,) of segments (m,)."""
        found = curve(
            np.minimum(curve.knots[where] + tau * curve.durations[where], curve.knots[where + 1]), allowed.order
        )
        if allowed.order > 0:
            return np.where(np.isin(np.arange(found.shape[1]), allowed.axes), found, 0.0)
        start, leg = self.points[where], self.points[where + 1] - self.points[where]
        found = found - self.asked.origin - start
        square = np.maximum((leg**2).sum(axis=1), np.finfo(float).tiny)
        foot = np.clip((found * leg).sum(axis=1) / square, 0, 1)
        return np.asarray(found - foot[:, None] * leg)

    def rows(self, row: int, allowed: Bound, where: NDArray[np.int64], tau: Array, sides: Array) -> Cuts:
        """Return the cuts of directions (m, d) at unit times (m,) of segments (m,)."""
        s, d = self.asked.knots.shape[1:]
        durations = self.asked.durations[where]
        basis = hermite.values(s, allowed.order, tau)
        matrix, level, sizes = np.zeros((len(where), self.size)), np.zeros(len(where)), np.zeros(len(where))
        lines = np.arange(len(where))
        for end in (0, 1):
            for k in range(s):
                knot, place = where + end, self.index[where + end, k]
                factor = basis[:, s * end + k] * durations ** (k - allowed.order) / allowed.most
                known = place < 0
                given = (sides * np.nan_to_num(self.asked.knots[knot, k])).sum(axis=1) * factor
                level += np.where(known, given, 0.0)
                sizes += np.where(known, abs(given), 0.0)
                free = lines[~known]
                scaled = (factor / self.spans[knot] ** k)[free]
                for axis in range(d):
                    matrix[free, place[free] + axis] += scaled * sides[free, axis]
        if allowed.order == 0:
            ends = (sides * self.points[where]).sum(axis=1), (sides * self.points[where + 1]).sum(axis=1)
            level -= np.maximum(*ends) / allowed.most
            sizes += np.maximum(*np.abs(ends)) / allowed.most
        return Cuts(matrix, level, sizes, np.stack([np.full(len(where), row), where], axis=1))


def program(cuts: Cuts, most: Array) -> tuple[Array, Array] | None:
    """Return the unknowns of least excess over cuts, and the shares of the cuts in it; None where the solver fails."""
    count, size = cuts.matrix.shape
    scaled = np.concatenate([cuts.matrix * most, -np.ones((count, 1))], axis=1)
    cost = np.zeros(size + 1)
    cost[-1] = 1.0
    found = linprog(cost, A_ub=scaled, b_ub=-cuts.level, bounds=[(-1, 1)] * size + [(0, None)], method="highs")
    if not found.success:
        return None
    shares = np.maximum(-found.ineqlin.marginals, 0.0)
    return found.x[:-1] * most, shares / max(shares.sum(), 1.0)


def proven(cuts: Cuts, shares: Array, most: Array) -> float:
    """Return the least excess over all unknowns within bounds that shares prove, less what rounding may have added."""
    left = np.abs(shares @ cuts.matrix) @ most
    rounding = ROUNDING * (shares @ (cuts.sizes + np.abs(cuts.matrix) @ most))
    return float(shares @ cuts.level - left - rounding)


def blame(cuts: Cuts, shares: Array) -> Array:
    """Return rows of which of what is allowed, segment and share of the bound, the largest first."""
    pairs, inverse = np.unique(cuts.origin, axis=0, return_inverse=True)
    total = np.bincount(inverse.ravel(), weights=shares)
    order = np.argsort(-total)
    return np.column_stack([pairs, total])[order][total[order] > 0]
