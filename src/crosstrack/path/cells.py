"""Evaluation and projection of a curve made of cells: polynomials of a local time w in [-1, 1], by arc length.

Cell k has the arc length S(w) since its start at `knots[k]`, the points p(w) and the velocities v(w); it lasts twice
`halves[k]` (s). See `crosstrack.path.traced.Traced` for the shapes.
"""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.path.pieces import SAME, piece_at
from crosstrack.types import Array

Triple = tuple[float, float, float]

STILL = 1e-9
"""of the mean speed of a cell, below which the tangent is the limit and the curvature zero"""
PARTS = 4
"""stretches of a cell, in each of which the distance to a point has one minimum"""
STEPS = 60
"""most steps to a root"""


@compiled
def horner(w: float, k: int, curve: Array) -> Triple:
    """Return the value of cell `k` of a curve (cells, terms, 3)."""
    x, y, z = 0.0, 0.0, 0.0
    for power in range(curve.shape[1] - 1, -1, -1):
        x, y, z = x * w + curve[k, power, 0], y * w + curve[k, power, 1], z * w + curve[k, power, 2]
    return x, y, z


@compiled
def slope_of(w: float, k: int, curve: Array) -> Triple:
    """Return the derivative by w of cell `k` of a curve (cells, terms, 3)."""
    x, y, z = 0.0, 0.0, 0.0
    for power in range(curve.shape[1] - 1, 0, -1):
        x = x * w + power * curve[k, power, 0]
        y = y * w + power * curve[k, power, 1]
        z = z * w + power * curve[k, power, 2]
    return x, y, z


@compiled
def gone(w: float, k: int, arcs: Array) -> tuple[float, float]:
    """Return the arc length (m) since the start of cell `k`, and its derivative by w."""
    value, slope = 0.0, 0.0
    for power in range(arcs.shape[1] - 1, -1, -1):
        slope = slope * w + value
        value = value * w + arcs[k, power]
    return value, slope


@compiled
def local_time(s: float, k: int, knots: Array, arcs: Array) -> float:
    """Return w at the arc length `s` (m) of cell `k`, or its nearest end, by Newton's method kept in a bracket."""
    since, length = s - knots[k], knots[k + 1] - knots[k]
    if since <= 0:
        return -1.0
    if since >= length:
        return 1.0
    low, high, w = -1.0, 1.0, 2.0 * float(since / length) - 1.0
    for _ in range(STEPS):
        value, slope = gone(w, k, arcs)
        if value > since:
            high = w
        else:
            low = w
        after = w - (value - since) / slope if slope > 0 else -2.0
        if not low < after < high:
            after = 0.5 * (low + high)
        if abs(after - w) <= 1e-15 or abs(value - since) <= 1e-15 * length:
            break
        w = after
    return w


@compiled
def clock(s: Array, knots: Array, arcs: Array, middles: Array, halves: Array, out: Array) -> None:
    """Fill `out` (n,) with the times (s) at the arc lengths `s` (n,)."""
    for i in range(s.size):
        k = piece_at(s[i], knots)
        out[i] = middles[k] + halves[k] * local_time(s[i], k, knots, arcs)


@compiled
def heading(w: float, k: int, knots: Array, velocities: Array, tangents: Array, halves: Array) -> tuple[Triple, float]:
    """Return unit tangent and speed (m/s); where there is next to none, the limit of the tangent, and zero."""
    x, y, z = horner(w, k, velocities)
    speed = np.sqrt(x * x + y * y + z * z)
    if speed > STILL * (knots[k + 1] - knots[k]) / halves[k]:
        return (x / speed, y / speed, z / speed), speed
    end = 0 if w < 0 else 1
    return (tangents[k, end, 0], tangents[k, end, 1], tangents[k, end, 2]), 0.0


@compiled
def evaluate(
    s: Array,
    order: int,
    knots: Array,
    arcs: Array,
    points: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
    out: Array,
) -> None:
    """Fill `out` (n, 3) with points, tangents or curvature vectors at `s` (n,)."""
    for i in range(s.size):
        k = piece_at(s[i], knots)
        w = local_time(s[i], k, knots, arcs)
        if order == 0:
            x, y, z = horner(w, k, points)
        else:
            (x, y, z), speed = heading(w, k, knots, velocities, tangents, halves)
        if order == 2:
            ax, ay, az = slope_of(w, k, velocities)
            along = ax * x + ay * y + az * z
            scale = 1 / (halves[k] * speed * speed) if speed > 0 else 0.0
            x, y, z = scale * (ax - along * x), scale * (ay - along * y), scale * (az - along * z)
        out[i, 0], out[i, 1], out[i, 2] = x, y, z


