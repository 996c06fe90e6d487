"""When a trajectory through a corridor is where, and how its pieces share the time."""

import numpy as np

from crosstrack.plan.cadence import SHARPEST, cut, paced, reachable
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.timing import along
from crosstrack.types import Array

ROUNDING, AROUND = 0.1, 0.6
"""m, that turns are taken to be rounded within, and how far before and after a point its turn is seen"""
SAMPLES = 7
"""of a piece, where its speed and acceleration are looked at"""
LEAST, MOST = 0.75, 1.5
"""that the duration of a piece changes by at most in one round"""


def started(waypoints: Array, velocity: Array, limits: MotionLimits) -> tuple[Array, Array]:
    """Return knots (n, 3) m on the legs and their times (n,) s, for a vehicle that begins with a velocity (3,) m/s.

    As `cadence.spread`, from the part of the velocity that is along the first leg.
    """
    steps = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    fastest = along(steps, lengths, limits.speed, limits.speed_vertical)
    strongest = along(steps, lengths, limits.acceleration, limits.acceleration_vertical)
    bounds = np.zeros(len(waypoints))
    bounds[0] = min(max(float(velocity @ steps[0]) / lengths[0], 0.0), float(fastest[0]))
    bounds[1:-1] = np.minimum(
        turning(waypoints, lengths, float(strongest.min())), np.minimum(fastest[1:], fastest[:-1])
    )
    ends = reachable(bounds, lengths, strongest)
    v0, v1 = ends[:-1], ends[1:]
    peak = np.minimum(fastest, np.sqrt((v0**2 + v1**2) / 2 + strongest * lengths))
    rise, fall = (peak - v0) / strongest, (peak - v1) / strongest
    cruise = np.maximum(lengths - (2 * peak**2 - v0**2 - v1**2) / (2 * strongest), 0.0) / peak
    starts, leg, t = cut(rise + cruise + fall)
    up, level = np.minimum(t, rise[leg]), np.clip(t - rise[leg], 0.0, cruise[leg])
    down = np.clip(t - rise[leg] - cruise[leg], 0.0, fall[leg])
    flown = v0[leg] * up + strongest[leg] * up**2 / 2 + peak[leg] * (level + down) - strongest[leg] * down**2 / 2
    knots = waypoints[leg] + (flown / lengths[leg])[:, None] * steps[leg]
    return np.concatenate([knots, waypoints[-1:]]), paced(starts, leg, t, ROUNDING / float(fastest.max()))


def turning(waypoints: Array, lengths: Array, strongest: float) -> Array:
    """Return the speed (n - 2,) m/s at which the inner points of a way are passed, by the turn of the way around them.

    As in `cadence.corners`, of the turn from where the way was a little before to where it is a little later.
    """
    arcs = np.concatenate([[0.0], np.cumsum(lengths)])
    before, after = (
        np.stack([np.interp(arcs[1:-1] + shift, arcs, axis) for axis in waypoints.T], axis=1)
        for shift in (-AROUND, AROUND)
    )
    here = waypoints[1:-1]
    into, out = here - before, after - here
    cosine = (into * out).sum(axis=1) / np.linalg.norm(into, axis=1) / np.linalg.norm(out, axis=1)
    half = np.sqrt(np.maximum(0.5 * (1.0 + cosine), SHARPEST**2))
    with np.errstate(divide="ignore"):
        return np.asarray(np.sqrt(strongest * ROUNDING / np.maximum(1.0 / half - 1.0, 0.0)))


def strain(curve: PiecewisePolynomial, limits: MotionLimits) -> Array:
    """Return of every piece (n,) by which factor its time would have to be longer for the limits to hold, sampled."""
    shares = np.linspace(0.0, 1.0, SAMPLES)
    times = (curve.knots[:-1, None] + curve.durations[:, None] * shares * (1 - 1e-9)).ravel()
    worst = np.zeros(len(curve.durations))
    for _, order, axes, most in limits.bounds(3):
        size = np.linalg.norm(curve(times, order)[:, axes], axis=1).reshape(-1, SAMPLES).max(axis=1)
        worst = np.maximum(worst, (size / most) ** (1 / order))
    return worst


def shared(times: Array, worst: Array) -> Array:
    """Return times (n,) s of knots at which every piece would be as strained as the limits allow, or nearly."""
    around = np.pad(worst, 1, mode="edge")
    smooth = np.maximum(worst, 0.5 * (around[:-2] + around[2:]))
    durations = np.diff(times) * np.clip(smooth, LEAST, MOST)
    return np.concatenate([[0.0], np.cumsum(durations)])
