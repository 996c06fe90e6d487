"""Fly a trajectory by the clock: position, velocity and acceleration, sent ahead of the vehicle's response."""

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.path.pieces import reach_of
from crosstrack.protocols import Course, Trajectory
from crosstrack.types import Array, NonNegative, Setpoint, State


@runtime_checkable
class Facing(Protocol):
    """A trajectory that also says where to look."""

    def yaw(self, t: float | Array, order: int = 0) -> Array:
        """Evaluate at the time `t` (s, shape (...)): yaw or its derivative of an order, (...) rad/s^order."""


@dataclass(frozen=True)
class FeedForwardMemory:
    """What following a trajectory remembers."""

    progress: float
    """m, arc length of the closest point"""
    aim: Array
    """(3,) m, where the trajectory is now"""
    start: float
    """s, when it began, on the vehicle's clock"""
    error: float
    """m, cross-track error"""


@dataclass(frozen=True)
class FeedForward:
    """Follow a trajectory by the clock.

    A command is held for the period T and so is on average T/2 old, and the vehicle flies an acceleration its response
    time τ after it is asked for. With the time t since the start, t' = t + T/2, the trajectory p and the lead λ,

        position = p(t'),      velocity = p'(t'),      acceleration = p''(t' + λτ),

    and yaw and yaw rate at t' where the trajectory has them. After its end the last point is held.

    Source: Faessler, Franchi, Scaramuzza 2018 (RA-L 3(2), section IV): reference and feed-forward terms of a
    trajectory; the times ahead are ours.
    """

    needs = ("trajectory",)

    lead: NonNegative = 1.0
    """1, λ, how far ahead the acceleration is sent over the vehicle's response time"""

    def start(self, course: Course, state: State) -> FeedForwardMemory:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory.
        """
        foot = course.path(course.entry)
        error = float(np.linalg.norm(foot - state.position))
        return FeedForwardMemory(course.entry, trajectory_of(course)(0.0), state.time, error)

    def step(
        self, memory: FeedForwardMemory, course: Course, state: State, duration: float
    ) -> tuple[Setpoint, FeedForwardMemory]:
        """Return the motion to fly for the next `duration` (s), and the new memory."""
        trajectory, now = trajectory_of(course), state.time - memory.start
        moved = math.sqrt(state.velocity @ state.velocity) * duration
        s = course.path.project(state.position, memory.progress, reach_of(memory.error, moved))
        offset = course.path(s) - state.position
        memory = FeedForwardMemory(s, trajectory(now), memory.start, math.sqrt(offset @ offset))
        then = now + 0.5 * duration
        yaw, yaw_rate = look(trajectory, then)
        return Setpoint(
            position=trajectory(then),
            velocity=derivative(trajectory, then, 1),
            acceleration=derivative(trajectory, then + self.lead * course.envelope.response_time, 2),
            yaw=yaw,
            yaw_rate=yaw_rate,
        ), memory


def trajectory_of(course: Course) -> Trajectory:
    """Return the trajectory of a course, or raise InputError."""
    if course.trajectory is None:
        message = "feed_forward follows a trajectory, and the course is a path only: add a `planner`"
        raise InputError("course", [Problem("tracker", message)])
    return course.trajectory


def derivative(trajectory: Trajectory, t: float, order: int) -> Array:
    """Return a derivative at the time `t` (s), (3,); zero after the end, where the last point is held."""
    return trajectory(t, order) if t <= trajectory.duration else np.zeros(3)


def look(trajectory: Trajectory, t: float) -> tuple[float, float]:
    """Return yaw (rad) and yaw rate (rad/s) at the time `t` (s), NaN where the trajectory leaves them open."""
    if not isinstance(trajectory, Facing):
        return math.nan, math.nan
    return float(trajectory.yaw(t)), float(trajectory.yaw(t, 1)) if t <= trajectory.duration else 0.0
