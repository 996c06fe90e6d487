"""One vehicle in flight: its session, its pilot, its judge, and the samples."""

import math
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numpy as np

from crosstrack.errors import LinkLost, Unreachable
from crosstrack.flight.effort import NO_EFFORT, effort
from crosstrack.flight.flight import Flight, flight_of
from crosstrack.flight.judge import Judge
from crosstrack.flight.observer import NOTHING, Observer, Sample
from crosstrack.flight.perception import hits
from crosstrack.flight.pilot import Pilot
from crosstrack.flight.plan import Plan
from crosstrack.protocols import Session
from crosstrack.types import Array, AttitudeSetpoint, Command, Others, Outcome, RateSetpoint, Setpoint, State

OPEN = Setpoint()
"""all left to the vehicle"""
NO_ATTITUDE = np.full(4, np.nan)


class Flying:
    """A vehicle from its launch to its end: `sample`, `decide` and `advance` make one period."""

    session: Session
    pilot: Pilot
    judge: Judge
    before: State
    """true, at the sample before"""
    now: State
    """true"""
    estimate: State

    def __init__(self, plan: Plan, observers: Sequence[Observer], index: int = 0, count: int = 1) -> None:
        self.plan, self.observers, self.index, self.count = plan, observers, index, count
        self.outcome: Outcome | None = None
        self.rows: list[Sample] = []
        self.command: Command = OPEN
        self.seen: Array = NOTHING
        self.clearance = math.inf
        self.began = time.perf_counter()
        self.decisions: list[float] = []
        self.planning = plan.planning_time
        self.effort = NO_EFFORT
        self.closing = ExitStack()

    @property
    def aloft(self) -> bool:
        """Whether the vehicle is there: it flies, or it holds its goal."""
        return self.outcome in {None, Outcome.ARRIVED}

    @contextmanager
    def ending(self) -> Iterator[None]:
        """End the flight of this vehicle where its link is lost or its goal turns out to be out of reach."""
        try:
            yield
        except LinkLost:
            self.outcome = self.outcome or Outcome.LINK_LOST
        except Unreachable:
            self.outcome = self.outcome or Outcome.UNREACHABLE

    def launch(self) -> None:
        """Put the vehicle into its scenario."""
        plan = self.plan
        try:
            self.session = plan.vehicle.launch(plan.scenario)
        except LinkLost:
            self.outcome = Outcome.LINK_LOST
            raise
        self.closing.callback(self.session.close)
        with self.ending():
            self.before = self.now = self.session.truth()
            self.estimate = self.session.sense()
            self.pilot = Pilot(plan, self.estimate, self.index, self.count)
            self.judge = Judge(plan, self.before)
            self.clearance = self.least_clearance()

    def sample(self, separation: float, gap: float) -> None:
        """Take down where the vehicle is, and judge it; no more once its flight has ended.

        Args:
            separation: m, least distance to the centre of another vehicle since the sample before
            gap: m, likewise between their spheres
        """
        if self.outcome is not None:
            return
        with self.ending():
            row = self.row(separation)
            self.rows.append(row)
            for observer in self.observers:
                observer.sample(row)
            clearance = min(self.clearance, self.plan.vehicle.radius + gap)
            self.outcome = self.judge.verdict(self.before, self.now, row.progress, clearance, self.session.touched())

    def decide(self, others: Sequence["Flying"]) -> None:
        """Make up the next command, knowing where the others that fly are."""
        with self.ending():
            began, scans = time.perf_counter(), self.session.scans()
            self.command = self.pilot.decide(self.estimate, scans, vehicles(others))
            planned, self.planning = self.planning, self.pilot.navigator.planning_time
            self.decisions.append(time.perf_counter() - began - (self.planning - planned))
            self.seen = hits(scans, self.estimate)
            if self.pilot.replanned is not None:
                self.judge.renew(self.pilot.navigator.course, self.now)

    def begin(self) -> None:
        """Give notice of the command."""
        with self.ending():
            self.session.begin(self.command, self.plan.scenario.period)

    def advance(self) -> None:
        """Fly the command for one period."""
        with self.ending():
            self.session.advance(self.command, self.plan.scenario.period)
            self.before, self.now, self.estimate = self.now, self.session.truth(), self.session.sense()
            self.clearance = self.least_clearance()

    def least_clearance(self) -> float:
        """Return the least distance (m) to an obstacle since the sample before, standing or moving."""
        scenario, start, end = self.plan.scenario, self.before, self.now
        least = scenario.world.swept(start.position, end.position)
        if scenario.traffic is None:
            return least
        return min(least, scenario.traffic.swept(start.position, end.position, start.time, end.time))

    def end(self) -> None:
        """Close the session, and tell the observers how it ended."""
        self.closing.close()
        self.effort = effort(time.perf_counter() - self.began, self.planning, self.decisions)
        for observer in self.observers:
            observer.end(self.outcome or Outcome.FAILED, self.effort)

    def flight(self) -> Flight:
        """Return what the flight leaves behind.

        Raises:
            LinkLost: there is nothing.
        """
        if not self.rows:
            raise LinkLost("the vehicle was lost before it said where it is")
        return flight_of(self.plan, self.outcome or Outcome.FAILED, self.rows, self.effort)

    def row(self, separation: float) -> Sample:
        """Return the row of a record."""
        command, truth, pilot = self.command, self.now, self.pilot
        motion = command if isinstance(command, Setpoint) else OPEN
        return Sample(
            time=truth.time,
            position=truth.position,
            velocity=truth.velocity,
            attitude=truth.attitude,
            rate=truth.rate,
            rotor_speeds=truth.rotor_speeds,
            estimate=self.estimate.position,
            command_velocity=motion.velocity,
            command_acceleration=motion.acceleration,
            command_attitude=command.attitude if isinstance(command, AttitudeSetpoint) else NO_ATTITUDE,
            command_rate=command.rate if isinstance(command, RateSetpoint) else OPEN.velocity,
            command_thrust=math.nan if isinstance(command, Setpoint) else command.thrust,
            aim=pilot.tracking.aim,
            progress=pilot.tracking.progress,
            wind=self.session.wind(),
            clearance=self.clearance,
            separation=separation,
            interventions=float(pilot.interventions),
            seen=self.seen,
            course=pilot.replanned,
        )


def vehicles(others: Sequence[Flying]) -> Others:
    """Return vehicles as they say they are."""
    estimates = [other.estimate for other in others]
    return Others(
        np.array([estimate.position for estimate in estimates]).reshape(-1, 3),
        np.array([estimate.velocity for estimate in estimates]).reshape(-1, 3),
        np.array([other.plan.vehicle.radius for other in others], dtype=float),
        np.ones(len(others), dtype=bool),
    )
