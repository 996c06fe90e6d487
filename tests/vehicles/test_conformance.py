"""What every registered vehicle must do."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from flights import plan_for
from served import serving

from crosstrack import registry
from crosstrack.flight.plan import Plan
from crosstrack.protocols import Session
from crosstrack.types import Limits, Noise, Setpoint, Wind

VEHICLES: list[tuple[str, dict[str, Any]]] = [
    *((name, {}) for name in registry.names("vehicle")),
    *(("quadrotor", {"airframe": airframe}) for airframe in ("crazyflie", "racer")),
    ("point", {"lag": 0.3}),
    ("point", {"acceleration": 4.0}),
    ("airsim", {"stepping": "running"}),
]
CLOSE = {"airsim": 0.05}
"""m and rad, of the start asked for, where a vehicle must fly to it"""
STEP = {"airsim": 0.011}
"""s, by which a clock that goes in steps of its own may pass what is asked"""
ports: list[int] = []
aloft: list[Session] = []


@pytest.fixture(autouse=True, scope="module")
def airsim() -> Iterator[None]:
    """Something for the vehicle behind a protocol to be in."""
    with serving() as server:
        ports.append(server.port)
        yield
        ports.clear()


@pytest.fixture(autouse=True)
def closing() -> Iterator[None]:
    """Close what a test has launched."""
    yield
    while aloft:
        aloft.pop().close()


def launch(plan: Plan) -> Session:
    aloft.append(plan.vehicle.launch(plan.scenario))
    return aloft[-1]


def planned(kind: str, options: dict[str, Any], **scenario: Any) -> Plan:
    if kind == "airsim":
        options = {"after": "hover", "port": ports[0], **options}
    return plan_for([[0, 0, 10], [50, 0, 10]], vehicle=registry.find("vehicle", kind)(**options), **scenario)


def fly(plan: Plan, command: Setpoint, seconds: float) -> np.ndarray:
    session = launch(plan)
    rows = []
    for _ in range(round(seconds / 0.02)):
        session.advance(command, 0.02)
        truth = session.truth()
        rows.append(np.concatenate([[truth.time], truth.position, truth.velocity, truth.attitude]))
    aloft.remove(session)
    session.close()
    return np.array(rows)


@pytest.mark.parametrize(("kind", "options"), VEHICLES)
class TestVehicle:
    def test_it_starts_where_it_is_put(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options, yaw=0.7)
        session = launch(plan)
        close = CLOSE.get(kind, 1e-12)
        np.testing.assert_allclose(session.truth().position, [0, 0, 10], atol=close)
        np.testing.assert_allclose(session.truth().attitude, [0, 0, np.sin(0.35), np.cos(0.35)], atol=close)
        assert session.truth().time == 0
        assert not session.touched()

    def test_its_clock_advances_by_what_is_flown(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options)
        session = launch(plan)
        for duration in (0.02, 0.1, 0.0137):
            before = session.truth().time
            session.advance(Setpoint(velocity=np.array([1.0, 0, 0])), duration)
            assert session.truth().time - before == pytest.approx(duration, abs=STEP.get(kind, 1e-12))

    def test_it_flies_the_velocity_asked_for(self, kind: str, options: dict[str, Any]) -> None:
        rows = fly(planned(kind, options, speed=3.0), Setpoint(velocity=np.array([0.0, 3.0, 0.0])), 6.0)
        np.testing.assert_allclose(rows[-1, 4:7], [0, 3, 0], atol=0.1)
        np.testing.assert_allclose(np.linalg.norm(rows[:, 7:], axis=1), 1, atol=1e-9)

    def test_velocity_is_the_derivative_of_position(self, kind: str, options: dict[str, Any]) -> None:
        rows = fly(planned(kind, options, speed=3.0), Setpoint(velocity=np.array([1.0, 2.0, 2.0])), 3.0)
        between = np.diff(rows[:, 1:4], axis=0) / np.diff(rows[:, :1], axis=0)
        mean = (rows[1:, 4:7] + rows[:-1, 4:7]) / 2
        np.testing.assert_allclose(between, mean, atol=0.02)

    def test_the_same_seed_flies_the_same_and_another_does_not(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options, wind=Wind((1.0, 0, 0), "moderate"), noise=Noise(0.05, 0.1, 0.03))
        other = replace(plan, scenario=replace(plan.scenario, seed=2))
        command = Setpoint(velocity=np.array([2.0, 1.0, 0.0]))
        first, second, third = (fly(p, command, 2.0) for p in (plan, plan, other))
        np.testing.assert_array_equal(first, second)
        assert np.abs(first - third).max() > 1e-3

    def test_without_noise_it_senses_the_truth(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options)
        session = launch(plan)
        session.advance(Setpoint(velocity=np.array([1.0, 0, 0])), 0.5)
        assert session.sense() is session.truth()

    def test_noise_is_as_strong_as_asked(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options, noise=Noise(position=0.3, velocity=0.2))
        session = launch(plan)
        errors = []
        for _ in range(1500):
            session.advance(Setpoint(velocity=np.array([1.0, 0, 0])), 0.02)
            sensed, truth = session.sense(), session.truth()
            errors.append([sensed.position - truth.position, sensed.velocity - truth.velocity])
        np.testing.assert_allclose(np.std(errors, axis=0), [[0.3] * 3, [0.2] * 3], rtol=0.1)

    def test_its_envelope_can_be_flown(self, kind: str, options: dict[str, Any]) -> None:
        plan = planned(kind, options, limits=Limits(speed=7.0, acceleration=3.0))
        envelope = plan.vehicle.envelope(plan.scenario)
        assert 0 < envelope.speed <= 7
        assert envelope.acceleration > 0
        assert envelope.response_time >= 0
        if envelope.stops:
            assert envelope.acceleration <= 3
            session = launch(plan)
            push = envelope.acceleration
            session.advance(Setpoint(acceleration=np.array([push, 0, np.nan])), 4 * envelope.response_time)
            before = session.truth()
            session.advance(Setpoint(acceleration=np.array([push, 0, np.nan])), 0.2)
            gained = (session.truth().velocity - before.velocity) / 0.2
            assert gained[0] == pytest.approx(push, rel=0.1)
