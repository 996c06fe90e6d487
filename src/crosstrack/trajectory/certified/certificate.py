"""What holds of a trajectory at every instant, gathered: peaks, deviation from a route, clearance, continuity."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Map
from crosstrack.trajectory.certified.clearance import TOLERANCE, Clearance, least_clearance
from crosstrack.trajectory.certified.extremes import Extreme, largest_norm
from crosstrack.trajectory.certified.polyline_distance import largest_deviation, route_faults
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

ORDERS = {"speed": 1, "acceleration": 2, "jerk": 3, "snap": 4}
UNITS = {"speed": "m/s", "acceleration": "m/s²", "jerk": "m/s³", "snap": "m/s⁴", "deviation": "m", "clearance": "m"}
SIDES = {"": None, "_horizontal": [0, 1], "_vertical": [2]}
"""what is added to the name of a quantity, and the axes its norm is over"""


@dataclass(frozen=True, slots=True)
class Finding:
    """One limit, and whether it holds at every instant."""

    quantity: str
    """as `acceleration_vertical`; the clearance is at least its limit, everything else at most"""
    value: float
    """certified"""
    limit: float
    """in the same unit"""
    time: float
    """s, when the curve comes nearest to its limit or farthest past it"""
    holds: bool
    """whether the certified value keeps to the limit"""


@dataclass(frozen=True, eq=False)
class Certificate:
    """What holds of a trajectory at every instant."""

    duration: float
    """s"""
    effort: float
    """∫ ‖p⁽ᵏ⁾‖² dt"""
    derivative: int
    """k of the effort: the one that splines of this degree minimise, (degree + 1) / 2"""
    peaks: Mapping[str, Extreme]
    """largest speed, acceleration, jerk and snap: Euclidean, and with `_horizontal` and `_vertical` in space"""
    jumps: tuple[float, ...]
    """largest jump at a knot of each derivative from 0 to the degree, over the largest size of that derivative"""
    deviation: Extreme | None = None
    """m, largest distance from the route; None without one"""
    clearance: Clearance | None = None
    """m, least distance from an obstacle; None without a map"""

    def findings(self, limits: Mapping[str, float]) -> list[Finding]:
        """Compare with limits by the name of the quantity: those of `peaks`, `deviation` and `clearance`.

        Raises:
            InputError: a name that this certificate does not have.
        """
        known: dict[str, Extreme | Clearance] = {**self.peaks}
        known |= {"deviation": self.deviation} if self.deviation else {}
        known |= {"clearance": self.clearance} if self.clearance else {}
        unknown = [name for name in limits if name not in known]
        if unknown:
            message = f"not in the certificate, which has {', '.join(known)}"
            raise InputError("limits", [Problem(name, message) for name in unknown])
        found = []
        for name, limit in limits.items():
            value = known[name].value
            holds = value >= limit if name == "clearance" else value <= limit
            found.append(Finding(name, value, limit, known[name].time, holds))
        return found

    def document(self) -> dict[str, Any]:
        """Return everything as plain values for JSON; a clearance without any obstacle has null values."""
        entries = {name: told(name, peak, "at_most") for name, peak in self.peaks.items()}
        if self.deviation:
            entries["deviation"] = told("deviation", self.deviation, "at_most")
        if self.clearance:
            entries["clearance"] = told("clearance", self.clearance, "at_least")
            entries["clearance"]["position_m"] = self.clearance.position.tolist()
        return {
            "duration_s": self.duration,
            "effort": {"derivative": self.derivative, "value": self.effort},
            "quantities": entries,
            "jumps_relative": list(self.jumps),
        }


def told(name: str, found: Extreme | Clearance, bound: str) -> dict[str, Any]:
    """Return one quantity as plain values."""
    finite = math.isfinite(found.attained)
    return {
        "unit": UNITS[name.split("_", maxsplit=1)[0]],
        bound: found.value if finite else None,
        "attained": found.attained if finite else None,
        "time_s": found.time,
        "piece": found.piece,
    }


def certify(
    curve: PiecewisePolynomial,
    *,
    route: Array | None = None,
    world: Map | None = None,
    tolerance: float = TOLERANCE,
) -> Certificate:
    """Certify a trajectory.

    Args:
        curve: of any degree and dimension
        route: (n, dimensions) m, corners of the polyline that the deviation is measured from
        world: what is in the way; needs a curve in space
        tolerance: m, of the clearance

    Raises:
        InputError: the curve or the route is not finite, or has another shape than that.
    """
    check(curve, route, world)
    sides = SIDES if curve.coefficients.shape[2] == 3 else {"": None}
    peaks = {
        name + side: largest_norm(curve, order, axes) for name, order in ORDERS.items() for side, axes in sides.items()
    }
    derivative = (curve.degree + 1) // 2
    clearance = None
    if world is not None:
        clearance = least_clearance(curve, world, tolerance=tolerance, optimism=world.optimism)
    return Certificate(
        duration=curve.duration,
        effort=curve.cost(derivative),
        derivative=derivative,
        peaks=peaks,
        jumps=tuple(jump(curve, order) for order in range(curve.degree + 1)),
        deviation=None if route is None else largest_deviation(curve, route),
        clearance=clearance,
    )


def check(curve: PiecewisePolynomial, route: Array | None, world: Map | None) -> None:
    """Raise InputError for what cannot be certified."""
    dimensions = curve.coefficients.shape[2]
    problems = []
    if not (np.isfinite(curve.durations).all() and (curve.durations > 0).all()):
        problems.append(Problem("curve.durations", "must be positive and finite"))
    if not np.isfinite(curve.coefficients).all():
        piece = int(np.argmin(np.isfinite(curve.coefficients).all(axis=(1, 2))))
        problems.append(Problem(f"curve.coefficients[{piece}]", "must be finite"))
    if route is not None:
        problems += route_faults("route", route, dimensions)
    if world is not None and dimensions != 3:
        problems.append(Problem("curve", f"{dimensions} dimensions, a clearance needs 3"))
    if problems:
        raise InputError("certify", problems)


def jump(curve: PiecewisePolynomial, order: int) -> float:
    """Return the largest jump at a knot of the derivative of an order, over its largest size along the curve.

    The position's size is how far its knots are from the first.
    """
    of = curve.derivative(order) if order else curve
    starts, ends = of.coefficients[:, 0], np.zeros_like(of.coefficients[:, 0])
    for power in range(of.degree, 0, -1):
        ends = (ends + of.coefficients[:, power]) * curve.durations[:, None]
    gaps = starts[:-1] + ends[:-1] - starts[1:] if order else ends[:-1] - np.diff(starts, axis=0)
    if not gaps.size:
        return 0.0
    size = largest_norm(curve, order).value if order else float(np.linalg.norm(starts - starts[0], axis=1).max())
    most = float(np.linalg.norm(gaps, axis=1).max())
    return most / size if most > 0.0 else 0.0
