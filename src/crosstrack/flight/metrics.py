"""How well a flight went, in numbers."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.effort import Effort
from crosstrack.flight.plan import Plan
from crosstrack.flight.record import Record
from crosstrack.types import Array, Outcome

CAPTURED = 0.05
"""m, the cross-track error under which the route is captured"""


@dataclass(frozen=True)
class Metrics:
    """The numbers of one flight; None where there is nothing to measure.

    Means over time weigh every sample by the time it stands for (trapezoid rule).
    """

    flight_time_s: float
    """s, from the first sample to the last"""
    ideal_time_s: float
    """s, of the planned speed profile"""
    time_ratio: float | None
    """flight time over ideal time; None unless it arrived"""
    cross_track_rms_m: float
    """m, root mean square over time of the cross-track error"""
    cross_track_max_m: float
    """m"""
    cross_track_rms_captured_m: float | None
    """m, from the first time the error is under 0.05 m; None when it never is"""
    cross_track_max_captured_m: float | None
    """m, likewise"""
    captured_time_s: float | None
    """s after the first sample, when the error is first under 0.05 m"""
    tracking_rms_m: float | None
    """m, root mean square over time of the distance to where the trajectory is by then; None without a trajectory"""
    tracking_max_m: float | None
    """m, likewise"""
    final_error_m: float
    """m, from the last position to the end of the route"""
    final_speed_mps: float
    """m/s"""
    min_clearance_m: float | None
    """m, least swept distance from the centre to an obstacle; None without obstacles"""
    path_length_m: float
    """m, of the route"""
    flown_length_m: float
    """m, through the positions"""
    max_speed_mps: float
    """m/s"""
    mean_speed_mps: float
    """m/s, over time"""
    max_airspeed_mps: float | None
    """m/s, relative to the wind; None where the wind is not known"""
    max_acceleration_mps2: float | None
    """m/s², between samples, gravity excluded"""
    rms_jerk_mps3: float | None
    """m/s³, root mean square of the change of the acceleration between samples"""
    max_tilt_deg: float
    """degrees between body z and world z"""
    control_effort_radps: float | None
    """rad/s, root mean square of each rotor's speed about its own mean; None without rotors"""
    min_separation_m: float | None
    """m, least swept distance to the centre of another vehicle; None alone"""
    replans: int
    """courses planned in flight"""
    safety_interventions: int
    """times that an avoider which guards began to change the command"""
    planning_time_s: float
    """s, of the machine, for all plans"""
    decision_time_s: float
    """s, of the machine, median from what the sensors see to the command, plans left out"""
    decision_time_p99_s: float
    """s, of the machine, 99th percentile of the same"""
    wall_time_s: float
    """s, of the machine, spent flying"""


OF_THE_MACHINE = ("planning_time_s", "decision_time_s", "decision_time_p99_s", "wall_time_s")
"""metrics that differ from run to run"""


def measure(plan: Plan, outcome: Outcome, record: Record, effort: Effort, replans: int = 0) -> Metrics:
    """Measure a flight over the samples whose state is finite."""
    time, speed = record.time, np.linalg.norm(record.velocity, axis=1)
    error = cross_track(plan, record)
    known = np.isfinite(error) & np.isfinite(speed)
    duration = float(time[-1] - time[0])
    ideal = plan.course.speed.duration
    last = np.flatnonzero(known)[-1]
    return Metrics(
        flight_time_s=duration,
        ideal_time_s=ideal,
        time_ratio=duration / ideal if outcome is Outcome.ARRIVED and ideal > 0 else None,
        **_errors(time[known], error[known]),
        **_tracking(time[known], tracking(plan, record, replans > 0)[known]),
        final_error_m=float(np.linalg.norm(record.position[last] - plan.route(plan.route.length))),
        final_speed_mps=float(speed[last]),
        min_clearance_m=finite_or_none(float(record.clearance.min())),
        path_length_m=plan.route.length,
        flown_length_m=float(np.linalg.norm(np.diff(record.position[known], axis=0), axis=1).sum()),
        max_speed_mps=float(speed[known].max()),
        mean_speed_mps=mean(time[known], speed[known]),
        max_tilt_deg=float(np.degrees(tilt(record.attitude[known]).max())),
        control_effort_radps=_effort(record),
        min_separation_m=finite_or_none(float(record.separation.min())),
        replans=replans,
        safety_interventions=interventions(plan, record),
        planning_time_s=effort.planning,
        decision_time_s=effort.decision,
        decision_time_p99_s=effort.decision_worst,
        wall_time_s=effort.flying,
        **_motion(record, known),
    )


