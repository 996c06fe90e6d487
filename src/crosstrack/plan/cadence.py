"""When a trajectory in a corridor is where: knots along the legs, closer where the vehicle must be slow."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.times.timing import along
from crosstrack.types import Array

STEP = 0.5
"""s, at most between knots"""
MOST, MOST_EACH = 600, 12
"""knots over all legs together, besides the waypoints, and as many more for each leg"""
SHARPEST = 1e-3
"""cosine of half the turn, below which a corner counts as a turn on the spot"""


def spread(waypoints: Array, radius: float, limits: MotionLimits) -> tuple[Array, Array]:
    """Return knots (n, 3) m on the legs and their times (n,) s, those of a vehicle that slows for the corners.

    A corner of turn θ rounded within a radius r is passed at v = sqrt(a r / (sec θ/2 - 1)) at most. Along each leg the
    speed is that of a trapezoid between the speeds at its ends, which full acceleration must be able to reach.

    Args:
        waypoints: (N + 1, 3) m, no two in a row the same
        radius: m, of the corridor
        limits: of speed and acceleration, with their vertical ones
    """
    steps = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    fastest = along(steps, lengths, limits.speed, limits.speed_vertical)
    strongest = along(steps, lengths, limits.acceleration, limits.acceleration_vertical)
    ends = reachable(corners(steps / lengths[:, None], radius, fastest, strongest), lengths, strongest)
    v0, v1 = ends[:-1], ends[1:]
    peak = np.minimum(fastest, np.sqrt((v0**2 + v1**2) / 2 + strongest * lengths))
    rise, fall = (peak - v0) / strongest, (peak - v1) / strongest
    far = lengths - (2 * peak**2 - v0**2 - v1**2) / (2 * strongest)
    cruise = np.maximum(far, 0.0) / peak
    durations = rise + cruise + fall
    starts, leg, t = cut(durations)
    up, level = np.minimum(t, rise[leg]), np.clip(t - rise[leg], 0.0, cruise[leg])
    down = np.clip(t - rise[leg] - cruise[leg], 0.0, fall[leg])
    flown = v0[leg] * up + strongest[leg] * up**2 / 2 + peak[leg] * (level + down) - strongest[leg] * down**2 / 2
    knots = waypoints[leg] + (flown / lengths[leg])[:, None] * steps[leg]
    return np.concatenate([knots, waypoints[-1:]]), paced(starts, leg, t, radius / float(fastest.max()))


def evenly(waypoints: Array, durations: Array, radius: float, limits: MotionLimits) -> tuple[Array, Array]:
    """Return knots (n, 3) m on the legs and their times (n,) s, at constant speed on each, for durations (N,) s."""
    starts, leg, t = cut(durations)
    steps = np.diff(waypoints, axis=0)
    knots = waypoints[leg] + (t / durations[leg])[:, None] * steps[leg]
    fastest = along(steps, np.linalg.norm(steps, axis=1), limits.speed, limits.speed_vertical)
    return np.concatenate([knots, waypoints[-1:]]), paced(starts, leg, t, radius / float(fastest.max()))


def paced(starts: Array, leg: NDArray[np.intp], t: Array, passing: float) -> Array:
    """Return the times (n,) s of knots a time `t` into their leg, at least half of `passing` (s) apart.

    A piece may overlap its leg by the radius of the corridor, so that a leg much shorter than it needs no time of its
    own; pieces of very different duration would cost the solver its digits.
    """
    times = np.append(starts[leg] + t, starts[-1])
    steps = np.maximum(np.diff(times), min(passing, STEP) / 2)
    return np.concatenate([[0.0], np.cumsum(steps)])


def cut(durations: Array) -> tuple[Array, NDArray[np.intp], Array]:
    """Return when each leg starts and the last ends, and of every knot but the last its leg and the time within it."""
    starts = np.concatenate([[0.0], np.cumsum(durations)])
    step = max(STEP, starts[-1] / (MOST + MOST_EACH * len(durations)))
    parts = np.maximum(np.ceil(durations / step - 1e-9).astype(int), 1)
    leg = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(leg)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[leg]
    return starts, leg, share * durations[leg]


def corners(directions: Array, radius: float, fastest: Array, strongest: Array) -> Array:
    """Return the speed bound (N + 1,) m/s at the ends of legs along unit vectors (N, 3), zero at both ends."""
    before, after = directions[:-1], directions[1:]
    cosine = np.linalg.norm(before + after, axis=1) / 2  # of half the turn
    bulge = 1 / np.maximum(cosine, SHARPEST) - 1
    with np.errstate(divide="ignore"):
        bounds = np.sqrt(np.minimum(strongest[1:], strongest[:-1]) * radius / bulge)
    return np.concatenate([[0.0], np.minimum(bounds, np.minimum(fastest[1:], fastest[:-1])), [0.0]])


def reachable(bounds: Array, lengths: Array, strongest: Array) -> Array:
    """Return the speeds at the ends of the legs, lowered to what accelerating and braking can reach."""
    speeds = bounds.tolist()
    gains = (2 * strongest * lengths).tolist()
    for k, gain in enumerate(gains):
        speeds[k + 1] = min(speeds[k + 1], (speeds[k] ** 2 + gain) ** 0.5)
    for k in range(len(gains) - 1, -1, -1):
        speeds[k] = min(speeds[k], (speeds[k + 1] ** 2 + gains[k]) ** 0.5)
    return np.array(speeds)
