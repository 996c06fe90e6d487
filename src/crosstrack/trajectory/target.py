"""Follow a moving target through obstacles: predict, guide, keep to free space, plan again.

The trail of a target, where it has been seen and where it is predicted to go, is a way through the obstacles that
something has already found. The vehicle is guided along it, a distance behind, within a tube around it whose radius
the distance field certifies as free. Every plan ends at rest inside its tube, so that one that is not replaced in
time hits nothing.

Source: Chen, Liu, Shen 2016, Tracking a moving target in cluttered environments using a quadrotor (IROS): prediction
by regression with a bounded acceleration (section IV), position of the target as guide of a trajectory in a corridor
of free space (section V). The trail in place of a search, the tube in place of boxes and the rest at the end are
ours.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from crosstrack.errors import Infeasible, InputError, Problem
from crosstrack.protocols import Map
from crosstrack.trajectory.conditions import numbers
from crosstrack.trajectory.constrained.corridor import Tube
from crosstrack.trajectory.guide import Guide, chord
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Finite, NonNegative, Positive

SPACING = 0.25
"""m, between the points of a trail: what is less is noise of the sightings"""
NARROWEST = 0.02
"""m, radius of a tube that is still worth a try"""
WIDEST = 1.5
"""m"""
PACE = 0.8
"""of the speed limit, that the waypoints ask for at most"""
HASTE = 0.6
"""of the acceleration limit, likewise: the rest is for turns, and for being smooth"""
CATCH_UP = 1.0
"""s, in which what is late is made up for"""


@dataclass(frozen=True)
class Pursuit:
    """How to follow a target."""

    distance: Positive = 3.0
    """m, behind it along its trail"""
    height: Finite = 0.0
    """m, above it"""
    clearance: NonNegative = 0.4
    """m, to obstacles, as exact as `Map.swept`: the radius of the vehicle and how far it may be off"""
    horizon: Positive = 2.0
    """s, that a plan looks ahead, before it comes to rest"""
    segments: int = 5
    """of a plan, equal in time"""
    memory: Positive = 1.0
    """s, age at which a sighting counts 1/e in the prediction"""
    stiffness: NonNegative = 0.02
    """s⁴, weight of the predicted mean square acceleration over that of the mean square error"""
    position_weight: NonNegative = 5000.0
    """1/s⁶, λ of the guide of position"""
    velocity_weight: NonNegative = 200.0
    """1/s⁴, λ of the guide of velocity"""
    limits: MotionLimits = field(default_factory=lambda: MotionLimits(speed=4.0, acceleration=5.0))

    @property
    def moments(self) -> Array:
        """(segments + 1,) s, from now to the horizon"""
        return np.linspace(0.0, self.horizon, self.segments + 1)


@dataclass(frozen=True, eq=False)
class TargetPlan:
    """One plan behind a target."""

    trajectory: PiecewisePolynomial
    """minimum jerk, from now on, at rest at its end"""
    predicted: PiecewisePolynomial
    """where the target will be, from now on over the horizon"""
    waypoints: Array
    """(segments + 1, 3) m, along the trail"""
    radii: Array
    """(segments,) m, of the tube around the lines between them, in which the trajectory stays at every instant"""


def track_target(
    times: Array, positions: Array, now: float, state: Array, world: Map, pursuit: Pursuit | None = None
) -> TargetPlan:
    """Plan behind a target; call it again every so often from where the plan then is.

    Args:
        times: (n,) s, when the target was seen, increasing, at least two; back to when it was where the vehicle is now
        positions: (n, 3) m, where
        now: s, when the plan begins, not before the last sighting
        state: (3, 3) position, velocity and acceleration of the vehicle now: of the plan that it flies
        world: whose distance is 1-Lipschitz
        pursuit: how

    Raises:
        InputError: all that is wrong with the arguments.
        Infeasible: there is no free way to the trail, or none within the limits. The plan flown so far stays good.
    """
    pursuit = pursuit or Pursuit()
    times, positions, state = checked(times, positions, now, state)
    predicted = predict(times, positions, now, pursuit)
    trail = Trail.of(times, positions, now, predicted, pursuit.height).joined(state[0])
    wanted = trail.length(now + pursuit.moments) - pursuit.distance
    moments, lengths = paced(wanted, max(float(state[1] @ trail.direction()), 0.0), pursuit)
    waypoints, radii = free_tube(trail.at(lengths), world, pursuit.clearance)
    early = trail.at(np.clip(np.append(wanted, np.inf), 0.0, lengths))
    run = chord(early, np.diff(moments))
    guides = (Guide(run, pursuit.position_weight), Guide(run.derivative(), pursuit.velocity_weight, 1))
    trajectory = minimum(
        waypoints, moments, 3, start=state[1:], guide=guides, corridor=Tube(radii), limits=pursuit.limits
    )
    return TargetPlan(trajectory, predicted, waypoints, radii)


def checked(times: Array, positions: Array, now: float, state: Array) -> tuple[Array, Array, Array]:
    """Return sightings and state as arrays of finite numbers.

    Raises:
        InputError: all that is wrong with them.
    """
    found: list[Problem] = []
    moments, seen = numbers("times", times, 1, found), numbers("positions", positions, 2, found)
    motion = numbers("state", state, 2, found)
    if not found:
        if len(moments) < 2 or seen.shape != (len(moments), 3):
            message = (
                f"must be at least two points in space, one for each time, found {seen.shape} for {len(moments)} times"
            )
            found.append(Problem("positions", message))
        if not (np.diff(moments) > 0).all():
            found.append(Problem("times", "must increase"))
        if not now >= moments[-1]:
            found.append(Problem("now", f"must not be before the last sighting, {moments[-1]:g} s, found {now!r}"))
        if motion.shape != (3, 3):
            found.append(Problem("state", f"must be position, velocity and acceleration (3, 3), found {motion.shape}"))
    if found:
        raise InputError("track_target", found)
    return moments, seen, motion


def predict(times: Array, positions: Array, now: float, pursuit: Pursuit) -> PiecewisePolynomial:
    """Return where a target will be over the horizon: the cubic g from now on that minimises the following.

        Σ w_k ‖g(t_k) - z_k‖² / Σ w_k  +  stiffness · mean of ‖g''‖²,      w_k = exp(-(now - t_k) / memory)

    The mean is over the last `memory` and the horizon to come.
    """
    age = (times - now) / pursuit.horizon
    powers = np.arange(4)
    rows = age[:, None] ** powers
    weights = np.exp(age * pursuit.horizon / pursuit.memory)
    weights /= weights.sum()
    nodes, shares = np.polynomial.legendre.leggauss(2)
    since = -pursuit.memory / pursuit.horizon
    moments = since + (1 - since) * (1 + nodes) / 2
    bend = powers * (powers - 1) * moments[:, None] ** np.maximum(powers - 2, 0) / pursuit.horizon**2
    origin = positions[-1]
    normal = (rows.T * weights) @ rows + pursuit.stiffness * (bend.T * shares / 2) @ bend
    found = np.linalg.lstsq(normal, (rows.T * weights) @ (positions - origin), rcond=None)[0]
    coefficients = found / pursuit.horizon ** powers[:, None]
    coefficients[0] += origin
    return PiecewisePolynomial(np.array([pursuit.horizon]), coefficients[None])


@dataclass(frozen=True, eq=False)
class Trail:
    """Where a target was and will be, as a polyline."""

    points: Array
    """(n, 3) m"""
    times: Array
    """(n,) s"""
    lengths: Array
    """(n,) m, along it"""

    @staticmethod
    def of(times: Array, positions: Array, now: float, predicted: PiecewisePolynomial, height: float) -> "Trail":
        """Return the trail of sightings, thinned to what is motion, and of a prediction."""
        ahead = np.linspace(0, predicted.duration, 9)
        points, moments = np.concatenate([positions, predicted(ahead)]), np.concatenate([times, now + ahead])
        kept = [0]
        for i in range(1, len(points)):
            if np.linalg.norm(points[i] - points[kept[-1]]) >= SPACING:
                kept.append(i)
        if len(kept) == 1:
            kept.append(len(points) - 1)
        return Trail.through(points[kept] + [0.0, 0.0, height], moments[kept])

    @staticmethod
    def through(points: Array, times: Array) -> "Trail":
        """Return the trail through points (n, 3) m at times (n,) s."""
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return Trail(points, times, np.concatenate([[0.0], np.cumsum(steps)]))

    def at(self, length: Array) -> Array:
        """Return the points (n, 3) at lengths (n,)."""
        return np.stack([np.interp(length, self.lengths, axis) for axis in self.points.T], axis=1)

    def length(self, time: Array) -> Array:
        """Return how far along it the target is at times (n,) s."""
        return np.interp(time, self.times, self.lengths)

    def direction(self) -> Array:
        """Return the unit vector (3,) along its first leg."""
        leg = self.points[1] - self.points[0]
        return np.asarray(leg / max(float(np.linalg.norm(leg)), np.finfo(float).tiny))

    def joined(self, position: Array) -> "Trail":
        """Return it from a position (3,) on, that it is joined from as far ahead of the foot as the foot is away."""
        foot = self.foot(position)
        away = float(np.linalg.norm(self.at(np.array([foot]))[0] - position))
        ahead = min(foot + away, float(self.lengths[-1]))
        rest = self.lengths > ahead + SPACING / 10
        entry = np.array([ahead] if away > SPACING / 10 else [])
        points = np.concatenate([position[None], self.at(entry), self.points[rest]])
        entered = np.interp([foot, *entry], self.lengths, self.times)
        times = np.concatenate([entered, self.times[rest]])
        if len(points) == 1:
            points, times = np.concatenate([points, self.points[-1:]]), np.append(times, self.times[-1] + 1.0)
        return Trail.through(points, times)

    def foot(self, point: Array) -> float:
        """Return the length at the point nearest to a point (3,)."""
        starts, legs = self.points[:-1], np.diff(self.points, axis=0)
        square = np.maximum((legs**2).sum(axis=1), 1e-12)
        share = np.clip(((point - starts) * legs).sum(axis=1) / square, 0, 1)
        gaps = np.linalg.norm(starts + share[:, None] * legs - point, axis=1)
        k = int(gaps.argmin())
        return float(self.lengths[k] + share[k] * np.sqrt(square[k]))


def paced(wanted: Array, speed: float, pursuit: Pursuit) -> tuple[Array, Array]:
    """Return times (n,) s from now on and how far along the trail the waypoints are then (n,) m, the last at rest.

    A point that begins at 0 m with the speed of the vehicle changes it by no more than a share of the acceleration
    limit, stays below a share of the speed limit, never goes back, and makes up for what it is late.

    Args:
        wanted: (n - 1,) m, where along the trail it is to be
        speed: m/s, of the vehicle along the trail
        pursuit: how
    """
    step = pursuit.horizon / pursuit.segments
    most, change = PACE * (pursuit.limits.speed or np.inf), HASTE * (pursuit.limits.acceleration or np.inf) * step
    lengths = [0.0]
    for before, goal in pairwise(wanted):
        late = goal - lengths[-1] - speed * step
        asked = np.clip((goal - before) / step + late / CATCH_UP, 0.0, most)
        after = speed + np.clip(asked - speed, -change, change)
        lengths.append(lengths[-1] + 0.5 * (speed + after) * step)
        speed = after
    braking = max(speed * step / change, step)
    lengths.append(lengths[-1] + 0.5 * speed * braking)
    return np.append(pursuit.moments, pursuit.horizon + braking), np.array(lengths)


def free_tube(waypoints: Array, world: Map, clearance: float) -> tuple[Array, Array]:
    """Return waypoints (n, 3) m, the same from where the way is blocked on, and radii (n - 1,) m of free tubes.

    Raises:
        Infeasible: the way to the second waypoint is blocked.
    """
    waypoints, radii = waypoints.copy(), np.empty(len(waypoints) - 1)
    for i in range(len(radii)):
        radii[i] = world.swept(waypoints[i], waypoints[i + 1]) - clearance
        if radii[i] < NARROWEST and i > 0:
            waypoints[i + 1 :] = waypoints[i]
            radii[i] = world.swept(waypoints[i], waypoints[i]) - clearance
    if radii[0] < NARROWEST:
        message = f"the straight way to the trail comes within {radii[0] + clearance:.3g} m of an obstacle"
        raise Infeasible("track_target", [Problem("waypoints[1]", f"{message}, {clearance + NARROWEST:g} m is needed")])
    return waypoints, np.minimum(radii, WIDEST)
