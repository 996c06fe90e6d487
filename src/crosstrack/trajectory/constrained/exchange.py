"""Constraints at every instant, by exchange (Hettich and Kortanek, Semi-infinite programming, 1993).

A program holds the sets, tightened by a small margin, at finitely many instants. Its optimum is searched for the
instants where it leaves them by the most, certified by polynomial bounds; these are added, until the optimum violates
nothing at any instant. Convexity makes the multipliers a proof of how near the cost is to the least: with the slacks s
of the sets as they are, not tightened, no curve costs less than J - 2 zᵀ s.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from crosstrack.trajectory.closed_form import closed_form
from crosstrack.trajectory.constrained.cones import Flags, Indices, Rows, depths
from crosstrack.trajectory.constrained.families import Excess, Family, inside
from crosstrack.trajectory.constrained.interior import INFEASIBLE, Measures, Program, solved
from crosstrack.trajectory.constrained.newton import Point
from crosstrack.trajectory.constrained.spans import Spans
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

MARGIN = 1e-4
"""relative, by which sets are tightened at first"""
FINITE_MARGIN = 1e-10
"""relative, where the instants are all there are"""
THINNEST = 1e-8
"""relative, margin below which sets have no inside worth the name"""
ROUNDING = 1e-6
"""relative, excess that is let pass where what is given lies on the boundary, so that there is no room for a margin"""
ROUNDS = 30
LEARNING = 12
"""rounds after which what is still violated is tightened by it"""
ACCURACY, FINITE_ACCURACY = 1e-6, 1e-12
"""of the programs"""
POOR, FAILURES = 1e-5, 3
"""residual of the constraints with which a program counts as failed, and how often it may"""
SMALL = 0.03
"""of the unit, a cost that the unit is brought down to"""
MANY = 200
"""instants to begin with, as far as all are not too few of each piece"""
NOTHING = 1e-12
"""of the cost of stopping at every waypoint, a cost that is none"""
FAR = 0.3
"""relative, how far inside an instant is dropped after the first program"""
STILL = 1e-14
"""of the largest, how much of a shape must be free to move for its constraint to be held"""


@dataclass(eq=False)
class Instants:
    """Where the sets of one family are held, and how much they are tightened."""

    piece: Indices
    """(n,)"""
    tau: Array
    """(n,) unit time"""
    margin: Array
    """(N,) of each piece, relative"""
    touching: Flags
    """(N,) bool, pieces where what is given leaves no room for a margin"""


@dataclass(frozen=True, eq=False)
class Held:
    """The constraints of a program, and where each row comes from."""

    rows: Rows
    slack: Array
    """(rows,) by how much the bound is tightened"""
    family: Indices
    """(rows,)"""
    source: Indices
    """(rows,) index among the rows of the sets of its family"""
    piece: Indices
    """(rows,)"""
    tau: Array
    """(rows,) unit time"""


EXACT = Measures(0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Found:
    """What a search has found: a curve, or in the multipliers why there is none."""

    curve: PiecewisePolynomial | None
    """relative to the first waypoint; None where there is none"""
    cost: float
    gap: float
    """relative: the cost is at most this above the least"""
    excess: list[Excess]
    """of each family"""
    held: Held | None = None
    """the last program, None where none was needed"""
    point: Point | None = None
    measures: Measures = EXACT
    rounds: int = 0
    steps: int = 0


@dataclass(eq=False)
class Exchange:
    """One search for the least cost within families of constraints."""

    spans: Spans
    families: list[Family]
    cost: Callable[[PiecewisePolynomial], float]
    """of a curve relative to the first waypoint"""
    instants: list[Instants] = field(init=False)

    def __post_init__(self) -> None:
        count = len(self.spans.asked.durations)
        self.instants = []
        for family in self.families:
            finite = family.finite
            tau = np.linspace(0.0, 1.0, 1 + max(2, min(8, MANY // count)))
            tau = np.zeros(1) if finite else tau if family.order == 0 else tau[:-1]
            piece = np.tile(np.arange(count), len(tau))
            margin = np.full(count, FINITE_MARGIN if finite else MARGIN)
            room = np.full(count, np.inf) if finite else self._room(family)
            at = Instants(piece, np.repeat(tau, count), np.minimum(margin, 0.5 * room), room < THINNEST)
            self.instants.append(at)
        self.accuracy = FINITE_ACCURACY if all(family.finite for family in self.families) else ACCURACY
        self.start = closed_form(replace(self.spans.asked, origin=np.zeros(self.spans.asked.knots.shape[2])))
        self.reference = self.spans.unknowns(self.start)
        self._move(0.0)
        free = ~self.spans.fixed[:, :, 0]
        self.movable = np.concatenate([free[:-1], free[1:]], axis=1)

    def _room(self, family: Family) -> Array:
        """Return how far inside the sets what is given at the knots of a piece is (N,); infinity where outside."""
        knots, order = self.spans.asked.knots, family.order
        room = np.full(len(knots) - 1, np.inf)
        if order < knots.shape[1]:
            for given in (knots[:-1, order], knots[1:, order]):
                depth = inside(family.sets, given)
                room = np.minimum(room, np.where(depth >= -ROUNDING, np.maximum(depth, 0.0), np.inf))
        return room

    def search(self, tightness: float) -> Found:
        """Return the optimum to within a relative tightness of its cost, or the proof that there is none."""
        unit = self.cost(self.start)
        if not self.spans.free.any() or unit <= NOTHING * self._hasty():
            found = Found(self.start, unit, 0.0, [family.excess(self.start) for family in self.families])
            if all(self.certified(found)):
                return found
        unit = max(unit, NOTHING * self._hasty())
        steps, best, failures = 0, None, 0
        for rounds in range(1, ROUNDS + 1):
            found = self._round(unit, rounds, steps)
            steps = found.steps
            failures += found.curve is not None and found.measures.primal > POOR
            if failures == FAILURES or (found.curve is None and not self._loosened(found)):
                break
            if found.curve is None or found.measures.primal > POOR:
                continue
            if all(self.certified(found)):
                best = found if best is None or found.gap < best.gap else best
                if found.gap <= tightness:
                    break
                if found.cost > SMALL * unit:
                    for at in self.instants:
                        at.margin = 0.1 * at.margin
            unit = max(min(unit, found.cost), NOTHING * self._hasty())
            self._learn(found, rounds)
        return best or found

    def _round(self, unit: float, rounds: int, steps: int) -> Found:
        """Return the optimum at the instants held, with the cost in a unit."""
        forms, slope = self.spans.forms / unit, self.slope / unit
        held = self.held()
        program = Program(forms, slope, self.spans.fixed.reshape(len(slope), -1), held.rows)
        status, taken, point, measures = solved(program, self.accuracy)
        if status == INFEASIBLE:
            return Found(None, np.inf, np.inf, [], held, point, measures, rounds, steps + taken)
        curve = self.spans.curve(self.reference + point.x)
        cost = self.cost(curve)
        gap = 2.0 * unit * float(point.z @ (point.s + held.slack)) / max(cost, NOTHING * self._hasty())
        excess = [family.excess(curve) for family in self.families]
        return Found(curve, cost, gap, excess, held, point, measures, rounds, steps + taken)

    def _move(self, by: Array | float) -> None:
        """Make another curve the reference, that unknowns are relative to."""
        self.reference = self.reference + by
        self.slope = self.spans.slope(self.reference)
        self.slope[self.spans.fixed] = 0.0

    def _hasty(self) -> float:
        """Return the size of the cost of speeding up and slowing down on every segment."""
        durations = self.spans.asked.durations
        return float((self.spans.steps**2).sum(axis=1) @ durations ** (1.0 - 2.0 * self.spans.order))

    def certified(self, found: Found) -> list[bool]:
        """Return of each family whether it is kept to at every instant."""
        return [
            bool((excess.bound <= np.where(at.touching[excess.piece], ROUNDING, 0.0)).all())
            for excess, at in zip(found.excess, self.instants, strict=True)
        ]

    def _loosened(self, found: Found) -> bool:
        """Return whether a proof that there is no curve rests on the margins alone, and make them smaller if so."""
        held, point = found.held, found.point
        if held is None or point is None or -float(point.z @ held.rows.bounds) > float(point.z @ held.slack):
            return False
        for at in self.instants:
            at.touching = at.touching | (at.margin <= THINNEST)
            at.margin = np.where(at.margin > THINNEST, 0.1 * at.margin, 0.0)
        return True

    def _drop(self, found: Found) -> None:
        """Drop instants of limits that the first program was far inside of."""
        held, point = found.held, found.point
        if held is None or point is None:
            return
        first, depth = held.rows.first[:-1], depths(held.rows, point.s)
        for f, (family, at) in enumerate(zip(self.families, self.instants, strict=True)):
            if family.order > 0:
                kept = first[(held.family[first] == f) & (depth < FAR)]
                at.piece, at.tau = held.piece[kept], held.tau[kept]

    def _learn(self, last: Found, rounds: int) -> None:
        """Add the instants where a curve is outside the tightened sets, and later tighten them instead."""
        if last.point is not None:
            self._move(last.point.x)
        if rounds == 1:
            self._drop(last)
        for found, at, family in zip(last.excess, self.instants, self.families, strict=True):
            if family.finite:
                continue
            outside = found.bound > -0.5 * at.margin[found.piece]
            at.piece = np.concatenate([at.piece, found.piece[outside]])
            at.tau = np.concatenate([at.tau, found.tau[outside]])
            if rounds >= LEARNING:
                late = outside & (found.bound > 0.0) & ~at.touching[found.piece]
                piece = found.piece[late]
                np.maximum.at(at.margin, piece, 1.5 * found.bound[late] + at.margin[piece])

    def held(self) -> Held:
        """Return the constraints at all instants as rows of one program."""
        dimensions = self.spans.asked.knots.shape[2]
        parts = [self._held(f, dimensions) for f in range(len(self.families))]
        shapes, piece, counts, rounds, of_row, sides, bounds, slack, numbers = (
            np.concatenate(group) for group in zip(*parts, strict=True)
        )
        first = np.concatenate([[0], np.cumsum(counts)])
        rows = Rows(first, rounds, piece, shapes, sides, bounds - slack)
        return Held(rows, slack, numbers[:, 0], numbers[:, 1], numbers[:, 2], of_row)

    def _held(self, f: int, dimensions: int) -> tuple[np.ndarray, ...]:
        """Return the constraints of one family at its instants."""
        family, at, sets = self.families[f], self.instants[f], self.families[f].sets
        shapes = self.spans.shapes(at.piece, family.order, at.tau)
        weight = np.abs(shapes)
        counts = np.diff(sets.first)[at.piece]
        used = ((weight * self.movable[at.piece]).max(axis=1) > STILL * weight.max(axis=1)) & (counts > 0)
        piece, tau, counts, shapes = at.piece[used], at.tau[used], counts[used], shapes[used]
        owner = np.repeat(np.arange(len(piece)), counts)
        source = sets.first[piece[owner]] + np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
        value = self.spans.values(self.reference, piece, family.order, tau)
        bounds = sets.bounds[source] - np.einsum("nd,nd->n", sets.normals[source], value[owner])
        sides = np.concatenate([sets.normals[source], sets.slides[source, None]], axis=1)
        slack = sets.firm[source] * at.margin[piece[owner]]
        if not sets.round:  # what hardly moves near what is given is scaled up
            reach = np.abs(sides).max(axis=1) * (weight * self.movable[at.piece])[used].max(axis=1)[owner]
            scale = np.minimum(np.maximum(reach, np.abs(bounds) + slack), 1.0)
            sides, bounds, slack = sides / scale[:, None], bounds / scale, slack / scale
        numbers = np.stack([np.full(len(owner), f), source, piece[owner]], axis=1)
        return shapes, piece, counts, np.full(len(piece), sets.round), tau[owner], sides, bounds, slack, numbers
