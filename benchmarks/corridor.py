"""Time of corridors: the tutorial's boxes at 67 segments, tubes and limits at every instant, and Clarabel on the same.

Run as `python -m benchmarks.corridor`. Clarabel gets the very program that ours solves in its first round, with as many
instants, ready made; what it takes to make it and to certify the curve is in our time alone. Without Clarabel
(`pip install clarabel`) its column is left out.
"""

import json
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from crosstrack.trajectory.conditions import conditions
from crosstrack.trajectory.constrained.bounded import Solution, solve
from crosstrack.trajectory.constrained.corridor import Boxes, Corridor, Tube, subdivide
from crosstrack.trajectory.constrained.exchange import Exchange
from crosstrack.trajectory.constrained.families import corridor_family
from crosstrack.trajectory.constrained.spans import Spans
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.types import Array

DATA = Path(__file__).parents[1] / "tests" / "data" / "minimum_jerk_optima.json"
TURNS = 15


def least(call: Callable[[], object], turns: int = TURNS) -> float:
    """Return the least time of a call, ms."""
    taken = []
    for _ in range(turns):
        begun = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begun)
    return 1e3 * min(taken)


def clarabel_solver(points: Array, times: Array, s: int, corridor: float | Corridor) -> Callable[[], object]:
    """Return a call of Clarabel on the program of our first round."""
    import clarabel

    asked = conditions(points, times, s, None, None, None, False, None)
    free = np.ones(len(points), bool)
    free[[0, -1]] = False
    spans = Spans(asked, free)
    search = Exchange(spans, [corridor_family(corridor, asked.knots[:, 0], asked.origin)], lambda curve: curve.cost(s))
    rows, unit = search.held().rows, spans.curve(search.reference).cost(s)
    shape = (len(points), s, points.shape[1])
    index = np.arange(np.prod(shape)).reshape(shape)
    local = np.concatenate([index[:-1], index[1:]], axis=1)
    where = np.broadcast_to(local[:, :, None, :], (len(local), 2 * s, 2 * s, shape[2]))
    values = np.broadcast_to((spans.forms / unit)[..., None], where.shape)
    places = (where.ravel(), where.transpose(0, 2, 1, 3).ravel())
    cost = sparse.csc_matrix((values.ravel(), places), shape=(index.size, index.size))
    owner = np.repeat(np.arange(len(rows.piece)), np.diff(rows.first))
    entries = rows.shapes[owner][:, :, None] * rows.normals[:, None, :-1]
    across = local[rows.piece[owner]]
    down = np.broadcast_to(np.arange(len(owner))[:, None, None], across.shape)
    matrix = sparse.csc_matrix((entries.ravel(), (down.ravel(), across.ravel())), shape=(len(owner), index.size))
    slides = sparse.csc_matrix(
        (rows.normals[:, -1], (np.arange(len(owner)), owner)), shape=(len(owner), len(rows.piece))
    )
    moves = ~spans.fixed.ravel()
    matrix = sparse.hstack([matrix[:, moves], slides]).tocsc()
    cost = sparse.block_diag([cost[moves][:, moves], sparse.csc_matrix((len(rows.piece),) * 2)])
    slope = np.concatenate([search.slope.ravel()[moves] / unit, np.zeros(len(rows.piece))])
    cones: list[Any] = []
    for p in range(len(rows.piece)):
        around, count = int(rows.round[p]), int(rows.first[p + 1] - rows.first[p])
        cones += [clarabel.SecondOrderConeT(around)] if around else []
        cones += [clarabel.NonnegativeConeT(count - around)] if count > around else []
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    upper = sparse.triu(cost).tocsc()
    return lambda: clarabel.DefaultSolver(upper, slope, matrix, rows.bounds, cones, settings).solve()


def line(name: str, call: Callable[[], Solution], peer: Callable[[], object] | None) -> None:
    """Print one case."""
    found = call()
    theirs = f"{least(peer):9.1f}" if peer else "        -"
    counts = f"{found.rounds:7d}{found.steps:7d}{sum(found.active.values()):8d}"
    print(f"{name:32}{least(call):9.1f}{theirs}{counts}{found.gap:11.1e}{min(found.margins.values()):12.1e}")


def main() -> None:
    case = json.loads(DATA.read_text())["cases"][1]
    points, times = np.array(case["knots"], float), np.array(case["times"], float)
    low, high = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
    with_peer = find_spec("clarabel") is not None
    print(f"{'':32}{'ms':>9}{'Clarabel':>9}{'rounds':>7}{'steps':>7}{'active':>8}{'gap':>11}{'margin':>12}")
    for axis in range(2):
        one = np.ascontiguousarray(points[:, axis : axis + 1])
        peer = clarabel_solver(one, times, 3, 0.2) if with_peer else None
        line(f"knot boxes 0.2, axis {axis}", lambda one=one: solve(one, times, corridor=0.2), peer)  # type: ignore[misc]
    for name, corridor in (("tube 0.2", Tube(0.2)), ("boxes 0.2", Boxes(low - 0.2, high + 0.2))):
        for s in (3, 4):
            peer = clarabel_solver(points, times, s, corridor) if with_peer else None
            call = lambda s=s, corridor=corridor: solve(points, times, s, corridor=corridor)  # noqa: E731
            line(f"{name}, every instant, s = {s}", call, peer)
    limits = MotionLimits(speed=4.0, acceleration=22.0)
    line("tube 0.2, speed 4, acc. 22", lambda: solve(points, times, corridor=Tube(0.2), limits=limits), None)
    rng = np.random.default_rng(0)
    route = np.cumsum(rng.normal(size=(120, 3)) * [1, 1, 0.3], axis=0)
    many, moments = subdivide(route, 2.0 * np.arange(120), 0.18)
    peer = clarabel_solver(many, moments, 3, Tube(0.2)) if with_peer else None
    line(f"tube 0.2, {len(many) - 1} segments, 3-D", lambda: solve(many, moments, corridor=Tube(0.2)), peer)


if __name__ == "__main__":
    main()
