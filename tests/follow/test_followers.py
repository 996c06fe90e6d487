"""What every follower of a path must do, whatever its law: arrive, hold the route, and depend on nothing unseen."""

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for

from crosstrack import registry
from crosstrack.follow.course import plan_course
from crosstrack.path.polyline import Polyline
from crosstrack.types import Array, Setpoint, State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor

BASELINES = {"move_on_path", "published_carrot"}
"""laws of others as they are, kept to be compared with: they need not hold the route"""
LEARNED = {"policy"}
"""follows as its policy does, whose merit is measured on the routes it was made for, see tests/policy"""
LAWS = [
    name for name in registry.names("tracker") if registry.find("tracker", name).needs == () and name not in LEARNED
]
OURS = [name for name in LAWS if name not in BASELINES]

TURNS = np.linspace(0, 2 * np.pi, 60)
ROUTES: dict[str, Any] = {
    "straight": [[0, 0, 10], [30, 0, 10]],
    "corner": [[0, 0, 10], [12, 0, 10], [12, 12, 10]],
    "circle": np.column_stack([6 * np.sin(TURNS), 6 - 6 * np.cos(TURNS), 0 * TURNS + 10]),
    "eight": np.column_stack([9 * np.sin(TURNS), 9 * np.sin(TURNS) * np.cos(TURNS), 0 * TURNS + 10]),
    "reversal": [[0, 0, 10], [12, 0, 10], [0, 0, 10]],
    "climb": [[0, 0, 10], [8, 0, 13], [8, 8, 9], [0, 4, 12]],
}
WINDS = {"calm": Wind(), "wind": Wind((1.5, 1.5, 0.0), gusts="moderate")}


def law_of(name: str) -> Any:
    return registry.find("tracker", name)()


@pytest.mark.parametrize("wind", WINDS)
@pytest.mark.parametrize("route", ROUTES)
@pytest.mark.parametrize("name", OURS)
def test_a_quadrotor_flies_the_route_to_its_end(name: str, route: str, wind: str) -> None:
    report = flown(ROUTES[route], tracker=law_of(name), wind=WINDS[wind], speed=4.0)
    assert report.arrived
    assert report.end_error <= 0.2
    assert report.captured_rms <= (0.15 if wind == "calm" else 0.25)
    assert report.error.max() <= (0.6 if wind == "calm" else 0.8)
    assert report.time[-1] <= 1.15 * report.flight.plan.course.speed.duration + 1.0


@pytest.mark.parametrize("airframe", ["crazyflie", "racer"])
@pytest.mark.parametrize("name", OURS)
def test_other_airframes_fly_it_too(name: str, airframe: Any) -> None:
    report = flown(ROUTES["climb"], vehicle=Quadrotor(airframe), tracker=law_of(name), speed=3.0)
    assert report.arrived
    assert report.captured_rms <= 0.2


@pytest.mark.parametrize("wind", [(0.0, 0.0, 0.0), (1.5, 1.5, 0.0)])
@pytest.mark.parametrize("route", ["straight", "corner", "circle", "climb"])
@pytest.mark.parametrize("name", OURS)
def test_a_point_that_cannot_stop_flies_it_too(name: str, route: str, wind: tuple[float, float, float]) -> None:
    report = flown(ROUTES[route], vehicle=Point(), tracker=law_of(name), wind=Wind(wind), speed=4.0)
    assert report.arrived
    assert report.captured_rms <= 0.2


@pytest.mark.parametrize("speed", [0.5, 12.0])
@pytest.mark.parametrize("name", OURS)
def test_slow_and_fast_alike(name: str, speed: float) -> None:
    report = flown([[0, 0, 10], [6 * speed, 0, 10], [6 * speed, 3 * speed, 10]], tracker=law_of(name), speed=speed)
    assert report.arrived
    assert report.captured_rms <= 0.1


@pytest.mark.parametrize("start", [(-3.0, 4.0, 12.0), (5.0, -6.0, 8.0), (15.0, 0.5, 10.0)])
@pytest.mark.parametrize("name", OURS)
def test_a_start_off_the_route_leads_onto_it(name: str, start: tuple[float, float, float]) -> None:
    report = flown([[0, 0, 10], [40, 0, 10]], tracker=law_of(name), start=start)
    assert report.arrived
    assert np.isfinite(report.captured_rms)
    assert report.captured.max() <= 0.6
    assert report.error.max() <= report.error[0] + 0.3


@pytest.mark.parametrize("name", LAWS)
def test_the_same_seed_gives_the_same_flight(name: str) -> None:
    first, again = (flown(ROUTES["corner"], tracker=law_of(name), wind=WINDS["wind"]).position for _ in range(2))
    np.testing.assert_array_equal(first, again)


