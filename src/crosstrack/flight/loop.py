"""The flight loop: sense, track, avoid, command, and judge how it ends."""

import math
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from crosstrack.errors import LinkLost
from crosstrack.flight.flight import Flight
from crosstrack.flight.observer import Observer, Sample, collect
from crosstrack.flight.plan import Plan
from crosstrack.protocols import Session
from crosstrack.types import Array, AttitudeSetpoint, Command, Outcome, RateSetpoint, Setpoint, State

PATIENCE = 10.0
"""s without progress after which a vehicle counts as stuck"""
CRAWL = 0.05
"""of the progress planned: less is none"""
UPSIDE_DOWN = 0.0
"""least cosine of the tilt of a vehicle under control"""
OPEN = Setpoint()
"""all left to the vehicle"""
NO_ATTITUDE = np.full(4, np.nan)


def fly(plan: Plan, observers: Sequence[Observer] = ()) -> Flight:
    """Fly a plan to its end and return what happened; an interrupt (Ctrl-C) ends the flight, not the program.

    Observers see the plan, every sample as it is flown, and the outcome, also when an error ends the flight.
    """
    began = time.perf_counter()
    rows: list[Sample] = []
    outcome, wall_time = Outcome.FAILED, 0.0

    def tell(observer: Observer) -> None:
        observer.end(outcome, wall_time)

    with ExitStack() as endings:
        for observer in observers:
            observer.begin(plan)
            endings.callback(tell, observer)
        session = plan.vehicle.launch(plan.scenario)
        try:
            outcome = steps(plan, session, rows, observers)
        except LinkLost:
            outcome = Outcome.LINK_LOST
        except KeyboardInterrupt:
            outcome = Outcome.INTERRUPTED
        finally:
            session.close()
            wall_time = time.perf_counter() - began
    if not rows:
        raise LinkLost("the vehicle was lost before it said where it is")
    return Flight(plan, outcome, collect(rows), wall_time)


def steps(plan: Plan, session: Session, rows: list[Sample], observers: Sequence[Observer]) -> Outcome:
    """Fly step by step, adding to `rows`, until something ends the flight."""
    before = session.truth()
    memory = plan.tracker.start(plan.course, session.sense())
    memories = [avoider.start(plan.course, plan.scenario.world, session.sense()) for avoider in plan.avoiders]
    judge = Judge(plan, before.time)
    command: Command = Setpoint()
    clearance = plan.scenario.world.swept(before.position, before.position)
    while True:
        estimate, truth = session.sense(), session.truth()
        row = sampled(truth, estimate, command, memory, session.wind(), clearance)
        rows.append(row)
        for observer in observers:
            observer.sample(row)
        outcome = judge.verdict(before, truth, memory.progress, clearance, session.touched())
        if outcome is not None:
            return outcome
        period = plan.scenario.period
        command, memory = plan.tracker.step(memory, plan.course, estimate, period)
        for k, avoider in enumerate(plan.avoiders):
            command, memories[k] = avoider.step(memories[k], command, estimate, None, period)
        before = truth
        session.advance(command, period)
        clearance = plan.scenario.world.swept(before.position, session.truth().position)


def sampled(truth: State, estimate: State, command: Command, memory: Any, wind: Array, clearance: float) -> Sample:
    """Return the row of a record."""
    motion = command if isinstance(command, Setpoint) else OPEN
    thrust = math.nan if isinstance(command, Setpoint) else command.thrust
    return Sample(
        time=truth.time,
        position=truth.position,
        velocity=truth.velocity,
        attitude=truth.attitude,
        rate=truth.rate,
        rotor_speeds=truth.rotor_speeds,
        estimate=estimate.position,
        command_velocity=motion.velocity,
        command_acceleration=motion.acceleration,
        command_attitude=command.attitude if isinstance(command, AttitudeSetpoint) else NO_ATTITUDE,
        command_rate=command.rate if isinstance(command, RateSetpoint) else OPEN.velocity,
        command_thrust=thrust,
        aim=memory.aim,
        progress=memory.progress,
        wind=wind,
        clearance=clearance,
    )


@dataclass
class Judge:
    """Decides when a flight is over, and why."""

    plan: Plan
    start: float
    """s, time of the first sample"""
    best: float = field(default=0.0, init=False)
    """m, progress that counts"""
    since: float = field(init=False)
    """s, when it was reached"""
    owed: float = field(default=0.0, init=False)
    """m, what the plan has covered since"""
    last: float = field(init=False)
    """s, time of the sample before"""

    def __post_init__(self) -> None:
        self.since = self.last = self.start
        self.goal = self.plan.route(self.plan.route.length)

    def verdict(self, before: State, now: State, progress: float, clearance: float, touched: bool) -> Outcome | None:
        """Return the outcome once there is one; the worst comes first."""
        plan = self.plan
        if not lawful(now):
            return Outcome.LOST_CONTROL
        if clearance < plan.vehicle.radius or touched:
            return Outcome.COLLIDED
        if plan.vehicle.arrived(before, now, self.goal, plan.course.path.length - progress):
            return Outcome.ARRIVED
        bounds = plan.scenario.world.bounds
        if bounds is not None and not ((bounds[0] <= now.position) & (now.position <= bounds[1])).all():
            return Outcome.LEFT_BOUNDS
        if self.stuck(now.time, progress):
            return Outcome.STUCK
        if now.time - self.start >= plan.timeout - 1e-9:
            return Outcome.TIMED_OUT
        return None

    def stuck(self, time: float, progress: float) -> bool:
        """Return whether the vehicle has made next to none of the progress planned for as long as patience lasts."""
        self.owed += self.planned(time)
        if progress - self.best >= CRAWL * self.owed:
            self.best, self.since, self.owed = progress, time, 0.0
        return time - self.since > PATIENCE

    def planned(self, time: float) -> float:
        """Return how far (m) the plan goes from the sample before until this one; after its end, at its mean speed."""
        course, before, self.last = self.plan.course, self.last, time
        timetable = course.trajectory
        if timetable is None or time - self.start > timetable.duration:
            return course.path.length / course.speed.duration * (time - before)
        return float(np.linalg.norm(timetable(time - self.start) - timetable(before - self.start)))


def lawful(state: State) -> bool:
    """Return whether a state is finite and upright."""
    x, y = state.attitude[0], state.attitude[1]
    squares = sum(v @ v for v in (state.position, state.velocity, state.attitude, state.rate))
    return math.isfinite(squares) and bool(1 - 2 * (x * x + y * y) > UPSIDE_DOWN)


def warm_up(plan: Plan) -> None:
    """Compile what a flight needs, so that its first step takes no longer than the others."""
    session = plan.vehicle.launch(plan.scenario)
    memory = plan.tracker.start(plan.course, session.sense())
    command, _ = plan.tracker.step(memory, plan.course, session.sense(), plan.scenario.period)
    session.advance(command, plan.scenario.period)
    plan.scenario.world.swept(np.zeros(3), np.ones(3))
    session.close()
