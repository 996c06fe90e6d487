"""Where to look along a trajectory: yaw by time, unwrapped, with its first two derivatives."""

from dataclasses import dataclass
from math import perm
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from crosstrack.path.arc_length import edges_of
from crosstrack.protocols import Trajectory
from crosstrack.types import Array

Indices = NDArray[np.intp]

LEAST_SPEED = 0.2
"""m/s, horizontal, under which a velocity has no direction"""
LEAST_DISTANCE = 0.2
"""m, horizontal, under which a point has no direction"""
TURN_RATE = 1.5
"""rad/s, that a turn while there is no direction is given time for"""
FINEST, SAMPLES = 0.002, 200_000
"""s, shortest spacing of the samples between which yaw is unwrapped, and how many there are at most"""
QUINTIC_PEAK = 1.875
"""of its mean, the greatest rate of a quintic from rest to rest"""


class Yaw(Protocol):
    """Where to look, by time."""

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate at the time `t` (s, shape (...)): yaw or its first or second derivative, (...) rad/s^order.

        Counter-clockwise from east, continuous: full turns are counted.
        """


@dataclass(frozen=True)
class Fixed:
    """Look the same way all the time."""

    angle: float = 0.0
    """rad"""

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Return the angle, or zero for its derivatives."""
        return np.full(np.shape(t), self.angle if order == 0 else 0.0)


EAST = Fixed()


@dataclass(frozen=True, eq=False)
class Faced:
    """A trajectory with a yaw, for whoever follows it."""

    trajectory: Trajectory
    yaw: Yaw

    @property
    def duration(self) -> float:
        """s"""
        return self.trajectory.duration

    @property
    def knots(self) -> Array:
        """(n,) s, where the trajectory need not be smooth"""
        return edges_of(self.trajectory)

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate the trajectory."""
        return self.trajectory(t, order)


@dataclass(frozen=True, eq=False)
class Turning:
    """Look along a horizontal vector that changes with time; where it is short, turn to where it points next.

    The yaw is ψ = atan2(d_y, d_x) with the derivatives of the vector d

        ψ' = (d × d') / d²,      ψ'' = (d × d'' - 2 ψ' d·d') / d²,

    and in between a polynomial of degree 5 that continues ψ, ψ' and ψ'' at both ends, the short way round.
    """

    target: "Along | Towards"
    """the vector"""
    times: Array
    """(n,) s, so close that the vector turns by less than half round from one to the next"""
    angles: Array
    """(n,) rad, unwrapped, at these times"""
    gaps: Array
    """(gaps, 2) s, when each turn begins and ends, in order and apart"""
    turns: Array
    """(gaps, 6) rad, ascending powers of the share of the gap"""

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate yaw or its first or second derivative."""
        time = np.clip(np.asarray(t, float), 0.0, self.times[-1])
        out = np.empty(time.shape)
        k = self.gaps[:, 0].searchsorted(time, side="right") - 1
        within = (k >= 0) & (time <= self.gaps[k, 1]) if len(self.gaps) else np.zeros(time.shape, bool)
        if not within.all():
            out[~within] = self.free(time[~within], order)
        if within.any():
            begin, end = self.gaps[k[within]].T
            out[within] = quintic(self.turns[k[within]], (time[within] - begin) / (end - begin), order)
            out[within] /= (end - begin) ** order
        return out

    def free(self, t: Array, order: int) -> Array:
        """Return yaw or a derivative (n,) of the vector at times (n,) outside the gaps."""
        angle = pointing(self.target, t, order)
        if order == 0:
            near = np.clip(self.times.searchsorted(t), 0, len(self.times) - 1)
            angle = angle + 2 * np.pi * np.round((self.angles[near] - angle) / (2 * np.pi))
        return angle


@dataclass(frozen=True, eq=False)
class Along:
    """The velocity of a trajectory."""

    trajectory: Trajectory
    least: float = LEAST_SPEED
    """m/s"""

    def __call__(self, t: Array, order: int) -> Array:
        """Return a derivative of the velocity, (n, 2)."""
        return self.trajectory(t, order + 1)[..., :2]


@dataclass(frozen=True, eq=False)
class Towards:
    """What leads from a trajectory to a point."""

    trajectory: Trajectory
    point: Array
    """(2,) m, or more"""
    least: float = LEAST_DISTANCE
    """m"""

    def __call__(self, t: Array, order: int) -> Array:
        """Return a derivative of the vector, (n, 2)."""
        offset = np.asarray(self.point, float)[:2] if order == 0 else 0.0
        return np.asarray(offset - self.trajectory(t, order)[..., :2])


def along_velocity(trajectory: Trajectory, before: float = 0.0) -> Yaw:
    """Look where the vehicle flies.

    Slower than 0.2 m/s the yaw goes over from the direction before to the one after, at no more than 1.5 rad/s where
    there is time for it: at a reversal the vehicle turns round, at a rest without one it looks on. Before it first
    moves it looks where it will fly, and so it does all the time where it turns too often to follow. Flown straight
    up, the yaw is `before` (rad).
    """
    return turning(Along(trajectory), before)


def towards(trajectory: Trajectory, point: Array, before: float = 0.0) -> Yaw:
    """Look at a point (2 or 3 coordinates, m); nearer than 0.2 m as `along_velocity` does when slow."""
    return turning(Towards(trajectory, point), before)