@compiled
def evaluated(
    s: float,
    order: int,
    knots: Array,
    arcs: Array,
    points: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
) -> Array:
    """Return the point, tangent or curvature vector (3,) at the arc length `s` (m)."""
    where, out = np.array([s]), np.empty((1, 3))
    evaluate(where, order, knots, arcs, points, velocities, tangents, halves, out)
    flat: Array = out[0]
    return flat


@compiled
def pace(
    s: Array, order: int, knots: Array, arcs: Array, velocities: Array, tangents: Array, halves: Array, out: Array
) -> None:
    """Fill `out` (n,) with the speed (m/s) or the acceleration along the curve (m/s²) at `s` (n,)."""
    for i in range(s.size):
        k = piece_at(s[i], knots)
        w = local_time(s[i], k, knots, arcs)
        (x, y, z), speed = heading(w, k, knots, velocities, tangents, halves)
        out[i] = speed
        if order == 1:
            ax, ay, az = slope_of(w, k, velocities)
            out[i] = (ax * x + ay * y + az * z) / halves[k]


@compiled
def approach(
    w: float,
    k: int,
    point: Array,
    knots: Array,
    points: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
) -> tuple[float, float]:
    """Return the distance (m) from a point (3,) to cell `k` at `w`, and the half derivative of its square by s (m)."""
    x, y, z = horner(w, k, points)
    (tx, ty, tz), _ = heading(w, k, knots, velocities, tangents, halves)
    x, y, z = x - point[0], y - point[1], z - point[2]
    return np.sqrt(x * x + y * y + z * z), x * tx + y * ty + z * tz


@compiled
def closest(
    point: Array,
    low: float,
    high: float,
    knots: Array,
    arcs: Array,
    points: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
) -> float:
    """Return the arc length (m) of the point of the path within [low, high] closest to a point (3,)."""
    low = min(max(low, 0.0), knots[-1])
    high = min(max(high, low), knots[-1])
    best_s, best = low, np.inf
    k = piece_at(low, knots)
    while k < arcs.shape[0] and knots[k] <= high:
        x, y, z = horner(0.0, k, points)
        x, y, z = x - point[0], y - point[1], z - point[2]
        middle, _ = gone(0.0, k, arcs)
        if np.sqrt(x * x + y * y + z * z) - max(middle, knots[k + 1] - knots[k] - middle) < best:
            first, last = local_time(low, k, knots, arcs), local_time(high, k, knots, arcs)
            w, distance = closest_in(point, first, last, k, knots, points, velocities, tangents, halves)
            if distance < best - SAME:
                since, _ = gone(w, k, arcs)
                # The very end of a cell is the start of the next, which knows where the path goes from there.
                s = knots[k + 1] if w >= 1.0 else knots[k] + since
                best_s, best = min(max(s, low), high), distance
        k += 1
    return best_s


@compiled
def closest_in(
    point: Array,
    first: float,
    last: float,
    k: int,
    knots: Array,
    points: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
) -> tuple[float, float]:
    """Return local time and distance of the point of cell `k` between two local times that is closest to a point."""
    distance_a, slope_a = approach(first, k, point, knots, points, velocities, tangents, halves)
    best_w, best, a = first, distance_a, first
    for part in range(1, PARTS + 1):
        b = first + (last - first) * part / PARTS if part < PARTS else last
        distance, slope_b = approach(b, k, point, knots, points, velocities, tangents, halves)
        w, after = b, slope_b
        if slope_a < 0 < slope_b:
            low, high, slope_low, slope_high, side = a, b, slope_a, slope_b, 0
            for _ in range(STEPS):  # regula falsi of Illinois
                w = (low * slope_high - high * slope_low) / (slope_high - slope_low)
                distance, slope = approach(w, k, point, knots, points, velocities, tangents, halves)
                if abs(slope) <= 1e-12 * (SAME + distance) or high - low <= 1e-15:
                    break
                if slope < 0:
                    low, slope_low = w, slope
                    slope_high = 0.5 * slope_high if side < 0 else slope_high
                    side = -1
                else:
                    high, slope_high = w, slope
                    slope_low = 0.5 * slope_low if side > 0 else slope_low
                    side = 1
        if distance < best - SAME:
            best_w, best = w, distance
        a, slope_a = b, after
    return best_w, best
