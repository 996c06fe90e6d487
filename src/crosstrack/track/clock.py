"""What every tracker of trajectories shares: when it is, what is asked for then, and how far the vehicle has come."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course
from crosstrack.track.reference import ROWS, SPACING, Reference, reference, trajectory_of
from crosstrack.types import Array, Envelope, Model, State

EARLY = 1.0
"""m, that the closest point is looked for beyond where the trajectory has come to"""


@dataclass(frozen=True)
class Clock:
    """What following a trajectory remembers."""

    progress: float
    """m, arc length of the closest point"""
    aim: Array
    """(3,) m, where the trajectory is now"""
    began: float
    """s, when it began, on the vehicle's clock"""
    error: float
    """m, cross-track error"""
    reference: Reference
    """the stretch of the trajectory around now"""
    due: float
    """m, arc length that the trajectory has come to"""
    read: float
    """s, when that was, on the vehicle's clock"""

    def since(self, state: State) -> float:
        """Return the time (s) after the first sample of the stretch."""
        return state.time - self.began - self.reference.begin


@dataclass(frozen=True)
class Timed:
    """The memory of a tracker that remembers more than the clock."""

    clock: Clock

    @property
    def progress(self) -> float:
        """m, arc length of the closest point"""
        return self.clock.progress

    @property
    def aim(self) -> Array:
        """(3,) m, where the trajectory is now"""
        return self.clock.aim


def begin(course: Course, state: State, heading: float | None = None) -> Clock:
    """Begin the trajectory of a course now.

    Args:
        course: with a trajectory
        state: of the vehicle
        heading: rad, yaw of a trajectory that leaves it open; by default the one that the vehicle has

    Raises:
        InputError: the course has no trajectory.
    """
    trajectory = trajectory_of(course)
    foot = course.path(course.entry)
    error = float(np.linalg.norm(foot - state.position))
    yaw = heading_of(state.attitude) if heading is None else heading
    return Clock(course.entry, trajectory(0.0), state.time, error, reference(trajectory, yaw), course.entry, state.time)


def tick(clock: Clock, course: Course, state: State) -> Clock:
    """Return the clock now.

    Far off, the closest point may be one that the trajectory comes to much later, and is not taken for progress.
    """
    now = state.time - clock.began
    stretch = clock.reference.covering(now)
    row = stretch.rows[min(int((now - stretch.begin) / SPACING + 0.5), ROWS - 1)]
    passed = state.time - clock.read  # by the vehicle's clock: not all keep the period asked for
    due = clock.due + math.sqrt(row[3:6] @ row[3:6]) * passed
    moved = math.sqrt(state.velocity @ state.velocity) * passed
    reach = min(reach_of(clock.error, moved), max(0.0, due + EARLY - clock.progress))
    s = course.path.project(state.position, clock.progress, reach)
    offset = course.path(s) - state.position
    return Clock(s, row[:3], clock.began, math.sqrt(offset @ offset), stretch, due, state.time)


def heading_of(attitude: Array) -> float:
    """Return the yaw (rad) of an attitude xyzw."""
    x, y, z, w = attitude
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def model_of(course: Course) -> Model:
    """Return what is known of the vehicle to command attitudes or rates.

    Raises:
        InputError: the vehicle takes none.
    """
    if course.envelope.model is None:
        raise InputError("vehicle", [Problem("kind", "takes no attitudes or rates, which this tracker commands")])
    return course.envelope.model


def rate_delay(envelope: Envelope, model: Model) -> float:
    """Return the time (s) from a body rate asked for to the one flown and, where the estimate is late, seen."""
    return envelope.response_time - model.attitude_time
