"""A trajectory along a way: inside polytopes of free space, within the limits, its clearance certified."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import Infeasible
from crosstrack.plan.auto_corridor import add_face, polytopes
from crosstrack.plan.auto_pace import shared, started, strain
from crosstrack.protocols import Map
from crosstrack.trajectory.certified.clearance import least_clearance
from crosstrack.trajectory.certified.extremes import axis_range
from crosstrack.trajectory.constrained.bounded import solve
from crosstrack.trajectory.constrained.corridor import Polytopes
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.timing import rescaled
from crosstrack.types import Array

THIN = 0.005
"""m, that a polytope is wider than its leg at least"""
SHORTFALL = 0.01
"""m, that a trajectory may come nearer to an obstacle than the faces are meant to allow"""
GUIDE = 500.0
"""1/s⁶, weight of the distance to the legs over that of the jerk: it keeps the trajectory short"""
TIGHTNESS = 0.05
"""relative to the least cost: what is shared out anew need not be the best"""
ROUNDS = 8
RESTING, MOVING = 2, 5
"""rounds in which time is shared out anew, from rest and in motion"""
STRAINED = 1.05
"""by which factor a trajectory in motion may be too fast: less than is left to the tracker"""
STILL = 0.02
"""m/s or m/s², motion that counts as rest"""


@dataclass(frozen=True, eq=False)
class Free:
    """The space a trajectory is planned in."""

    world: Map
    clearance: float
    """m, to keep from obstacles where the way has it"""
    reach: float
    """m, to either side of the way"""
    box: Array
    """(2, 3) m, lowest and highest corner; may be infinite"""
    limits: MotionLimits

    def least(self, wanted: Array) -> float:
        """Return the clearance (m) that a trajectory must have whose legs want some (n,) m."""
        return min(self.clearance, float(wanted.min())) - SHORTFALL

    def holds(self, curve: PiecewisePolynomial) -> bool:
        """Return whether a curve stays in the box, but where it begins or ends outside."""
        ends = curve(np.array([0.0, curve.duration]))
        low, high = np.minimum(self.box[0], ends.min(axis=0)), np.maximum(self.box[1], ends.max(axis=0))
        ranges = axis_range(curve)
        return all(
            side.least.value >= low[k] - SHORTFALL and side.greatest.value <= high[k] + SHORTFALL
            for k, side in enumerate(ranges)
        )


def at_rest(motion: Array) -> bool:
    """Return whether velocity and acceleration (2, 3) count as rest."""
    return bool((np.linalg.norm(motion, axis=1) < STILL).all())


def fitted(free: Free, way: Array, through: NDArray[np.bool_], motion: Array) -> PiecewisePolynomial | None:
    """Return a trajectory along a way; None where none is found that is certified.

    Args:
        free: where
        way: (n, 3) m
        through: (n,) bool, points of the way that it must lead through
        motion: (2, 3) m/s and m/s², to begin with

    From rest the time is shared out anew among the pieces until one round gains little, then stretched to the limits.
    In motion it cannot be stretched; it is shared out until the limits hold.
    """
    knots, times = started(way, motion[0], free.limits)
    kept = (knots[:, None] == way[through]).all(axis=2).any(axis=1).tolist()
    gaps = np.array([free.world.swept(a, b) for a, b in pairwise(knots)])
    wanted = np.minimum(gaps - THIN, free.clearance)
    faces = polytopes(free.world, knots, wanted, free.reach, free.box)
    resting, shares = at_rest(motion), 0
    start = None if resting else motion
    for _ in range(ROUNDS):
        try:
            curve = solve(
                knots, times, 3, start=start, corridor=Polytopes(faces), through=kept, guide=GUIDE, tightness=TIGHTNESS
            ).curve
        except Infeasible:
            return None
        worst = strain(curve, free.limits)
        fast = float(worst.max()) > STRAINED
        if fast and shares < (RESTING if resting else MOVING) - 1:
            shares += 1
            times = shared(times, worst)
            continue
        if fast and not resting:
            return None
        curve = rescaled(curve, free.limits) if resting else curve
        if not repaired(free, curve, knots, wanted, faces):
            return curve if free.holds(curve) else None
    return None


def repaired(
    free: Free, curve: PiecewisePolynomial, knots: Array, wanted: Array, faces: list[tuple[Array, Array]]
) -> bool:
    """Add a face where a curve is too near to an obstacle; return whether there was such a place."""
    least = free.least(wanted)
    found = least_clearance(curve, free.world, tolerance=0.25 * SHORTFALL)
    if found.value >= least:
        return False
    point = found.position - found.attained * free.world.gradient(found.position)
    add_face(faces, found.piece, knots[found.piece : found.piece + 2], point, float(wanted[found.piece]))
    return True
