"""The speed of a trajectory by arc length, and the trajectory as a course."""

from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.path.cells import pace
from crosstrack.path.traced import Traced, traced
from crosstrack.protocols import Course, Trajectory
from crosstrack.types import Array, Envelope

START = 0.05
"""m, within which of a stop the speed is held at what it is there, at most a quarter of the way to the next"""


@dataclass(frozen=True, eq=False)
class Pace:
    """The speed that a trajectory has at each point of its path.

    By arc length a rest has no end: what is slower the closer it is never gets away. So within 0.05 m of a stop the
    speed is at least the one that the trajectory has there, before and after. The end of the path is no such stop.
    """

    path: Traced
    duration: float
    """s, of the trajectory"""
    zones: Array
    """(2 stops,) m, where the stretches before and after each stop begin"""
    ends: Array
    """(2 stops,) m, where they end"""
    least: Array
    """(2 stops,) m/s, speed there"""

    def __call__(self, s: float | Array, order: int = 0) -> Array:
        """Evaluate at arc length `s` (...): speed (m/s) or acceleration along the path (m/s²) for order 0, 1."""
        if isinstance(s, float):
            path = self.path
            arrays = path.knots, path.arcs, path.velocities, path.tangents, path.halves
            return np.asarray(pace_at(s, order, self.zones, self.ends, self.least, *arrays))
        s = np.asarray(s, float)
        speed = paced(self.path, s, 0)
        least = np.zeros(s.shape)
        if len(self.zones):
            k = np.maximum(self.zones.searchsorted(s, side="right") - 1, 0)
            least = np.where((self.zones[k] <= s) & (s < self.ends[k]), self.least[k], 0.0)
        if order == 0:
            return np.maximum(speed, least)
        return np.where(speed >= least, paced(self.path, s, 1), 0.0)


@compiled
def pace_at(
    s: float,
    order: int,
    zones: Array,
    ends: Array,
    least: Array,
    knots: Array,
    arcs: Array,
    velocities: Array,
    tangents: Array,
    halves: Array,
) -> float:
    """Return what `Pace` is at one arc length (m)."""
    where, out = np.array([s]), np.empty(1)
    pace(where, 0, knots, arcs, velocities, tangents, halves, out)
    speed, floor = out[0], 0.0
    if zones.size > 0:
        k = max(int(np.searchsorted(zones, s, side="right")) - 1, 0)
        floor = least[k] if zones[k] <= s < ends[k] else 0.0
    if order == 0:
        return float(max(speed, floor))
    if speed < floor:
        return 0.0
    pace(where, order, knots, arcs, velocities, tangents, halves, out)
    return float(out[0])


def paced(path: Traced, s: Array, order: int) -> Array:
    """Return speed (m/s) or acceleration along the path (m/s²) of the trajectory at `s` (...) m."""
    out = np.empty(s.size)
    pace(s.ravel(), order, path.knots, path.arcs, path.velocities, path.tangents, path.halves, out)
    return out.reshape(s.shape)


def pace_of(path: Traced, duration: float) -> Pace:
    """Return the speed along the path of a trajectory that lasts `duration` (s)."""
    stops = path.stops
    gaps = np.diff(np.concatenate([[0.0], stops, [path.length]]))
    before, after = np.minimum(START, gaps[:-1] / 4), np.minimum(START, gaps[1:] / 4)
    zones = np.column_stack([stops - before, stops]).ravel()
    ends = np.column_stack([stops, stops + after]).ravel()
    rims = np.column_stack([stops - before, stops + after]).ravel()
    return Pace(path, duration, zones, ends, paced(path, rims, 0))


def course_of(trajectory: Trajectory, envelope: Envelope) -> Course:
    """Return a trajectory as a course: its path, its speed along it, and itself.

    Raises:
        InputError: the trajectory is not in space, not finite, or goes nowhere.
    """
    path = traced(trajectory)
    return Course(path, pace_of(path, trajectory.duration), envelope, trajectory=trajectory)
