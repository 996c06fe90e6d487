"""The published carrot: right where it says it is, and its limits as they are stated."""

import math

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.carrot import Carrot
from crosstrack.follow.published_carrot import PublishedCarrot
from crosstrack.types import State
from crosstrack.vehicles.point import Point

AIRSIM = [[0, 0, 3], [5, 0, 3], [5, 8, 3], [8, 12, 3], [4, 9, 3]]


def state(position: list[float], velocity: list[float]) -> State:
    return State(0.0, np.array(position), np.array(velocity), np.array([0.0, 0, 0, 1]), np.zeros(3))


@given(st.floats(-math.pi, math.pi), st.floats(0.3, 2), st.floats(1, 10), st.floats(-2, 2))
def test_a_leg_in_any_direction_is_flown_alike(theta: float, lookahead: float, along: float, beside: float) -> None:
    """The command by angles: towards the carrot, turned by K (ψ_d - ψ) dt at most 1 m/s² of it."""
    c, s = math.cos(theta), math.sin(theta)
    course = plan_for([[0, 0, 5], [40 * c, 40 * s, 5]], speed=3.0).course
    law = PublishedCarrot(lookahead=lookahead, heading_gain=0.8, speed=3.0)
    memory = law.start(course, state([0, 0, 5], [0, 0, 0]))
    position = [along * c - beside * s, along * s + beside * c, 5.0]
    command, memory = law.step(memory, course, state(position, [0, 0, 0]), 0.02)
    wanted = theta - math.atan2(beside, lookahead)
    np.testing.assert_allclose(memory.aim, [(along + lookahead) * c, (along + lookahead) * s, 5], atol=1e-9)
    turn = math.remainder(math.atan2(command.velocity[1], command.velocity[0]) - wanted, 2 * math.pi)
    asked = 0.8 * 3.0 * math.remainder(wanted, 2 * math.pi)  # it began with the course 0
    if abs(abs(math.remainder(wanted, 2 * math.pi)) - math.pi) > 1e-6:
        assert turn == pytest.approx(math.atan2(min(1.0, max(-1.0, asked)) * 0.02, 3.0), abs=1e-9)
    assert np.linalg.norm(command.velocity) == pytest.approx(3.0)


def test_a_leg_ends_when_the_carrot_passes_its_end_and_the_last_when_the_vehicle_does() -> None:
    law = PublishedCarrot(lookahead=1.0)
    legs = np.array([[0.0, 0, 3], [5, 0, 3], [5, 8, 3]])
    assert law.carrot(legs, 0, np.array([3.99, 0.2, 3]))[0] == 0
    assert law.carrot(legs, 0, np.array([4.01, 0.2, 3]))[0] == 1
    assert law.carrot(legs, 1, np.array([5, 7.99, 3]))[0] == 1
    assert law.carrot(legs, 1, np.array([5, 8.01, 3]))[0] == 2


def test_a_point_flies_it_as_the_article_shows() -> None:
    report = flown(
        [[0, 0, 0], [10, 15, 0]],
        vehicle=Point(),
        start=(3.0, 3.0, 0.0),
        speed=3.0,
        tracker=PublishedCarrot(lookahead=1.0, heading_gain=0.5),
    )
    assert report.arrived
    assert report.end_error < 0.25


def test_at_ten_metres_a_second_it_is_metres_beside_the_path() -> None:
    """And carrot chasing that knows of speed, corners and dynamics is not: the article's AirSim path."""
    published = flown(AIRSIM, speed=10.0, tracker=PublishedCarrot(speed=10.0, lookahead=1.5))
    ours = flown(AIRSIM, speed=10.0, tracker=Carrot(lookahead=1.5, heading_gain=0.8))
    assert published.error.max() > 3.0
    assert ours.error.max() < 0.5
    assert ours.time[-1] < 11


def test_at_one_metre_a_second_it_is_near_the_path() -> None:
    report = flown(AIRSIM, speed=1.0, tracker=PublishedCarrot(lookahead=0.8))
    assert report.arrived
    assert report.rms < 0.5


def test_it_knows_one_height_only() -> None:
    report = flown([[0, 0, 5], [20, 0, 8], [40, 0, 8]], speed=2.0, tracker=PublishedCarrot())
    flying = report.position[:, 0] < 38
    np.testing.assert_allclose(report.position[flying, 2], 5.0, atol=0.1)


def test_a_route_straight_up_has_no_legs_in_the_plane_and_its_end_is_held() -> None:
    report = flown([[0, 0, 5], [0, 0, 9]], speed=2.0, tracker=PublishedCarrot())
    assert report.arrived
