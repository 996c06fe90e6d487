"""What the laws share: turns on the spot are turned, and no more is asked for than the vehicle has."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.bearing import reach_at
from crosstrack.follow.guidance import Foot, affordable, ahead
from crosstrack.types import Envelope

ENVELOPE = Envelope(12.0, 5.0, 8.0, 3.0, 0.1)
number = st.floats(-40, 40)


@given(number, number, number)
def test_no_more_is_asked_for_than_the_vehicle_has(x: float, y: float, z: float) -> None:
    push = np.array([x, y, z])
    given_back = affordable(push, ENVELOPE)
    assert abs(given_back[2]) <= ENVELOPE.acceleration_vertical + 1e-9
    assert np.linalg.norm(given_back) <= ENVELOPE.acceleration * (1 + 1e-9)
    assert given_back @ push >= 0
    if np.linalg.norm(push) <= ENVELOPE.acceleration and abs(z) <= ENVELOPE.acceleration_vertical:
        np.testing.assert_array_equal(given_back, push)


@pytest.mark.parametrize("tolerance", [0.05, 0.3])
@pytest.mark.parametrize("speed", [1.0, 2.0, 6.0])
@pytest.mark.parametrize("aside", [0.0, 0.05, 0.12])
@pytest.mark.parametrize("along", [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.7, 0.0, 0.7)])
def test_a_hairpin_is_no_place_to_hover(along: Any, aside: float, speed: float, tolerance: float) -> None:
    """Feed-forward that brakes before a turn on the spot must not hold off the velocity asked for, short of it."""
    there = np.array(along) + aside * np.array([along[2], 1.0, -along[0]])
    report = flown([[0, 0, 30.5], [0, 0, 30.5] + there, [0, 0, 30.0]], speed=speed, tolerance=tolerance)
    assert report.arrived
    assert report.time[-1] <= 1.2 * report.flight.plan.course.speed.duration + 0.5


def test_an_upward_turn_leaves_thrust_to_brake_with() -> None:
    """Three bends of metre size, up and down: were all of the thrust given to lift at one, it would fly past."""
    corners = np.array([[0.23, 0, 32], [0, 0, 30.03], [-2.53, -0.99, 30.49], [0, 0, 29.67], [1.41, 0, 32.01]])
    dense = np.concatenate([np.linspace(a, b, 40) for a, b in pairwise(corners)])
    report = flown(dense, speed=6.0, tolerance=0.05)
    assert report.arrived
    assert report.error.max() <= 0.4


@given(st.floats(0.2, 39.5), st.floats(0.0, 10.0))
def test_the_feed_forward_is_the_mean_acceleration_over_the_response_time(s: float, flown_speed: float) -> None:
    """On a straight leg: the change of the speed of the course along the way that the vehicle makes meanwhile."""
    course = plan_for([[0, 0, 10], [40, 0, 10]], speed=6.0).course
    push = ahead(course, s, np.array([1.0, 0, 0]), np.array([flown_speed, 0, 0]))
    response = course.envelope.response_time
    gain = max(0.0, float(course.speed(s, 1)))
    later = s + flown_speed * response + 0.5 * gain * response**2
    change = float(course.speed(min(later, 40.0)) - course.speed(s)) / response
    if change < 0 and flown_speed < 0.5 * float(course.speed(s)):
        change = 0.0
    assert push[0] == pytest.approx(change, abs=1e-9)
    assert not push[1:].any()


@given(st.floats(0.05, 3), st.floats(0, 6), st.floats(0.1, 15), st.floats(0, 0.5), st.floats(0, 50))
def test_the_reach_is_never_shorter_than_the_vehicle_can_turn(
    least: float, reaction: float, speed: float, response: float, error: float
) -> None:
    stopping = Envelope(12.0, 5.0, 8.0, 3.0, response)
    gliding = Envelope(12.0, 5.0, 8.0, 3.0, response, stops=False)
    foot = Foot(0.0, np.zeros(3), np.array([1.0, 0, 0]), speed, np.array([0, error, 0]), error, False)
    velocity = np.array([0.0, speed, 0])
    distance = reach_at(least, reaction, foot, velocity, stopping)
    assert distance >= max(least, reaction * response * speed) * (1 - 1e-12)
    # Towards the aim at this distance, an arc of the tightest radius still ends on the path.
    radius = speed**2 / 8.0
    assert radius * (1 - distance / math.hypot(distance, error)) <= error + 1e-9
    assert reach_at(least, reaction, foot, velocity, gliding) == pytest.approx(max(distance, radius))
