"""Least cost within sets at a fine grid of instants, by Clarabel: an independent oracle.

Its unknowns are the coefficients of every piece, tied by equations of continuity; ours are values at the knots.
"""

from math import perm

import clarabel
import numpy as np
from scipy import sparse
from scipy.linalg import block_diag

from crosstrack.trajectory.constrained.corridor import Boxes, Polytopes, Tube
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.types import Array

INSTANTS = 24
"""of every piece"""


class Oracle:
    """A cone program over coefficients (N, 2 s, d) on unit time, rest to rest."""

    def __init__(self, points: Array, times: Array, s: int, extra: int = 0) -> None:
        self.points, self.durations, self.s = points - points[0], np.diff(times), s
        self.origin, self.count, self.dimensions = points[0], len(times) - 1, points.shape[1]
        self.size = self.count * 2 * s * self.dimensions
        self.equal: list[tuple[Array, float]] = []
        self.rows: list[sparse.csr_matrix] = []
        self.sides: list[Array] = []
        self.cones: list[object] = []
        self.slides = 0
        self.extra = extra

    def at(self, piece: int, order: int, tau: float, axis: int) -> Array:
        """Return the row of a derivative on one axis."""
        row = np.zeros(self.size + self.extra)
        for k in range(order, 2 * self.s):
            value = perm(k, order) * tau ** (k - order) / self.durations[piece] ** order
            row[(piece * 2 * self.s + k) * self.dimensions + axis] = value
        return row

    def add(self, matrix: Array, side: Array, cone: object) -> None:
        """Hold side - matrix x in a cone."""
        self.rows.append(sparse.csr_matrix(matrix))
        self.sides.append(np.asarray(side, float))
        self.cones.append(cone)

    def smooth(self, through: bool) -> None:
        """Rest at both ends, continuity, and the waypoints that are led through."""
        rows, sides = [], []
        for axis in range(self.dimensions):
            for order in range(self.s):
                for piece, tau, knot in ((0, 0.0, 0), (self.count - 1, 1.0, self.count)):
                    rows.append(self.at(piece, order, tau, axis))
                    sides.append(self.points[knot, axis] if order == 0 else 0.0)
                for piece in range(self.count - 1):
                    scale = self.durations[piece] ** order
                    rows.append((self.at(piece, order, 1.0, axis) - self.at(piece + 1, order, 0.0, axis)) * scale)
                    sides.append(0.0)
            for piece in range(1, self.count) if through else ():
                rows.append(self.at(piece, 0, 0.0, axis))
                sides.append(self.points[piece, axis])
        self.add(np.array(rows), np.array(sides), clarabel.ZeroConeT(len(rows)))

    def limit(self, limits: MotionLimits) -> None:
        """Hold the limits."""
        for bound in limits.bounds(self.dimensions):
            for piece, tau in self.grid():
                rows = [self.at(piece, bound.order, tau, axis) for axis in bound.axes]
                matrix = np.array([np.zeros_like(rows[0]), *rows]) / bound.most
                self.add(matrix, np.array([1.0, *np.zeros(len(rows))]), clarabel.SecondOrderConeT(len(rows) + 1))

    def grid(self) -> list[tuple[int, float]]:
        """Return the instants as piece and unit time."""
        return [(piece, k / INSTANTS) for piece in range(self.count) for k in range(INSTANTS + 1)]

    def hold(self, corridor: Boxes | Tube | Polytopes) -> None:
        """Hold the corridor."""
        for index, (piece, tau) in enumerate(self.grid()):
            rows = np.array([self.at(piece, 0, tau, axis) for axis in range(self.dimensions)])
            if isinstance(corridor, Boxes):
                low = np.asarray(corridor.low)[piece] - self.origin
                high = np.asarray(corridor.high)[piece] - self.origin
                self.add(
                    np.concatenate([rows, -rows]),
                    np.concatenate([high, -low]),
                    clarabel.NonnegativeConeT(2 * len(rows)),
                )
            elif isinstance(corridor, Polytopes):
                a, b = (np.asarray(part) for part in corridor.faces[piece])
                self.add(a @ rows, b - a @ self.origin, clarabel.NonnegativeConeT(len(b)))
            else:
                self.capsule(rows, piece, index, float(np.broadcast_to(corridor.radius, self.count)[piece]))

    def capsule(self, rows: Array, piece: int, index: int, radius: float) -> None:
        """Hold a point within a radius of its chord; needs one unknown beyond the coefficients for each instant."""
        start, chord = self.points[piece], self.points[piece + 1] - self.points[piece]
        slide = np.zeros(self.size + self.extra)
        slide[self.size + index] = 1.0
        tail = -(rows - chord[:, None] * slide) / radius
        matrix = np.concatenate([np.zeros((1, len(slide))), tail])
        self.add(matrix, np.array([1.0, *(-start / radius)]), clarabel.SecondOrderConeT(len(start) + 1))
        self.add(np.array([slide, -slide]), np.array([1.0, 0.0]), clarabel.NonnegativeConeT(2))

    def least(self, unit: float) -> float | None:
        """Return the least cost, None where there is none; `unit` is a cost of about its size."""
        s, order = self.s, np.arange(2 * self.s)
        factor = np.array([perm(int(k), s) for k in order], float)
        inner = 1.0 / np.maximum(order[:, None] + order - 2 * s + 1, 1) * np.outer(factor, factor)
        blocks = [inner * span ** (1 - 2 * s) * 2.0 / unit for span in self.durations]
        extra = np.zeros((self.extra, self.extra))
        cost = block_diag(np.kron(block_diag(*blocks), np.eye(self.dimensions)), extra)
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        matrix, side = sparse.vstack(self.rows).tocsc(), np.concatenate(self.sides)
        solver = clarabel.DefaultSolver(
            sparse.csc_matrix(np.triu(cost)), np.zeros(self.size + self.extra), matrix, side, self.cones, settings
        )
        found = solver.solve()
        if "Infeasible" in str(found.status):
            return None
        assert str(found.status) in {"Solved", "AlmostSolved"}, found.status
        return float(found.obj_val) * unit


def least_cost(
    points: Array,
    times: Array,
    s: int,
    corridor: Boxes | Tube | Polytopes | None,
    limits: MotionLimits | None,
    unit: float,
) -> float | None:
    """Return the least cost within a corridor and limits at a grid of instants, rest to rest; None where there is none.

    Never more than the least cost within them at every instant.
    """
    instants = (len(times) - 1) * (INSTANTS + 1)
    oracle = Oracle(
        np.asarray(points, float), np.asarray(times, float), s, instants if isinstance(corridor, Tube) else 0
    )
    oracle.smooth(corridor is None)
    if corridor is not None:
        oracle.hold(corridor)
    if limits is not None:
        oracle.limit(limits)
    return oracle.least(unit)