def state_at(position: Any, velocity: Any) -> State:
    return State(0.0, np.array(position, float), np.array(velocity, float), np.array([0.0, 0, 0, 1]), np.zeros(3))


def values(item: Any) -> list[Any]:
    """Return the fields of a command or a memory."""
    return [getattr(item, field.name) for field in fields(item)]


@pytest.mark.parametrize("name", LAWS)
def test_memory_is_passed_not_kept(name: str) -> None:
    """Stepping from a memory twice gives the same, whatever was stepped between."""
    law, plan = law_of(name), plan_for(ROUTES["climb"])
    here, there = state_at([2, 0.4, 10.5], [3, 1, 0]), state_at([4, -1, 12], [0, -2, 1])
    memory = law.start(plan.course, here)
    for _ in range(3):
        _, memory = law.step(memory, plan.course, here, 0.02)
    before = [np.copy(value) for value in values(memory)]
    first = law.step(memory, plan.course, here, 0.02)
    law.step(memory, plan.course, there, 0.02)
    again = law.step(memory, plan.course, here, 0.02)
    for one, other in zip(first, again, strict=True):
        for x, y in zip(values(one), values(other), strict=True):
            np.testing.assert_array_equal(x, y)
    for was, now in zip(before, values(memory), strict=True):
        np.testing.assert_array_equal(was, now)


ODD = {
    "at the start at rest": ([0, 0, 10], [0, 0, 0]),
    "on the end": ([0, 4, 12], [1, 0, 0]),
    "at rest far off": ([-80, 300, 10], [0, 0, 0]),
    "fast and far off": ([500, 0, 100], [12, 0, -5]),
    "backwards": ([4, 0, 11.5], [-4, 0, -1.5]),
    "straight up": ([4, 0, 11.5], [0, 0, 5]),
    "on the path, along it": ([4, 0, 11.5], [8 * 0.4, 0, 3 * 0.4]),
}


@pytest.mark.parametrize("vehicle", [Quadrotor(), Point(), Point(acceleration=8.0, lag=0.2)])
@pytest.mark.parametrize("case", ODD)
@pytest.mark.parametrize("name", LAWS)
def test_commands_are_finite_from_odd_states(name: str, case: str, vehicle: Any) -> None:
    law, plan = law_of(name), plan_for(ROUTES["climb"], vehicle=vehicle)
    here = state_at(*ODD[case])
    memory = law.start(plan.course, here)
    for _ in range(3):
        command, memory = law.step(memory, plan.course, here, 0.02)
        assert isinstance(command, Setpoint)
        given = [v for v in (command.position, command.velocity, command.acceleration) if not np.isnan(v).all()]
        assert given
        assert np.isfinite(given).all()
        assert np.isfinite(memory.aim).all()
        assert math.isfinite(memory.progress)


def moved(points: Array, turn: float, mirror: bool) -> Array:
    """Turn points (..., 3) about the vertical (rad), after mirroring them at the plane y = 0."""
    cosine, sine = math.cos(turn), math.sin(turn)
    matrix = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]) @ np.diag([1.0, -1.0 if mirror else 1.0, 1.0])
    turned: Array = np.asarray(points, float) @ matrix.T
    return turned


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("name", OURS)
def test_no_direction_is_special(name: str, mirror: bool) -> None:
    """Turn or mirror route and state, and the commands turn along."""
    rng, law, corners = np.random.default_rng(7), law_of(name), np.array(ROUTES["climb"], float)
    for vehicle in (Quadrotor(), Point()):
        plan = plan_for(corners, vehicle=vehicle)
        for turn in rng.uniform(-3, 3, 6):
            turned = plan_course(Polyline(moved(corners, turn, mirror)), 0.3, 5.0, plan.course.envelope)
            here = state_at(corners[1] + rng.normal(0, 1.5, 3), rng.normal(0, 3, 3))
            there = replace(
                here,
                position=moved(here.position, turn, mirror),
                velocity=moved(here.velocity, turn, mirror),
            )
            one, other = law.start(plan.course, here), law.start(turned, there)
            for _ in range(2):
                command, one = law.step(one, plan.course, here, 0.02)
                again, other = law.step(other, turned, there, 0.02)
                assert one.progress == pytest.approx(other.progress, abs=1e-6)
                for part in ("position", "velocity", "acceleration"):
                    expected = moved(getattr(command, part), turn, mirror)
                    np.testing.assert_allclose(getattr(again, part), expected, atol=1e-6)
