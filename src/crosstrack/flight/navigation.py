"""Planning again in flight: when the course is no good any more, and from where to where."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from crosstrack.errors import Infeasible, Unreachable
from crosstrack.flight.plan import Plan, Replanning
from crosstrack.path.pace import course_of
from crosstrack.protocols import Course, Memory, Surroundings
from crosstrack.types import Array, State

AHEAD = 12.0
"""m of the course that are watched for obstacles"""
SPACING = 0.05
"""m, between the points of the course that are checked: between two of them it is 1.3 mm nearer, 0.25 m away"""
ADRIFT = 0.5
"""m, from where the trajectory is by then, beyond which it is not what is flown any more"""
BETWEEN = 0.2
"""m, to both sides of points of the course that are far enough from obstacles, within which none is checked"""
OFF = 0.15
"""m, from there, up to which a new course goes on from the trajectory, smoothly, and not from where the vehicle is"""
TRAPPED = 2.0
"""s, with less than LITTLE of the progress planned, while something keeps the vehicle from it"""
LITTLE = 0.2
"""of the progress planned"""
PAUSE = 0.5
"""s, at least between two plans that lead nowhere new"""
NEAR = 0.05
"""m, from a waypoint, that counts as there"""
URGENT = 4.0
"""m, to where the course is blocked, within which it is planned again at once"""
GRACE = 0.01
"""m, by which a course may turn out to be nearer to obstacles than it was planned with open eyes"""


@dataclass
class Navigator:
    """Where one vehicle is to go, and by what course."""

    plan: Plan
    course: Course = field(init=False)
    """the present one"""
    began: float = field(init=False)
    """s, when it began"""
    waypoints: Array = field(init=False)
    """(n, 3) m, that it leads through, the goal the last"""
    room: float = field(init=False)
    """m, from obstacles, nearer than which the course counts as blocked"""
    planning_time: float = field(init=False)
    """s of the machine, for all plans"""
    mark: tuple[float, float] = field(init=False)
    """progress (m) that counted last, and when (s)"""

    def __post_init__(self) -> None:
        self.planning_time = self.plan.planning_time
        self.room = self.plan.course.envelope.radius

    def take(self, course: Course, waypoints: Array, now: float) -> None:
        """Go by a course through waypoints (n, 3) m, from now on."""
        self.course, self.waypoints = course, waypoints
        self.began, self.mark = now, (course.entry, now)

    def remaining(self, progress: float) -> Array:
        """Return the waypoints (n, 3) m beyond a progress (m), at least the goal."""
        ahead = np.array(passed_at(self.course, self.waypoints)) > progress + NEAR
        ahead[-1] = True
        return self.waypoints[ahead]

    def again(self, state: State, around: Surroundings, memory: Memory, held: bool) -> Course | None:
        """Return a new course where the present one is no good any more, None where it is.

        Args:
            state: as estimated
            around: what is known now
            memory: of the tracker
            held: whether something kept the vehicle from what the tracker asked for

        Raises:
            Unreachable: there is no way to the goal.
        """
        replanning = self.plan.replanning
        if replanning is None or not self.due(replanning, state, around, memory.progress, held):
            return None
        waypoints = self.remaining(memory.progress)
        began = time.perf_counter()
        try:
            course = self.planned(replanning, state, around, waypoints)
        except Unreachable:
            raise
        except Infeasible:  # from this motion: the chain of avoiders brakes, and the next plan begins slower
            self.mark = (memory.progress, state.time)
            return None
        finally:
            self.planning_time += time.perf_counter() - began
        self.take(course, waypoints, state.time)
        self.room = self.least_room(around, course)
        return course

    def due(self, replanning: Replanning, state: State, around: Surroundings, progress: float, held: bool) -> bool:
        """Return whether it is time for a new course."""
        if self.trapped(state.time, progress, held):
            return True
        if not replanning.blocked:
            return False
        rested = state.time - self.began > PAUSE
        if rested and (self.adrift(state) or self.short(state.time)):
            return True
        return bool(around.scans) and self.blocked(around, progress) < (AHEAD if rested else URGENT)

    def trapped(self, now: float, progress: float, held: bool) -> bool:
        """Return whether the vehicle is held back and has long made next to no progress."""
        gained, since = progress - self.mark[0], now - self.mark[1]
        usual = self.course.path.length / self.course.speed.duration
        if not held or gained > LITTLE * usual * TRAPPED:
            self.mark = (progress, now)
            return False
        return since > TRAPPED

    def adrift(self, state: State) -> bool:
        """Return whether the vehicle is far from where its trajectory is by now."""
        return self.course.trajectory is not None and self.off(state) > ADRIFT

    def off(self, state: State) -> float:
        """Return how far (m) the vehicle is from where its trajectory is by now; inf without one."""
        trajectory = self.course.trajectory
        if trajectory is None:
            return np.inf
        return float(np.linalg.norm(trajectory(state.time - self.began) - state.position))

    def short(self, now: float) -> bool:
        """Return whether the course ends before the goal, and that end is near in time."""
        trajectory, goal = self.course.trajectory, self.waypoints[-1]
        if trajectory is None or now - self.began < trajectory.duration / 2:
            return False
        return float(np.linalg.norm(trajectory(trajectory.duration) - goal)) > NEAR

    def blocked(self, around: Surroundings, progress: float) -> float:
        """Return how far ahead (m) the course leads too near to an obstacle; inf where it does not."""
        path = self.course.path
        end = min(path.length, progress + AHEAD)
        s = np.minimum(np.arange(progress, end + 2 * BETWEEN, 2 * BETWEEN), end)
        near = s[around.obstacles.distance(path(s)) - self.room < BETWEEN]  # beside the others nothing is
        s = (near[:, None] + np.arange(-BETWEEN, BETWEEN, SPACING)).ravel()
        s = s[(s >= progress) & (s <= end)]
        blocked = s[around.obstacles.distance(path(s)) < self.room]
        return float(blocked[0]) - progress if blocked.size else np.inf

    def least_room(self, around: Surroundings, course: Course) -> float:
        """Return the distance (m) from obstacles that a course has by what is known now, at most the vehicle's radius.

        A course may have to lead nearer, as out of a tight place: then it is not blocked for that.
        """
        points = course.path(np.arange(0.0, min(course.path.length, AHEAD), SPACING))
        return min(course.envelope.radius, float(around.obstacles.distance(points).min()) - GRACE)

    def planned(self, replanning: Replanning, state: State, around: Surroundings, waypoints: Array) -> Course:
        """Return the course from here through waypoints (n, 3) m."""
        position, motion = self.now(state)
        task = replace(
            replanning.task,
            waypoints=np.concatenate([position[None], waypoints]),
            motion=motion,
            world=around.obstacles,
        )
        course = course_of(replanning.planner.plan(task), self.course.envelope)
        return replace(course, corners=task.waypoints)

    def now(self, state: State) -> tuple[Array, Array]:
        """Return position (3,) and velocity and acceleration (2, 3) to go on from.

        Those of the present trajectory where it is followed, so that the new one goes on smoothly.
        """
        trajectory, t = self.course.trajectory, state.time - self.began
        if trajectory is None or self.off(state) > OFF:
            return state.position, np.array([state.velocity, np.zeros(3)])
        return trajectory(t), np.array([trajectory(t, 1), trajectory(t, 2)])


def passed_at(course: Course, waypoints: Array) -> list[float]:
    """Return the arc length (m) at which a course passes each of some waypoints (n, 3) m, in their order."""
    found, s = [], course.entry
    for point in waypoints:
        s = course.path.project(point, s, course.path.length - s)
        found.append(s)
    return found
