"""Tables of gains of the linear-quadratic regulator: by thrust, or by time along a trajectory."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.track.approach import braking, limits_of
from crosstrack.track.linear import INPUTS, STATES, dynamics, dynamics_along
from crosstrack.track.reference import ROWS, SPACING, Reference, reference
from crosstrack.track.riccati import backwards, discretised, stationary
from crosstrack.types import GRAVITY, Array, Model

KNOTS = 8
"""of thrust"""
MOST_ROWS = 12_000
"""of a table by time: two minutes at 100 commands a second, 6 MB; a longer one has its rows farther apart"""


@dataclass(frozen=True, eq=False)
class Schedule:
    """Gains in equal steps of thrust or of time."""

    period: float
    """s, between the commands that the gains are for"""
    by_time: bool
    """whether they go by time (s) and not by thrust (m/s²)"""
    begin: float
    """s or m/s², of the first row"""
    spacing: float
    """s or m/s², between two rows"""
    gains: Array
    """(rows, 4, 12 or 15), see `staged`"""
    reach: float
    """m, position error that is met in proportion, see `approach.eased`"""


def by_thrust(model: Model, q: Array, r: Array, period: float) -> Schedule:
    """Return the gains of the infinite horizon over the range of thrust, with the reference at rest in still air.

    Args:
        model: of the vehicle
        q: (n,) costs of the squared states at hover, with 12 states without an integral, 15 with one
        r: (4,) costs of the squared inputs at hover
        period: s
    """
    thrusts = np.linspace(model.thrust_min, model.thrust_max, KNOTS)
    rows = np.stack([hovering(model, float(thrust), q, r, period)[0] for thrust in thrusts])
    gains = staged(rows, thrusts)
    return Schedule(period, False, float(thrusts[0]), float(thrusts[1] - thrusts[0]), gains, reach_of(model, gains[0]))


def hovering(model: Model, thrust: float, q: Array, r: Array, period: float) -> tuple[Array, Array]:
    """Return gain (4, n) and cost to go (n, n) of the infinite horizon at a thrust (m/s²)."""
    a, b, n = np.empty((STATES, STATES)), np.empty((STATES, INPUTS)), q.size
    still = (0.0, 0.0, 0.0)
    dynamics(thrust, still, still, model.rate_time, model.drag, model.drag_quadratic, a, b)
    return stationary(*discretised(a[:n, :n], b[:n], period), *(np.diag(c) for c in at_thrust(q, r, np.array(thrust))))


def at_thrust(q: Array, r: Array, thrust: Array) -> tuple[Array, Array]:
    """Return the costs (..., n) and (..., 4) at thrusts (...) m/s² from those at hover (n,) and (4,).

    Of roll and pitch and their rates they grow with its square: as much acceleration and jerk is allowed at any thrust.
    """
    factor = (thrust[..., None] / GRAVITY) ** 2
    q, r = q * np.ones_like(factor), r * np.ones_like(factor)
    q[..., 6:8] *= factor
    r[..., :2] *= factor
    return q, r


def by_time(stretch: Reference, model: Model, q: Array, r: Array, period: float) -> Schedule:
    """Return the gains along a whole trajectory, from its end backwards, where those of the infinite horizon begin.

    Args:
        stretch: any of the trajectory
        model: of the vehicle
        q: (n,) costs of the squared states at hover
        r: (4,) costs of the squared inputs at hover
        period: s
    """
    trajectory, n = stretch.trajectory, q.size
    steps = math.ceil(trajectory.duration / period)
    stride = max(1, math.ceil(steps / MOST_ROWS))
    last, cost = hovering(model, GRAVITY, q, r, period)
    rows = [staged(last[None], np.array([GRAVITY]))]
    share = stride * max(1, int((ROWS - 1) * SPACING / period) // stride)
    limits = limits_of(model)
    for first in reversed(range(0, steps, share)):
        count = min(share, steps - first)
        a, b = np.empty((count, STATES, STATES)), np.empty((count, STATES, INPUTS))
        samples = reference(trajectory, stretch.heading, first * period).rows
        thrusts = np.empty(count)
        dynamics_along(samples, period, limits, model.rate_time, model.drag, model.drag_quadratic, thrusts, a, b)
        costs = at_thrust(q, r, thrusts)
        gains, cost = backwards(*discretised(a[:, :n, :n], b[:, :n], period), *costs, cost)
        rows.append(staged(gains[::stride], thrusts[::stride]))
    gains = np.concatenate(rows[::-1])
    return Schedule(period, True, 0.0, stride * period, gains, reach_of(model, gains[-1]))


def staged(gains: Array, thrusts: Array) -> Array:
    """Return gains K (rows, 4, n) of thrusts c (rows,) in two stages: an outer one to a force, an inner one to rates.

    With errors r of position, velocity and integral, K x = K_θ (θ + K_θ⁻¹ K_r r) + .. in the three rows of the rates:
    the outer errors ask for the rotation L = -K_θ⁻¹ K_r r from the reference, and the attitude block K_θ turns to it.
    Their columns so become those of (c L_y, -c L_x), the force that this rotation gives along x and y, and of L_z.
    """
    out, outer = gains.copy(), [*range(6), *range(12, gains.shape[2])]
    lean = np.linalg.solve(gains[:, :3, 6:9], gains[:, :3, outer])
    out[:, 0, outer] = thrusts[:, None] * lean[:, 1]
    out[:, 1, outer] = -thrusts[:, None] * lean[:, 0]
    out[:, 2, outer] = lean[:, 2]
    return out


def reach_of(model: Model, gain: Array) -> float:
    """Return the reach (m) from which the vehicle can brake, by the gains (4, n) of sideways position and velocity."""
    approach = min(gain[0, 0] / gain[0, 3], gain[1, 1] / gain[1, 4])
    return float(braking(model) / approach**2)


@compiled
def blended(gains: Array, at: float, out: Array) -> None:
    """Fill `out` (4, n) with the gains between two rows of a table, at a fraction of a row; the ends answer outside."""
    last = gains.shape[0] - 1
    at = min(max(at, 0.0), float(last))
    k = min(int(at), last - 1)
    share = at - k
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = (1.0 - share) * gains[k, i, j] + share * gains[k + 1, i, j]
