"""Why no trajectory keeps within its constraints: what contradicts at a glance, and what a proof of the solver says."""

from collections.abc import Iterator

import numpy as np

from crosstrack.errors import Problem
from crosstrack.trajectory.constrained.exchange import Found, Held
from crosstrack.trajectory.constrained.families import Excess, Family, inside
from crosstrack.trajectory.constrained.spans import Spans

TOLD = 8
"""contradictions that are told"""
ROUNDING = 1e-9
"""relative, excess of what is given that is none"""
SHARE = 0.02
"""of the proof, below which a constraint is not told"""
UNITS = ("m", "m/s", "m/s²", "m/s³")
GIVEN = ("position", "velocity", "acceleration", "jerk")


def contradictions(spans: Spans, families: list[Family]) -> list[Problem]:
    """Return what is given at knots and lies outside its sets, and chords that are too long for their time."""
    found = [problem for family in families for problem in _given(spans, family)]
    found += [problem for family in families if family.order == 1 for problem in _chords(spans, family)]
    return found[:TOLD]


def _given(spans: Spans, family: Family) -> Iterator[Problem]:
    """Yield what is given at a knot and lies outside the set of a piece beside it."""
    knots, order = spans.asked.knots, family.order
    if order >= knots.shape[1] or family.finite:
        return
    count = len(knots) - 1
    for side in range(2):
        depth = inside(family.sets, knots[side : count + side, order])
        fixed = spans.fixed[side : count + side, order, 0]
        for i in np.flatnonzero(fixed & (depth < -ROUNDING)):
            if side == 1 and i < count - 1 and order > 0:
                continue  # a limit is the same on both sides of a knot
            by = -depth[i] * family.sets.sizes[family.sets.first[i] : family.sets.first[i + 1]].min()
            message = f"the {GIVEN[order]} given at waypoint {i + side} is {by:.3g} {UNITS[order]} outside"
            yield Problem(place(family, int(i)), message)


def _chords(spans: Spans, family: Family) -> Iterator[Problem]:
    """Yield the chords between waypoints passed one after the other that take more than the speed allowed."""
    knots, sets = spans.asked.knots, family.sets
    passed = np.flatnonzero(spans.fixed[:, 0, 0])
    moments = np.concatenate([[0.0], np.cumsum(spans.asked.durations)])
    mean = np.diff(knots[passed, 0], axis=0) / np.diff(moments[passed])[:, None]
    size = sets.round
    rows = sets.normals[1:size] @ mean.T
    speed = np.linalg.norm(rows, axis=0) * sets.sizes[0]
    for k in np.flatnonzero(speed > sets.sizes[0] * (1 + ROUNDING)):
        message = f"{sets.sizes[0]:g} m/s is allowed, and from waypoint {passed[k]} to {passed[k + 1]} in "
        message += f"{moments[passed[k + 1]] - moments[passed[k]]:g} s takes {speed[k]:.6g} m/s on average"
        yield Problem(family.name, message)


def reasons(spans: Spans, families: list[Family], found: Found) -> list[Problem]:
    """Return what a search that found no curve says: from its proof, or else where the last curve is still outside."""
    if found.curve is not None or found.held is None or found.point is None:
        return [problem for pair in zip(families, found.excess, strict=True) for problem in _outside(*pair)]
    held, point = found.held, found.point
    z = np.abs(point.z)
    short = -float(point.z @ (held.rows.bounds + held.slack))
    told = []
    for f, family in enumerate(families):
        mine = np.flatnonzero(held.family == f)
        source = held.source[mine]
        share = z[mine] * family.sets.firm[source]
        if share.sum() > SHARE * z.sum() and short > 0.0:
            needed = short / float((share / family.sets.sizes[source]).sum())
            told.append((float(share.sum()), _proven(spans, family, held, int(mine[np.argmax(share)]), needed)))
    return [problem for _, problem in sorted(told, key=lambda pair: -pair[0])] or [
        Problem("", "no curve was found; the sets leave less room than the digits of the computation can tell")
    ]


def _proven(spans: Spans, family: Family, held: Held, row: int, needed: float) -> Problem:
    """Return what a proof says of a family, with the row that has the largest part in it."""
    piece = int(held.piece[row])
    when = spans.asked.durations[:piece].sum() + held.tau[row] * spans.asked.durations[piece]
    message = f"leaves no curve of degree {2 * spans.order - 1} at these times, tightest at {when:.4g} s"
    message += f"{'' if family.order == 0 else f' in segment {piece}'}: even if this alone gave way, "
    return Problem(place(family, piece), f"{message}it would have to be by {needed:.3g} {UNITS[family.order]} or more")


def _outside(family: Family, excess: Excess) -> Iterator[Problem]:
    """Yield by how much a curve is outside at most."""
    if len(excess.bound) and excess.bound.max() > 0.0:
        top = int(np.argmax(excess.bound))
        by = excess.bound[top] * excess.size[top]
        message = f"no curve was found within it; the nearest is {by:.3g} {UNITS[family.order]} outside"
        yield Problem(place(family, int(excess.piece[top])), message)


def place(family: Family, piece: int) -> str:
    """Return what a constraint of a piece is called."""
    return f"{family.name} of segment {piece}" if family.order == 0 else family.name
