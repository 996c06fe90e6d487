"""Plans for tests, in an open sky."""

from dataclasses import replace
from typing import Any

import numpy as np

from crosstrack.flight.flight import Flight
from crosstrack.flight.loop import fly
from crosstrack.flight.plan import Plan
from crosstrack.follow.carrot import Carrot
from crosstrack.follow.course import plan_course
from crosstrack.path.pace import course_of
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Scenario
from crosstrack.track.feed_forward import FeedForward
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Air, Array, Limits, Mismatch, Noise, Outcome, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.world import World

LIMITS, CALM, EXACT, STANDARD, NOMINAL = Limits(), Wind(), Noise(), Air(), Mismatch()


def plan_for(
    points: Any,
    *,
    vehicle: Any = None,
    tracker: Any = None,
    speed: float = 5.0,
    tolerance: float = 0.3,
    start: tuple[float, float, float] | None = None,
    yaw: float = 0.0,
    world: Any = None,
    limits: Limits = LIMITS,
    wind: Wind = CALM,
    noise: Noise = EXACT,
    air: Air = STANDARD,
    rate: float = 50.0,
    timeout: float = 300.0,
    closed: bool = False,
    seed: int = 1,
) -> Plan:
    route = Polyline(points, closed)
    vehicle = vehicle or Quadrotor()
    scenario = Scenario(
        position=np.array(start) if start else route(0.0),
        yaw=yaw,
        world=world or World(),
        cruise=speed,
        limits=limits,
        wind=wind,
        air=air,
        noise=noise,
        period=1 / rate,
        seed=seed,
    )
    entry = np.array(start) if start else None
    course = plan_course(route, tolerance, speed, vehicle.envelope(scenario), entry)
    return Plan("test", {}, route, course, vehicle, tracker or Carrot(), scenario, timeout)


class Report:
    """A flight and its errors against the route."""

    def __init__(self, flight: Flight) -> None:
        self.flight, self.outcome, record = flight, flight.outcome, flight.record
        self.time, self.position = record.time, record.position
        self.speed = np.linalg.norm(record.velocity, axis=1)
        entry = flight.plan.course.entry
        self.progress, self.error = flight.plan.route.trace(record.position, entry)
        below = np.flatnonzero(self.error < 0.05)
        self.captured = self.error[below[0] :] if below.size else np.array([np.inf])
        self.rms = float(np.sqrt(np.mean(self.error**2)))
        self.captured_rms = float(np.sqrt(np.mean(self.captured**2)))
        self.end_error = float(np.linalg.norm(self.position[-1] - flight.plan.route(flight.plan.route.length)))

    @property
    def arrived(self) -> bool:
        return self.outcome is Outcome.ARRIVED


def flown(points: Any, **options: Any) -> Report:
    return Report(fly(plan_for(points, **options)))


FAST = Limits(speed=14.0, acceleration=20.0, tilt_deg=65.0)
TOUR = np.array([[0.0, 0, 10], [15, 0, 10], [25, 12, 14], [10, 20, 12], [-5, 10, 10], [0, -10, 11], [20, -10, 10]])


def tour(speed: float, points: Array = TOUR) -> PiecewisePolynomial:
    """Minimum snap through points with a top speed (m/s)."""
    times = np.linalg.norm(np.diff(points, axis=0), axis=1) * 1.0
    times[[0, -1]] *= 1.6
    curve = minimum(points, np.concatenate([[0.0], np.cumsum(times)]), 4)
    top = float(np.linalg.norm(curve(np.linspace(0, curve.duration, 2000), 1), axis=1).max())
    return minimum(points, curve.knots * (top / speed), 4)


def plan_along(curve: Any, tracker: Any = None, mismatch: Mismatch = NOMINAL, **options: Any) -> Plan:
    """Plan to fly a trajectory, by default with feed-forward and room to tilt."""
    route = curve(np.linspace(0, curve.duration, 300))
    plan = plan_for(route, tracker=tracker or FeedForward(), **{"limits": FAST, **options})
    scenario = replace(plan.scenario, mismatch=mismatch)
    return replace(plan, course=course_of(curve, plan.course.envelope), scenario=scenario)


def lag(flight: Flight, curve: Any) -> Array:
    """Return the distances (n,) m to where the trajectory is at each time."""
    record = flight.record
    return np.asarray(np.linalg.norm(record.position - curve(record.time - record.time[0]), axis=1))


def rms(error: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(error**2)))