def cross_track(plan: Plan, record: Record) -> Array:
    """Return the distance from every position to the route near the progress, (n,) m; NaN where not finite.

    The progress is that of the position along the route, see `Pieces.trace`: it never goes back, so that routes
    may cross themselves, close or reverse.
    """
    position, route = record.position, plan.route
    finite = np.isfinite(position).all(axis=1)
    error = np.full(len(position), np.nan)
    entry = route.project(position[0], 0.0, route.length) if plan.course.entry > 0 else 0.0
    error[finite] = route.trace(position[finite], entry)[1]
    return error


def tracking(plan: Plan, record: Record, replanned: bool = False) -> Array:
    """Return the distance from every position to where the trajectory is by then, (n,) m.

    NaN where not finite, and without a trajectory. The trajectory begins at the first sample, and holds its end. Where
    it was planned again in flight, what a tracker of trajectories aims at tells where the last one is; a follower does
    not.
    """
    trajectory = plan.course.trajectory
    if trajectory is None or (replanned and "trajectory" not in plan.tracker.needs):
        return np.full(len(record.time), np.nan)
    if replanned:
        return np.asarray(np.linalg.norm(record.position - record.aim, axis=1))
    return np.asarray(np.linalg.norm(record.position - trajectory(record.time - record.time[0]), axis=1))


def interventions(plan: Plan, record: Record) -> int:
    """Return how often an avoider that guards began to change the command."""
    guards = sum(1 << k for k, avoider in enumerate(plan.avoiders) if avoider.guards)
    stepped_in = (record.interventions.astype(int) & guards) > 0
    return int((np.diff(stepped_in, prepend=False) & stepped_in).sum())


def mean(time: Array, values: Array) -> float:
    """Return the mean over time of samples (n,) by the trapezoid rule; of a single sample, itself."""
    if len(time) == 1:
        return float(values[0])
    return float(np.trapezoid(values, time) / (time[-1] - time[0]))


def tilt(attitude: Array) -> Array:
    """Return the angle between body z and world z of attitudes (n, 4) xyzw, (n,) rad: cos = 1 - 2 (x² + y²)."""
    return np.arccos(np.clip(1.0 - 2.0 * (attitude[:, 0] ** 2 + attitude[:, 1] ** 2), -1.0, 1.0))


def _errors(time: Array, error: Array) -> dict[str, Any]:
    under = np.flatnonzero(error < CAPTURED)
    start = under[0] if under.size else None
    captured = error[start:] if start is not None else None
    return {
        "cross_track_rms_m": math.sqrt(mean(time, error**2)),
        "cross_track_max_m": float(error.max()),
        "cross_track_rms_captured_m": None if captured is None else math.sqrt(mean(time[start:], captured**2)),
        "cross_track_max_captured_m": None if captured is None else float(captured.max()),
        "captured_time_s": None if start is None else float(time[start] - time[0]),
    }


def _tracking(time: Array, error: Array) -> dict[str, Any]:
    if not np.isfinite(error).all():
        return {"tracking_rms_m": None, "tracking_max_m": None}
    return {"tracking_rms_m": math.sqrt(mean(time, error**2)), "tracking_max_m": float(error.max())}


def _motion(record: Record, known: NDArray[np.bool_]) -> dict[str, Any]:
    time, velocity = record.time[known], record.velocity[known]
    step = np.diff(time)
    acceleration = np.diff(velocity, axis=0) / step[:, None]
    jerk = np.diff(acceleration, axis=0) / (0.5 * (step[1:] + step[:-1]))[:, None]
    airspeed = np.linalg.norm(velocity - record.wind[known], axis=1)
    return {
        "max_airspeed_mps": finite_or_none(float(airspeed.max())),
        "max_acceleration_mps2": float(np.linalg.norm(acceleration, axis=1).max()) if len(step) else None,
        "rms_jerk_mps3": float(np.sqrt((jerk**2).sum(axis=1).mean())) if len(jerk) else None,
    }


def _effort(record: Record) -> float | None:
    speeds = record.rotor_speeds
    if speeds.shape[1] == 0:
        return None
    about = [(rotor - mean(record.time, rotor)) ** 2 for rotor in speeds.T]
    return finite_or_none(math.sqrt(mean(record.time, np.mean(about, axis=0))))


def finite_or_none(value: float) -> float | None:
    """Return a number as JSON can have it."""
    return value if math.isfinite(value) else None
