"""NLGL: the closed forms of Park, Deyst and How, and where the path leaves the sphere."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import Steady
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.guidance import locate
from crosstrack.follow.lateral import begin, covered, turning
from crosstrack.follow.nlgl import Nlgl, exit_of
from crosstrack.follow.speed import profile
from crosstrack.path.pieces import Pieces
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope, State, Wind
from crosstrack.vehicles.point import Point

ABLE = Envelope(20.0, 20.0, 50.0, 50.0, 0.1)
LEG = Polyline([[0, 0, 10], [100, 0, 10]])


def course_of(path: Polyline, speed: float) -> Course:
    return Course(path, Steady(speed, path.length), ABLE, corners=path.points)


def state(position: Array, velocity: Array) -> State:
    return State(0.0, position, velocity, np.array([0.0, 0, 0, 1]), np.zeros(3))


def push_of(law: Nlgl, course: Course, here: State) -> Array:
    command, _ = law.step(begin(course, here), course, here, 0.02)
    return command.acceleration


@given(st.floats(2, 10), st.floats(0.5, 4), st.floats(0, 2 * math.pi), st.floats(-1e-4, 1e-4), st.floats(-1e-4, 1e-4))
def test_near_a_straight_path_it_is_an_oscillator(v: float, radius: float, roll: float, y: float, slope: float) -> None:
    """a = -2 (V/L)² y - 2 (V/L) ẏ: ω = √2 V / L, ζ = 1/√2, in every plane through the path."""
    normal = np.array([0.0, math.cos(roll), math.sin(roll)])
    velocity = v * np.array([math.cos(slope), 0, 0]) + v * math.sin(slope) * normal
    course = course_of(LEG, v)
    push = push_of(Nlgl(lookahead=radius, reaction=0.0), course, state(np.array([20.0, 0, 10]) + y * normal, velocity))
    omega = math.sqrt(2) * v / radius
    expected = -(omega**2) * y - math.sqrt(2) * omega * v * math.sin(slope)
    assert push @ normal == pytest.approx(expected, rel=1e-3, abs=1e-3 * omega**2 * 1e-4)


def ring(radius: float, upright: bool) -> Pieces:
    """Return a circle from (radius, 0, 0), level or in the plane y = 0."""
    side = [[0.0, 0, 1]] if upright else [[0.0, 1, 0]]
    rows = np.array([[radius, 0.0, 0]]), np.array(side), np.array([[-1.0, 0, 0]])
    return Pieces(*rows, np.array([1 / radius]), np.array([2 * math.pi * radius]))


@given(st.floats(2, 30), st.floats(0.2, 1.6), st.floats(1, 8), st.floats(0, 3), st.booleans())
def test_on_a_circle_it_asks_for_the_centripetal_acceleration(
    radius: float, share: float, v: float, angle: float, upright: bool
) -> None:
    path = ring(radius, upright)
    course = Course(path, Steady(v, path.length), Envelope(20.0, 20.0, 1e3, 1e3, 0.0))
    here = state(path(angle * radius), v * path(angle * radius, 1))
    law = Nlgl(lookahead=share * radius, reaction=0.0)
    memory = replace(begin(course, here), progress=angle * radius)
    command, _ = law.step(memory, course, here, 0.02)
    np.testing.assert_allclose(command.acceleration, v**2 * path(angle * radius, 2), atol=0.01 * v**2 / radius)


@given(st.floats(0.5, 6), st.floats(-0.4, 0.4), st.floats(1, 90))
def test_the_aim_is_where_a_straight_path_leaves_the_sphere(radius: float, share: float, x: float) -> None:
    offset = share * radius
    here = state(np.array([x, offset, 10]), np.array([3.0, 0, 0]))
    course = course_of(LEG, 3.0)
    memory = replace(begin(course, here), progress=x)
    aim = exit_of(LEG, locate(memory, course, here, 0.02), here.position, radius)
    # Beyond the end it lies on the leg's line.
    np.testing.assert_allclose(aim, [x + math.sqrt(radius**2 - offset**2), 0, 10], atol=1e-3 * radius)


def test_a_path_that_turns_back_is_aimed_at_beyond_the_turn() -> None:
    path = Polyline([[0, 0, 10], [10, 0, 10], [0, 0, 10]])
    here = state(np.array([9.5, 0, 10]), np.array([2.0, 0, 0]))
    course = course_of(path, 2.0)
    aim = exit_of(path, locate(begin(course, here), course, here, 10.0), here.position, 2.0)
    np.testing.assert_allclose(aim, [11.5, 0, 10], atol=1e-6)


@given(st.floats(-math.pi, math.pi), st.floats(0.5, 9))
def test_the_turn_grows_with_the_sine_and_is_held_beyond_a_right_angle(angle: float, v: float) -> None:
    part = turning(np.array([v, 0, 0]), np.array([math.cos(angle), math.sin(angle), 0]))
    size = 1.0 if abs(angle) > math.pi / 2 else abs(math.sin(angle))
    assert np.linalg.norm(part) == pytest.approx(size, abs=1e-6)
    assert part[0] == pytest.approx(0, abs=1e-9)
    if 1e-6 < abs(angle) < math.pi - 1e-6:
        assert part[1] * angle > 0


def test_straight_back_is_a_turn_to_the_left() -> None:
    np.testing.assert_allclose(turning(np.array([0.0, 3, 0]), np.array([0.0, -1, 0])), [-1, 0, 0])
    assert not turning(np.zeros(3), np.array([1.0, 0, 0])).any()


@given(st.floats(0.001, 27), st.floats(0.05, 1))
def test_the_way_of_a_profile_is_what_integrating_it_gives(s: float, duration: float) -> None:
    speed = profile(np.array([30.0]), np.array([5.0]), np.full(2, np.inf), np.array([4.0]))
    reached, steps = s, 300
    for _ in range(steps):
        middle = reached + 0.5 * duration / steps * float(speed(reached))
        reached += duration / steps * float(speed(middle))
    assert covered(speed, s, duration) == pytest.approx(reached - s, rel=0.05, abs=0.02)


def test_before_a_slow_corner_it_looks_less_far() -> None:
    corner = plan_for([[0, 0, 10], [20, 0, 10], [20, 20, 10]], speed=8.0).course
    ways = [covered(corner.speed, s, 0.5) for s in (10.0, 17.0, 19.0)]
    assert ways == sorted(ways, reverse=True)
    assert ways[-1] < 0.5 * ways[0]


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_a_steady_crosswind_leaves_no_offset(share: float) -> None:
    """An acceleration over ground needs no wind: a vehicle of constant airspeed turns until the path is held."""
    report = flown(
        [[0, 0, 0], [80, 0, 0]], vehicle=Point(), speed=3.0, wind=Wind((0.0, 3 * share, 0.0)), tracker=Nlgl()
    )
    assert report.arrived
    assert report.error[len(report.error) // 2 : -1].max() < 0.01


def test_a_start_far_off_meets_the_path_without_overshoot() -> None:
    report = flown([[0, 0, 30], [120, 0, 30]], speed=8.0, start=(5.0, 25.0, 30.0), tracker=Nlgl())
    assert report.arrived
    assert report.position[:, 1].min() > -0.5
