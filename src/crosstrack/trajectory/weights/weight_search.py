"""The search for weights of a guide that keep a trajectory within what is allowed, and no greater than needed.

It looks at the same λ on all segments, and at the same κ = λ T^(2 s), the number that fixes the shape whatever the
duration T, from none to where it no longer matters. Where none does, it changes one segment after the other, up and
down, as long as the largest excess falls. Once all is met it takes every weight down towards where its own segment just
keeps within what is allowed, as long as the cost falls and all stays met. Every deviation and peak is certified for
every instant.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from crosstrack.trajectory.banded import GUIDES
from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.conditions import Conditions
from crosstrack.trajectory.guide import Guide
from crosstrack.trajectory.limits import Bound
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.weights.excess import excesses
from crosstrack.types import Array

SCALE = {2: (1e0, 1e6), 3: (1e1, 1e10), 4: (1e2, 1e13)}
"""κ of each s, from too little to matter to too much to matter: wider than the eigenvalues of ∫(p⁽ˢ⁾)² over ∫p²"""
BEYOND = 1e12
"""factor past the scale to where a guide that is a trajectory itself is followed to rounding"""
DENSITY = 2
"""weights tried in a decade"""
HALVINGS = 6
"""of the interval where all is first met"""
FACTORS = (10.0, 0.1, 2.0, 0.5)
"""by which one weight is tried"""
ROUNDS = 40
"""at most, of single weights, and of all towards their own"""
SNUG = 0.99
"""of what is allowed: a segment this near to it needs no less weight"""

Kind = Literal["chord", "resting", "least excess"]


@dataclass(frozen=True, eq=False)
class Trial:
    """Weights that were tried, and how they did."""

    weights: Array
    """(N,) λ"""
    curve: PiecewisePolynomial
    excesses: Array
    """(bounds, N) peak of each on each segment, over what is allowed"""
    cost: float

    @property
    def worst(self) -> float:
        """The largest excess; at most 1 where all is met."""
        return float(self.excesses.max())


class Search:
    """The search for the weights of one guide."""

    def __init__(
        self, asked: Conditions, points: Array, allowed: Sequence[Bound], kind: Kind, target: PiecewisePolynomial
    ) -> None:
        """Take what a trajectory must meet, waypoints (N + 1, d) m, what is allowed, and what to draw to."""
        self.asked, self.points, self.allowed, self.kind, self.target = asked, points, allowed, kind, target
        self.unit = asked.durations ** (-2 * asked.order)  # λ of κ = 1
        self.loads = Guide(target).loads(target.knots, points[:-1], asked.order)
        self.solves = 0

    def run(self) -> Trial:
        """Return the smoothest trial found that meets all, or the one that comes nearest."""
        none = self.trial(np.zeros(len(self.unit)))
        if none.worst <= 1:
            return none
        found = [self.along(none, weights) for weights in (np.full(len(self.unit), self.unit.min()), self.unit)]
        if min(trial.worst for trial in found) > 1:
            found = [self.nearer(min(found, key=lambda trial: trial.worst))]
        met = [self.smoother(trial) for trial in found if trial.worst <= 1]
        return min(met, key=lambda trial: trial.cost) if met else found[0]

    def along(self, none: Trial, weights: Array) -> Trial:
        """Return the least multiple of weights that meets all, or the nearest, up to where they no longer matter."""
        low, high = SCALE[self.asked.order]
        high *= (1.0 if self.kind == "chord" else BEYOND) * float((self.unit / weights).max())
        before, best = low / 10, none
        for factor in np.geomspace(low, high, round(DENSITY * np.log10(high / low)) + 1):
            tried = self.trial(factor * weights)
            best = tried if tried.worst < best.worst else best
            if tried.worst <= 1:
                return self.between(before, factor, weights, tried)
            before = factor
        return best

    def between(self, low: float, high: float, weights: Array, best: Trial) -> Trial:
        """Return the least multiple of weights between one that does not meet all and one that does."""
        for _ in range(HALVINGS):
            middle = np.sqrt(low * high)
            tried = self.trial(middle * weights)
            if tried.worst <= 1:
                high, best = middle, tried
            else:
                low = middle
        return best

    def trial(self, weights: Array) -> Trial:
        """Compute and measure the trajectory of weights (N,)."""
        self.solves += 1
        each = np.zeros((len(weights), GUIDES))
        each[:, 0] = weights
        asked = replace(self.asked, weights=each, loads=weights[:, None, None] * self.loads)
        curve = closed_form(asked)
        return Trial(weights, curve, excesses(self.allowed, curve, self.points), curve.cost(asked.order))

    def nearer(self, best: Trial) -> Trial:
        """Change the weights about the largest excess, one after the other, as long as it falls or until all is met."""
        low = SCALE[self.asked.order][0] * self.unit
        for _ in range(ROUNDS):
            before = best.worst
            at = int(best.excesses.max(axis=0).argmax())
            for i in range(max(at - 1, 0), min(at + 2, len(self.unit))):
                for factor in FACTORS:
                    weights = best.weights.copy()
                    weights[i] = max(weights[i], low[i]) * factor
                    tried = self.trial(weights)
                    if tried.worst < best.worst:
                        best = tried
                        break
                if best.worst <= 1:
                    return best
            if best.worst > 0.999 * before:
                break
        return best

    def smoother(self, best: Trial) -> Trial:
        """Lower weights towards where each segment just keeps within what is allowed, as long as the cost falls."""
        low = SCALE[self.asked.order][0] * self.unit
        power = np.full(len(self.unit), 4.0)
        for _ in range(ROUNDS):
            used = best.excesses.max(axis=0)
            moving = (used < SNUG) & (best.weights > 0) & (power > 0.05)
            if not moving.any():
                break
            weights = np.where(moving, best.weights * used**power, best.weights)
            weights[weights < low] = 0.0
            tried = self.trial(weights)
            if tried.worst <= 1 and tried.cost < best.cost:
                best, power = tried, np.minimum(1.5 * power, 16.0)
                continue
            over = tried.excesses.max(axis=0) > 1
            near = over | np.append(over[1:], False) | np.insert(over[:-1], 0, False)
            power[near if over.any() else moving] /= 3
        return best
