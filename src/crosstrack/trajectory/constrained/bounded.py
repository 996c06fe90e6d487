"""Least cost within a corridor and limits, kept to at every instant, with the proof of how good it is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.errors import Infeasible, InputError, Problem, reported_by
from crosstrack.trajectory.arguments import is_number
from crosstrack.trajectory.conditions import Conditions, conditions
from crosstrack.trajectory.constrained.cones import Flags, depths
from crosstrack.trajectory.constrained.contradictions import contradictions, reasons
from crosstrack.trajectory.constrained.corridor import Corridor
from crosstrack.trajectory.constrained.exchange import Exchange, Found
from crosstrack.trajectory.constrained.families import Family, corridor_family, limit_family
from crosstrack.trajectory.constrained.spans import Spans
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.limits import MotionLimits, limit_faults
from crosstrack.trajectory.polynomial import PiecewisePolynomial

TIGHTNESS = 1e-3
"""relative to the least cost"""


@dataclass(frozen=True, eq=False)
class Solution:
    """A curve within its constraints, and what is known of it, each checked on the curve itself."""

    curve: PiecewisePolynomial
    cost: float
    """∫ ‖p⁽ˢ⁾‖² dt and what its guides add"""
    gap: float
    """relative: no curve within the constraints costs less than (1 - gap) times this, to the accuracy of `dual`"""
    margins: dict[str, float]
    """m or m/s^k, certified: how far inside each kind of constraint the curve stays at every instant"""
    active: dict[str, int]
    """constraints of each kind that hold the curve, each at one instant"""
    rounds: int
    """programs solved"""
    steps: int
    """of the interior-point method, in all"""
    primal: float
    """largest residual of the constraints, relative"""
    dual: float
    """largest residual of the gradient, relative"""
    jump: float
    """largest jump of a derivative below s at a knot, relative to its largest value"""


@reported_by("solve")
def solve(
    waypoints: ArrayLike,
    times: ArrayLike,
    derivative: int = 3,
    *,
    start: ArrayLike | None = None,
    end: ArrayLike | None = None,
    velocities: ArrayLike | None = None,
    guide: float | Guide | Sequence[Guide] | None = None,
    corridor: float | Corridor | None = None,
    limits: MotionLimits | None = None,
    through: Sequence[bool] | None = None,
    tightness: float = TIGHTNESS,
) -> Solution:
    """Return the piecewise polynomial of least cost within a corridor and limits, certified for every instant.

    Args:
        waypoints: as for `minimum`, like all that is not listed here
        times: (n,) s, increasing
        derivative: s
        start: derivatives at the first waypoint
        end: likewise at the last
        velocities: at the waypoints
        guide: weight of the chords, or guides
        corridor: half the side of boxes that hold the inner knots, and them only, or the sets that hold each piece. The
            curve leads through the first and the last waypoint, near the others
        limits: of speed, acceleration and jerk
        through: (n,) waypoints that the curve leads through in spite of a corridor
        tightness: relative, how far the cost may be above the least

    Raises:
        InputError: all that is wrong with the arguments.
        Infeasible: which constraints contradict one another, where, and by how much.
    """
    asked = conditions(waypoints, times, derivative, start, end, velocities, False, guide)
    free = _checked(asked, corridor, limits, through, tightness)
    guides = [] if guide is None else _guides(asked, guide)
    if corridor is not None and not isinstance(corridor, Corridor) and limits is None:
        axes = range(asked.knots.shape[2])
        parts = [
            _solved(_axis(asked, d), free, corridor, None, [_along(g, d) for g in guides], tightness) for d in axes
        ]
        solution = _joined(parts)
    else:
        solution = _solved(asked, free, corridor, limits, guides, tightness)
    coefficients = solution.curve.coefficients
    coefficients[:, 0] += asked.origin
    return solution


def _checked(
    asked: Conditions,
    corridor: float | Corridor | None,
    limits: MotionLimits | None,
    through: Sequence[bool] | None,
    tightness: float,
) -> Flags:
    """Return which knots are free (N + 1,)."""
    points = asked.knots[:, 0] + asked.origin
    found: list[Problem] = []
    if isinstance(corridor, Corridor):
        found += corridor.faults(points)
    elif corridor is not None and not (is_number(corridor) and 0 < corridor < np.inf):
        found.append(Problem("corridor", f"must be a number above 0, or a corridor, found {corridor!r:.60}"))
    found += limit_faults(limits, points.shape[1]) if limits is not None else []
    kept = np.zeros(len(points), bool) if through is None else np.asarray(through)
    if kept.shape != (len(points),) or kept.dtype != bool:
        message = f"must be {len(points)} booleans, found {kept.dtype} of shape {kept.shape}"
        found.append(Problem("through", message))
    if not 0 < tightness < 1:
        found.append(Problem("tightness", f"must be between 0 and 1, found {tightness!r}"))
    if found:
        raise InputError("minimum", found)
    free: Flags = ~kept if corridor is not None else np.zeros(len(points), bool)
    free[[0, -1]] = False
    return free


def _guides(asked: Conditions, guide: float | Guide | Sequence[Guide]) -> list[Guide]:
    """Return guides relative to the first waypoint."""
    if isinstance(guide, Guide):
        guide = [guide]
    if not isinstance(guide, Sequence):
        return [Guide(chord(asked.knots[:, 0], asked.durations), guide)]
    moved = []
    for one in guide:
        coefficients = one.curve.coefficients.copy()
        if one.order == 0:
            coefficients[:, 0] -= asked.origin
        moved.append(replace(one, curve=PiecewisePolynomial(one.curve.durations, coefficients)))
    return moved


def _axis(asked: Conditions, d: int) -> Conditions:
    """Return the conditions on one axis."""
    one = slice(d, d + 1)
    knots, loads = np.ascontiguousarray(asked.knots[:, :, one]), np.ascontiguousarray(asked.loads[:, :, one])
    return replace(asked, knots=knots, loads=loads, origin=asked.origin[one])


def _along(guide: Guide, d: int) -> Guide:
    """Return one axis of a guide."""
    curve = PiecewisePolynomial(guide.curve.durations, guide.curve.coefficients[:, :, d : d + 1])
    return replace(guide, curve=curve)


def _solved(
    asked: Conditions,
    free: Flags,
    corridor: float | Corridor | None,
    limits: MotionLimits | None,
    guides: list[Guide],
    tightness: float,
) -> Solution:
    """Return the solution relative to the first waypoint."""
    points, dimensions = asked.knots[:, 0], asked.knots.shape[2]
    families: list[Family] = [] if corridor is None else [corridor_family(corridor, points, asked.origin)]
    bounds = [] if limits is None else limits.bounds(dimensions)
    families += [limit_family(bound, len(points) - 1, dimensions) for bound in bounds]
    spans = Spans(asked, free)
    found = contradictions(spans, families)
    if found:
        raise Infeasible("minimum", found)

    def cost(curve: PiecewisePolynomial) -> float:
        return curve.cost(asked.order) + sum(guide.error(curve) for guide in guides)

    search = Exchange(spans, families, cost)
    result = search.search(tightness)
    if result.curve is None or not all(search.certified(result)):
        raise Infeasible("minimum", reasons(spans, families, result))
    return _solution(result.curve, asked.order, families, result)


def _solution(curve: PiecewisePolynomial, s: int, families: list[Family], found: Found) -> Solution:
    """Return what is known of a curve."""
    margins, active = {}, {}
    for f, (family, excess) in enumerate(zip(families, found.excess, strict=True)):
        margins[family.name] = float(np.min(-excess.bound * excess.size, initial=np.inf))
        active[family.name] = active_in(found, f)
    return Solution(
        curve,
        found.cost,
        found.gap,
        margins,
        active,
        found.rounds,
        found.steps,
        found.measures.primal,
        found.measures.dual,
        jump(curve, s),
    )


def active_in(found: Found, f: int) -> int:
    """Return how many constraints of a family hold the curve: those with a multiplier above their slack."""
    if found.held is None or found.point is None:
        return 0
    rows, point = found.held.rows, found.point
    force = np.maximum.reduceat(point.z, rows.first[:-1])
    mine = found.held.family[rows.first[:-1]] == f
    return int((mine & (force > np.maximum(depths(rows, point.s), 0.0))).sum())


def jump(curve: PiecewisePolynomial, s: int) -> float:
    """Return the largest jump of a derivative below s at a knot, relative to the largest value of that derivative.

    A derivative that is nowhere larger than rounding of the one below it counts as zero.
    """
    powers, worst, least = np.arange(curve.degree + 1), 0.0, 0.0
    spans = curve.durations[:, None, None] ** powers[:, None]
    for order in range(s):
        falling = curve.derivative(order).coefficients
        ends = (falling * spans[:, : falling.shape[1]]).sum(axis=1)
        size = max(float(np.abs(falling[:, 0]).max()), least)
        gap = float(np.abs(ends[:-1] - falling[1:, 0]).max(initial=0.0))
        worst = max(worst, gap / size if size > 0.0 else 0.0)
        least = 1e-6 * size / float(curve.durations.min())
    return worst


def _joined(parts: list[Solution]) -> Solution:
    """Return axes that were solved one by one as one solution."""
    coefficients = np.concatenate([part.curve.coefficients for part in parts], axis=2)
    cost = sum(part.cost for part in parts)
    return Solution(
        curve=PiecewisePolynomial(parts[0].curve.durations, coefficients),
        cost=cost,
        gap=sum(part.cost * part.gap for part in parts) / cost if cost else 0.0,
        margins={name: min(part.margins[name] for part in parts) for name in parts[0].margins},
        active={name: sum(part.active[name] for part in parts) for name in parts[0].active},
        rounds=sum(part.rounds for part in parts),
        steps=sum(part.steps for part in parts),
        primal=max(part.primal for part in parts),
        dual=max(part.dual for part in parts),
        jump=max(part.jump for part in parts),
    )
