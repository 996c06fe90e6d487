"""Carrot chasing: the law on a straight leg, and every flaw of the published code shown not to return."""

import math
from dataclasses import replace

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.carrot import Carrot
from crosstrack.follow.guidance import turn
from crosstrack.types import Outcome, State, Wind
from crosstrack.vehicles.point import Point
from crosstrack.world.world import World

LEG = [[0, 0, 10], [40, 0, 10]]


def state(position: tuple[float, float, float], velocity: tuple[float, float, float]) -> State:
    return State(0.0, np.array(position), np.array(velocity), np.array([0.0, 0, 0, 1]), np.zeros(3))


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 3), st.floats(2, 30))
def test_on_a_straight_leg_it_flies_towards_the_carrot(y: float, z: float, lookahead: float, x: float) -> None:
    plan = plan_for(LEG, vehicle=Point(), start=(x, y, 10 + z))
    law, here = Carrot(lookahead=lookahead, heading_gain=0.0), state((x, y, 10 + z), (5.0, 0, 0))
    command, memory = law.step(law.start(plan.course, here), plan.course, here, 0.02)
    to_carrot = np.array([x + lookahead, 0, 10]) - here.position
    np.testing.assert_allclose(memory.aim, [x + lookahead, 0, 10], atol=1e-9)
    np.testing.assert_allclose(np.array(command.velocity) / 5, to_carrot / np.linalg.norm(to_carrot), atol=1e-9)


