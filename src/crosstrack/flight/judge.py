"""When a flight is over, and why."""

import math
from dataclasses import dataclass, field

import numpy as np

from crosstrack.flight.plan import Plan
from crosstrack.protocols import Course
from crosstrack.types import Array, Outcome, State

PATIENCE = 10.0
"""s without progress after which a vehicle counts as stuck"""
CRAWL = 0.05
"""of the progress planned: less is none"""
ELSEWHERE = 1.0
"""m, from where it was stuck on another course, that a vehicle must get for a new course to count as a new chance"""
UPSIDE_DOWN = 0.0
"""least cosine of the tilt of a vehicle under control"""


@dataclass
class Judge:
    """Decides when a flight is over, and why."""

    plan: Plan
    start: State
    """at the first sample"""
    course: Course = field(init=False)
    """the present one"""
    began: float = field(init=False)
    """s, when it began"""
    best: float = field(default=0.0, init=False)
    """m, progress that counts"""
    since: float = field(init=False)
    """s, when it was reached"""
    place: Array = field(init=False)
    """(3,) m, where that was"""
    owed: float = field(default=0.0, init=False)
    """m, what the plan has covered since"""
    last: float = field(init=False)
    """s, time of the sample before"""
    visited: set[tuple[int, ...]] = field(default_factory=set, init=False)
    """cubes of ELSEWHERE that a vehicle which may leave its course has been in"""

    def __post_init__(self) -> None:
        self.course, self.place = self.plan.course, self.start.position
        self.began = self.since = self.last = self.start.time
        self.bends = any(not avoider.guards for avoider in self.plan.avoiders)
        self.goal = self.plan.route(self.plan.route.length)

    def renew(self, course: Course, now: State) -> None:
        """Take note of a new course."""
        self.course, self.began = course, now.time
        self.best, self.owed = course.entry, 0.0
        if np.linalg.norm(now.position - self.place) > ELSEWHERE:
            self.since, self.place = now.time, now.position

    def verdict(self, before: State, now: State, progress: float, clearance: float, touched: bool) -> Outcome | None:
        """Return the outcome once there is one; the worst comes first.

        Args:
            before: at the last sample
            now: at this one
            progress: m, along the course
            clearance: m, of the centre from obstacles, and from other vehicles beyond their radius
            touched: whether it hit the ground
        """
        plan = self.plan
        if not lawful(now):
            return Outcome.LOST_CONTROL
        if clearance < plan.vehicle.radius or touched:
            return Outcome.COLLIDED
        if plan.vehicle.arrived(before, now, self.goal, self.course.path.length - progress):
            return Outcome.ARRIVED
        bounds = plan.scenario.world.bounds
        if bounds is not None and not ((bounds[0] <= now.position) & (now.position <= bounds[1])).all():
            return Outcome.LEFT_BOUNDS
        if self.stuck(now, progress):
            return Outcome.STUCK
        if now.time - self.start.time >= plan.timeout - 1e-9:
            return Outcome.TIMED_OUT
        return None

    def stuck(self, now: State, progress: float) -> bool:
        """Return whether the vehicle has made next to none of the progress planned for as long as patience lasts.

        On a detour round obstacles, getting to where it has not been is progress too.
        """
        self.owed += self.planned(now.time)
        if progress - self.best >= CRAWL * self.owed:
            self.best, self.since, self.owed, self.place = progress, now.time, 0.0, now.position
        if self.bends:
            cube = tuple(np.floor(now.position / ELSEWHERE).astype(int).tolist())
            if cube not in self.visited:
                self.visited.add(cube)
                self.since = now.time
        return now.time - self.since > PATIENCE

    def planned(self, time: float) -> float:
        """Return how far (m) the plan goes from the sample before until this one; after its end, at its mean speed."""
        course, before, self.last = self.course, max(self.last, self.began), time
        timetable = course.trajectory
        if timetable is None or time - self.began > timetable.duration:
            return course.path.length / course.speed.duration * (time - before)
        return float(np.linalg.norm(timetable(time - self.began) - timetable(before - self.began)))


def lawful(state: State) -> bool:
    """Return whether a state is finite and upright."""
    x, y = state.attitude[0], state.attitude[1]
    squares = sum(v @ v for v in (state.position, state.velocity, state.attitude, state.rate))
    return math.isfinite(squares) and bool(1 - 2 * (x * x + y * y) > UPSIDE_DOWN)
