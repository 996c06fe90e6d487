"""How flights end, and who is told."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from flights import plan_for

from crosstrack.errors import LinkLost
from crosstrack.flight.effort import Effort
from crosstrack.flight.loop import fly
from crosstrack.flight.observer import Sample
from crosstrack.flight.plan import Plan
from crosstrack.follow.carrot import Carrot
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import Array, Command, Outcome, RateSetpoint, Setpoint, State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor, QuadrotorSession
from crosstrack.world.world import World

LEG = [[0, 0, 10], [40, 0, 10]]


class Wall(World):
    """A thin wall across x = 20."""

    def swept(self, start: Array, end: Array) -> float:
        if min(start[0], end[0]) <= 20 <= max(start[0], end[0]):
            return 0.0
        return float(min(abs(start[0] - 20), abs(end[0] - 20)))


class Watcher:
    """Keeps what it is shown; may interrupt."""

    def __init__(self, interrupt_at: float = math.inf) -> None:
        self.interrupt_at, self.rows = interrupt_at, list[Sample]()
        self.plan: Plan | None = None
        self.outcome: Outcome | None = None

    def begin(self, plan: Plan) -> None:
        self.plan = plan

    def sample(self, row: Sample) -> None:
        self.rows.append(row)
        if row.time >= self.interrupt_at:
            raise KeyboardInterrupt

    def end(self, outcome: Outcome, effort: Effort) -> None:
        self.outcome = outcome


def test_arrival() -> None:
    watcher = Watcher()
    flight = fly(plan_for(LEG), [watcher])
    assert flight.outcome is watcher.outcome is Outcome.ARRIVED
    assert watcher.plan is flight.plan
    np.testing.assert_array_equal(flight.record.time, [row.time for row in watcher.rows])
    np.testing.assert_allclose(np.diff(flight.record.time), 0.02)


def test_a_wall_is_hit_at_the_vehicles_radius() -> None:
    flight = fly(plan_for(LEG, world=Wall(), vehicle=Quadrotor(radius=0.5)))
    assert flight.outcome is Outcome.COLLIDED
    assert 19.3 < flight.record.position[-1, 0] < 19.7
    assert flight.record.clearance[-1] < 0.5


def test_the_ground_is_hit_by_a_dive() -> None:
    flight = fly(plan_for([[0, 0, 10], [5, 0, -10]]))
    assert flight.outcome is Outcome.COLLIDED
    assert flight.record.position[-1, 2] == pytest.approx(0.1, abs=0.2)


def test_time_runs_out() -> None:
    flight = fly(plan_for(LEG, timeout=3.0))
    assert flight.outcome is Outcome.TIMED_OUT
    assert flight.record.time[-1] == pytest.approx(3.0)


def test_a_headwind_holds_it_back() -> None:
    flight = fly(plan_for(LEG, vehicle=Point(), speed=3.0, wind=Wind((-3.0, 0, 0))))
    assert flight.outcome is Outcome.STUCK
    assert flight.record.time[-1] < 15


def test_a_slow_mission_is_not_stuck() -> None:
    flight = fly(plan_for([[0, 0, 2], [1.5, 0, 2]], speed=0.05))
    assert flight.outcome is Outcome.ARRIVED


def test_the_bounds_are_a_fence() -> None:
    bounds = np.array([[-5.0, -5, 0], [15, 5, 20]])
    flight = fly(plan_for(LEG, world=World(bounds=bounds)))
    assert flight.outcome is Outcome.LEFT_BOUNDS
    assert 15 < flight.record.position[-1, 0] < 15.2


@dataclass(frozen=True)
class Somersault(Carrot):
    """Rolls over after a second."""

    def step(self, memory: Any, course: Course, state: State, duration: float) -> tuple[Any, Any]:
        command, memory = super().step(memory, course, state, duration)
        return (RateSetpoint(np.array([6.0, 0, 0]), 9.8) if state.time > 1 else command), memory


def test_turning_over_is_losing_control() -> None:
    flight = fly(plan_for(LEG, tracker=Somersault()))
    assert flight.outcome is Outcome.LOST_CONTROL
    assert np.isnan(flight.record.command_velocity[-1]).all()


class Unplugged(QuadrotorSession):
    """Loses its link after a second."""

    closed = False

    def advance(self, command: Command, duration: float) -> None:
        if self.time > 1:
            raise LinkLost("no answer for 1 s")
        super().advance(command, duration)

    def close(self) -> None:
        type(self).closed = True


def test_a_lost_link_ends_the_flight_and_leaves_the_vehicle_safe() -> None:
    plan = plan_for(LEG)

    class Remote(Quadrotor):
        def launch(self, scenario: Any) -> QuadrotorSession:
            from crosstrack.sim.airframe import GENERIC  # noqa: PLC0415

            return Unplugged(GENERIC, scenario)

    watcher = Watcher()
    flight = fly(replace(plan, vehicle=Remote()), [watcher])
    assert flight.outcome is watcher.outcome is Outcome.LINK_LOST
    assert len(flight.record.time) == len(watcher.rows) > 50
    assert Unplugged.closed


def test_an_interrupt_ends_the_flight_not_the_program() -> None:
    watcher = Watcher(interrupt_at=2.0)
    flight = fly(plan_for(LEG), [watcher])
    assert flight.outcome is watcher.outcome is Outcome.INTERRUPTED
    assert flight.record.time[-1] == pytest.approx(2.0)


@dataclass(frozen=True)
class Broken(Carrot):
    """Has a bug."""

    def step(self, memory: Any, course: Course, state: State, duration: float) -> tuple[Any, Any]:
        raise ZeroDivisionError


def test_a_bug_is_not_hidden_but_observers_are_told_the_end() -> None:
    watcher = Watcher()
    with pytest.raises(ZeroDivisionError):
        fly(plan_for(LEG, tracker=Broken()), [watcher])
    assert watcher.outcome is Outcome.FAILED


@dataclass(frozen=True)
class Steps:
    """How often a detour was asked; it steps in from the second time on."""

    count: int = 0

    @property
    def intervening(self) -> bool:
        return self.count > 1


class Detour:
    """An avoider that always climbs."""

    guards = False

    def start(self, course: Course, around: Surroundings, state: State) -> Steps:
        return Steps()

    def step(
        self, memory: Steps, command: Any, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, Steps]:
        return Setpoint(velocity=command.velocity + np.array([0, 0, 0.5])), Steps(memory.count + 1)


def test_avoiders_change_the_command_in_their_order() -> None:
    plan = plan_for(LEG, timeout=6.0, tracker=Carrot(drift_gain=0.0))
    one, two = (fly(replace(plan, avoiders=chain)) for chain in ((Detour(),), (Detour(), Detour())))
    climbed = [flight.record.position[-1, 2] - 10 for flight in (one, two)]
    assert climbed[0] > 0.05
    assert climbed[1] == pytest.approx(2 * climbed[0], rel=0.1)
    np.testing.assert_array_equal(two.record.interventions, [0, 0, *[3] * (len(two.record.time) - 2)])


def test_the_same_plan_flies_the_same() -> None:
    plan = plan_for(LEG, wind=Wind((1.0, 2.0, 0.0), "moderate"))
    first, second = fly(plan).record, fly(plan).record
    np.testing.assert_array_equal(first.position, second.position)
    np.testing.assert_array_equal(first.wind, second.wind)
