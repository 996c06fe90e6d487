"""How far a trajectory exceeds what it is allowed, certified."""

from collections.abc import Sequence

import numpy as np

from crosstrack.trajectory.certified.extremes import norm_peaks
from crosstrack.trajectory.certified.polyline_distance import deviation_peaks
from crosstrack.trajectory.limits import Bound
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TIGHT = 1e-4
"""of what is allowed, how far a certified peak may be above the true one"""


def deviation(most: float) -> Bound:
    """Return the bound (m) on the distance of every piece from its own chord."""
    return Bound("deviation", 0, (), most)


def excesses(allowed: Sequence[Bound], curve: PiecewisePolynomial, points: Array) -> Array:
    """Return certified peaks on every piece over what is allowed, (bounds, pieces).

    Args:
        allowed: of order 0 is the deviation
        curve: of N pieces
        points: (N + 1, d) m, ends of the chords
    """
    rows = []
    for each in allowed:
        if each.order == 0:
            found = deviation_peaks(curve, points, tolerance=TIGHT * each.most)
        else:
            found = norm_peaks(curve, each.order, each.axes, tolerance=TIGHT)
        rows.append(found.bound / each.most)
    return np.array(rows)