@pytest.mark.parametrize("angle", np.arange(0, 360, 15))
def test_every_direction_is_flown_alike(angle: float) -> None:
    """A leg due -y flew off to +y: the angle of the leg must not matter."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    report = flown([[0, 0, 0], [15 * c, 15 * s, 0]], vehicle=Point(), speed=3.0, start=(s, -c, 0.0))
    assert report.arrived
    assert report.captured.max() < 0.051
    assert report.time[-1] == pytest.approx(5.1, abs=0.2)


def test_the_turn_is_as_strong_to_either_side() -> None:
    """u was limited on one side only."""
    east = np.array([5.0, 0, 0])
    left, right = turn(east, np.array([0, 1.0, 0])), turn(east, np.array([0, -1.0, 0]))
    np.testing.assert_allclose(left, -right)
    np.testing.assert_allclose(left, [0, 1, 0], atol=1e-12)
    mirrored = [
        flown(LEG, vehicle=Point(), start=(0.0, y, 10.0), tracker=Carrot(heading_gain=5.0)).position for y in (2, -2)
    ]
    np.testing.assert_allclose(mirrored[0] * [1, -1, 1], mirrored[1], atol=1e-9)


@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_heading_errors_are_wrapped(flown_heading: float, asked_heading: float) -> None:
    """A turn from 170° to -170° is 20°, not -340°."""
    velocity = 3 * np.array([math.cos(flown_heading), math.sin(flown_heading), 0])
    asked = np.array([math.cos(asked_heading), math.sin(asked_heading), 0])
    error = math.remainder(asked_heading - flown_heading, 2 * math.pi)
    push = turn(velocity, asked)
    assert np.linalg.norm(push) == pytest.approx(abs(math.sin(error)), abs=1e-6)
    if 1e-3 < abs(error) < math.pi - 1e-3:
        assert np.cross(velocity, push)[2] * error > 0
    assert push @ velocity == pytest.approx(0, abs=1e-6)


def test_a_vehicle_at_rest_turns_nowhere() -> None:
    assert not turn(np.zeros(3), np.array([1.0, 0, 0])).any()


@pytest.mark.parametrize("height", [0.0, 0.3, -0.3])
def test_turning_back_is_no_climb(height: float) -> None:
    """The angle between opposite courses lies in any plane; a turn on the spot must not choose the vertical."""
    plan = plan_for([[0, 0, 10], [10, 0, 10], [0, 0, 10]], start=(10.5, 0.0, 10 + height))
    law, here = Carrot(), state((10.5, 0, 10 + height), (3.0, 0, 0))
    memory = replace(law.start(plan.course, here), progress=10.0)
    command, _ = law.step(memory, plan.course, here, 0.02)
    assert np.array(command.velocity)[0] < 0
    assert abs(np.array(command.acceleration)[2]) < 1.0


@pytest.mark.parametrize("yaw", [math.pi, math.pi - 1e-12, -3.0])
@pytest.mark.parametrize("options", [{"acceleration": 8.0}, {"lag": 0.3}])
def test_a_vehicle_that_starts_backwards_turns_round(yaw: float, options: dict[str, float]) -> None:
    report = flown([[0, 0, 10], [60, 0, 10]], vehicle=Point(**options), speed=3.0, yaw=yaw)
    assert report.arrived
    assert report.error.max() < 4


def test_a_speed_below_that_of_holding_a_position_is_kept_to_the_end() -> None:
    report = flown([[0, 0, 10], [1, 0, 10]], speed=0.05)
    assert report.arrived
    assert report.speed.max() < 0.07


@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 1, 0), (0, -1, 0), (0.6, 0.8, 0), (0, 0, 1), (0.48, 0.6, 0.64)])
def test_the_cross_track_gain_pulls_along_the_normal_of_the_path(direction: tuple[float, float, float]) -> None:
    """K2 acted on world y."""
    ahead = np.array(direction)
    across = np.cross(ahead, [0.3, -0.5, 0.81])
    across /= np.linalg.norm(across)
    plan = plan_for([10 * np.zeros(3), 40 * ahead], vehicle=Point(), start=tuple(10 * ahead + 0.5 * across))
    here = state(tuple(10 * ahead + 0.5 * across), tuple(5 * ahead))
    pushes = []
    for gain in (0.0, 2.0):
        law = Carrot(cross_track_gain=gain, heading_gain=0.0)
        command, _ = law.step(law.start(plan.course, here), plan.course, here, 0.02)
        pushes.append(np.array(command.acceleration))
    np.testing.assert_allclose(pushes[1] - pushes[0], -2.0 * 0.5 * across, atol=1e-9)


@given(st.lists(st.floats(-0.5, 0.5), min_size=1, max_size=20), st.floats(0.1, 2), st.floats(0.01, 0.5))
def test_the_heading_is_controlled_by_pid(angles: list[float], integral: float, derivative: float) -> None:
    """The turn asked for is K sine + K_I its sum over time + K_D its difference over time, over the course flown."""
    period, speed = 0.02, 3.0
    law = Carrot(heading_gain=0.7, heading_integral=integral, heading_derivative=derivative, drift_gain=0.0)
    plan = plan_for(LEG, vehicle=Point())
    memory = law.start(plan.course, state((10.0, 0, 10), (speed, 0, 0)))
    total, before = np.zeros(3), np.zeros(3)
    for angle in angles:
        flown_along = np.array([math.cos(angle), math.sin(angle), 0.0])
        here = state((10.0, 0, 10), (speed * flown_along[0], speed * flown_along[1], 0.0))
        command, memory = law.step(memory, plan.course, here, period)
        sine = math.sin(angle) * np.array([math.sin(angle), -math.cos(angle), 0.0])
        total = total + period * sine
        rate = 0.7 * sine + integral * total + derivative / period * (sine - before)
        before = sine
        np.testing.assert_allclose(command.acceleration, 5.0 * rate, atol=1e-9)


def test_the_integral_asks_for_half_of_the_acceleration_at_most() -> None:
    law = Carrot(heading_gain=0.0, heading_integral=5.0)
    plan = plan_for(LEG)
    here = state((20.0, 0, 10), (0.0, 5.0, 0))
    memory = law.start(plan.course, here)
    for _ in range(500):
        command, memory = law.step(memory, plan.course, here, 0.02)
    assert np.linalg.norm(command.acceleration) == pytest.approx(plan.course.envelope.acceleration / 2, rel=0.05)


def test_integral_and_derivative_do_not_unsettle_it() -> None:
    law = Carrot(heading_integral=0.5, heading_derivative=0.1)
    report = flown([[0, 0, 10], [20, 0, 10], [20, 20, 10]], tracker=law, wind=Wind((0.0, 2.5, 0.0)))
    assert report.arrived
    assert report.captured_rms <= 0.1


def test_duplicate_waypoints_are_one() -> None:
    twice = [[0, 0, 10], [0, 0, 10], [10, 0, 10], [10, 0, 10], [10, 10, 10], [10, 10, 10]]
    once = [[0, 0, 10], [10, 0, 10], [10, 10, 10]]
    np.testing.assert_array_equal(flown(twice).position, flown(once).position)


@pytest.mark.parametrize("speed", [1.0, 5.0, 10.0])
def test_it_ends_at_the_last_waypoint_and_at_rest(speed: float) -> None:
    """A run "finished" a lookahead short of the goal, or metres from it at 10 m/s."""
    report = flown([[0, 0, 10], [30, 0, 10], [30, 10, 12]], speed=speed, tracker=Carrot(lookahead=3.0))
    assert report.arrived
    assert report.end_error <= 0.2
    assert report.speed[-1] < 0.3


@pytest.mark.parametrize("sideways", [1e-3, -1e-3, 1e-2, 0.1])
def test_a_nearly_axis_parallel_last_leg_is_flown_to_its_end(sideways: float) -> None:
    """The test for the last leg compared x and y apart, and ended such a leg early by up to all of it."""
    for leg in ([20.0, sideways, 0.0], [sideways, -20.0, 0.0]):
        report = flown([[0, 0, 10], [5, 5, 10], [5 + leg[0], 5 + leg[1], 10]])
        assert report.arrived
        assert report.end_error <= 0.2


@pytest.mark.parametrize("kind", ["dense", "closed", "crossing"])
def test_dense_and_closed_paths_end(kind: str) -> None:
    t = np.linspace(0, 2 * np.pi, 1500 if kind == "dense" else 60)
    x, y = 8 * np.cos(t), 8 * np.sin(t) * (np.cos(t) if kind == "crossing" else 1)
    report = flown(np.column_stack([x, y, np.full_like(t, 10)]))
    assert report.arrived
    assert report.error.max() < 0.3
    assert report.progress[-1] > 0.99 * report.flight.plan.route.length - 0.2


@pytest.mark.parametrize("share", [0.25, 0.5, 0.9])
def test_a_crosswind_leaves_an_offset_without_drift_and_none_with_it(share: float) -> None:
    """Flying at the carrot through a crosswind w settles where the drift and the heading agree: δ w / √(V² - w²)."""
    wind, speed, lookahead = Wind((0.0, 3.0 * share, 0.0)), 3.0, 1.0
    without = Carrot(lookahead=lookahead, heading_gain=0.0, drift_gain=0.0)
    leg = [[0, 0, 0], [120, 0, 0]]
    plain = flown(leg, vehicle=Point(), speed=speed, wind=wind, tracker=without, rate=100)
    steady = plain.error[len(plain.error) // 2 : -200]
    assert np.median(steady) == pytest.approx(lookahead * share / math.sqrt(1 - share**2), rel=0.03)
    corrected = flown(leg, vehicle=Point(), speed=speed, wind=wind, tracker=Carrot(lookahead=lookahead))
    assert corrected.arrived
    assert corrected.error[len(corrected.error) // 2 :].max() < 0.05


def test_a_quadrotor_holds_a_leg_in_a_crosswind_of_half_its_speed() -> None:
    report = flown([[0, 0, 10], [100, 0, 10]], wind=Wind((0.0, 2.5, 0.0)))
    assert report.arrived
    assert report.error[len(report.error) // 2 :].max() < 0.05


@pytest.mark.parametrize("wind", [(-4.0, 0, 0), (-3.0, 0, 0), (-2.0, -3.0, 0), (0, 3.5, 0)])
def test_a_wind_above_the_speed_ends_clearly(wind: tuple[float, float, float]) -> None:
    report = flown([[0, 0, 0], [50, 0, 0]], vehicle=Point(), speed=3.0, wind=Wind(wind))
    assert report.outcome in (Outcome.STUCK, Outcome.LEFT_BOUNDS)
    assert report.time[-1] < 60


def test_a_wind_above_what_the_tilt_holds_ends_clearly() -> None:
    bounds = np.array([[-60.0, -60, 0], [90, 90, 60]])
    for world in (World(), World(bounds=bounds)):
        report = flown(LEG, wind=Wind((-60.0, 0.0, 0.0)), world=world)
        assert report.outcome in (Outcome.STUCK, Outcome.LEFT_BOUNDS)