def turning(target: Along | Towards, before: float) -> Yaw:
    """Return the yaw along a vector; `before` (rad) where it is short all the time."""
    times = sampled(target)
    is_short = np.hypot(*target(times, 0).T) < target.least
    if is_short.all():
        return Fixed(before)
    gaps = widened(target, times, is_short)
    angles = np.full(len(times), np.nan)
    known = ~inside(gaps, len(times)) & ~is_short
    if not known.any():
        return Fixed(float(pointing(target, times[~is_short][:1], 0)[0]))
    angles[known] = np.unwrap(pointing(target, times[known], 0))
    turns = np.array([joined(target, times, angles, gap) for gap in gaps]).reshape(-1, 6)
    return Turning(target, times, angles, times[gaps], turns)


def sampled(target: Along | Towards) -> Array:
    """Return times (n,) s so close that a vector longer than the least turns by less than one radian in between."""
    duration = target.trajectory.duration
    coarse = np.linspace(0.0, duration, 2000)
    fastest = float(np.hypot(*target(coarse, 1).T).max())
    spacing = max(FINEST, 0.5 * target.least / fastest) if fastest > 0 else duration
    count = int(min(SAMPLES, max(2000.0, np.ceil(duration / spacing)))) + 1
    return np.linspace(0.0, duration, count)


def pointing(target: Along | Towards, t: Array, order: int) -> Array:
    """Return the angle of a vector or its first or second derivative, (n,) rad/s^order, at times (n,) s."""
    x, y = np.moveaxis(target(t, 0), -1, 0)
    if order == 0:
        return np.asarray(np.arctan2(y, x))
    square = x * x + y * y
    vx, vy = np.moveaxis(target(t, 1), -1, 0)
    rate = (x * vy - y * vx) / square
    if order == 1:
        return np.asarray(rate)
    ax, ay = np.moveaxis(target(t, 2), -1, 0)
    return np.asarray((x * ay - y * ax - 2 * rate * (x * vx + y * vy)) / square)


def widened(target: Along | Towards, times: Array, is_short: NDArray[np.bool_]) -> Indices:
    """Return the samples (gaps, 2) between which the yaw turns: around where the vector is short, as long as it needs.

    A turn by Δ takes at least 15/8 Δ / TURN_RATE seconds; turns that meet are one.
    """
    steps = np.diff(np.concatenate([[0], is_short.astype(int), [0]]))
    last = len(times) - 1
    gaps = np.column_stack([np.flatnonzero(steps > 0) - 1, np.flatnonzero(steps < 0)]).clip(0, last)
    while len(gaps):
        gaps = merged(gaps)
        begin, end = pointing(target, times[gaps.T], 0)
        turn = np.where(is_short[gaps].any(axis=1), 0.0, np.abs(np.angle(np.exp(1j * (end - begin)))))
        lack = QUINTIC_PEAK * turn / TURN_RATE - np.diff(times[gaps])[:, 0]
        lack[(gaps == [0, last]).all(axis=1)] = 0.0
        if lack.max() <= 0:
            break
        more = np.ceil(np.maximum(lack, 0.0) / (2 * times[1])).astype(int)
        gaps = np.column_stack([gaps[:, 0] - more, gaps[:, 1] + more]).clip(0, last)
    return gaps


def merged(gaps: Indices) -> Indices:
    """Return intervals (n, 2) in order, those that meet as one."""
    if not len(gaps):
        return gaps
    gaps = gaps[gaps[:, 0].argsort()]
    reached = np.maximum.accumulate(gaps[:, 1])
    new = np.concatenate([[True], gaps[1:, 0] > reached[:-1]])
    return np.column_stack([gaps[new, 0], reached[np.append(np.flatnonzero(new)[1:] - 1, len(gaps) - 1)]])


def inside(gaps: Indices, count: int) -> NDArray[np.bool_]:
    """Return which of `count` samples are between the ends of a gap."""
    change = np.zeros(count + 1, int)
    np.add.at(change, gaps[:, 0] + 1, 1)
    np.add.at(change, gaps[:, 1], -1)
    return np.cumsum(change)[:-1] > 0


def joined(target: Along | Towards, times: Array, angles: Array, gap: Indices) -> Array:
    """Return the ascending coefficients (6,) over a gap from one end to the other; an end without yaw is at rest."""
    length = float(times[gap[1]] - times[gap[0]])
    values = np.zeros((2, 3))
    for end, k in enumerate(gap):
        if np.isfinite(angles[k]):
            values[end] = [angles[k], *(length**order * float(pointing(target, times[k], order)) for order in (1, 2))]
        else:
            values[end, 0] = angles[gap[1 - end]]
    first, last = values
    a = last[0] - first[0] - first[1] - 0.5 * first[2]
    b, c = last[1] - first[1] - first[2], last[2] - first[2]
    return np.array(
        [first[0], first[1], 0.5 * first[2], 10 * a - 4 * b + 0.5 * c, -15 * a + 7 * b - c, 6 * a - 3 * b + 0.5 * c]
    )


def quintic(coefficients: Array, u: Array, order: int) -> Array:
    """Return the derivative by `u` (n,) of an order of polynomials (n, 6)."""
    powers = np.arange(6)
    factors = np.array([perm(int(power), order) for power in powers], float)
    return np.asarray((coefficients * factors * u[:, None] ** np.maximum(powers - order, 0)).sum(axis=1))
