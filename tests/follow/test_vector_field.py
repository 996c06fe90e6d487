"""Vector field: the angle of the paper, the field's own rate, and the way a point without dynamics takes."""

import math
from typing import Any

import numpy as np
import pytest
from flights import flown, plan_for
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.vector_field import VectorField, field
from crosstrack.types import Array, State, Wind
from crosstrack.vehicles.point import Point

EAST = np.array([1.0, 0, 0])
offsets = st.tuples(st.floats(-8, 8), st.floats(-8, 8)).map(lambda yz: np.array([0.0, *yz]))
angles = st.floats(0.2, math.pi / 2)


def at(position: Any, velocity: Any) -> State:
    return State(0.0, np.array(position, float), np.array(velocity, float), np.array([0.0, 0, 0, 1]), np.zeros(3))


@given(st.floats(-20, 20), st.floats(0.1, 5), angles)
def test_in_the_plane_it_is_the_angle_of_the_paper(y: float, distance: float, entry: float) -> None:
    """With the vehicle at y left of a path due east, χ = -χ∞ 2/π atan(k y)."""
    asked, _ = field(np.array([0, -y, 0]), EAST, np.zeros(3), entry, distance)
    k = math.pi / (2 * entry * distance)
    assert math.atan2(asked[1], asked[0]) == pytest.approx(-entry * 2 / math.pi * math.atan(k * y), abs=1e-9)


@given(offsets, angles, st.floats(0.2, 5), st.tuples(*[st.floats(-10, 10)] * 3).map(np.array))
def test_the_field_turns_as_its_difference_says(offset: Array, entry: float, distance: float, velocity: Array) -> None:
    """How it turns along the way flown, in space, is the derivative of the direction."""
    if np.linalg.norm(offset) < 0.05:
        return
    _, swing = field(offset, EAST, velocity, entry, distance)
    step = 1e-6
    later, _ = field(offset - step * velocity, EAST, velocity, entry, distance)
    before, _ = field(offset + step * velocity, EAST, velocity, entry, distance)
    np.testing.assert_allclose(swing, (later - before) / (2 * step), rtol=1e-4, atol=1e-3)


@given(st.floats(0.3, 5), angles)
def test_on_the_path_the_rate_is_the_limit_of_that_beside_it(distance: float, entry: float) -> None:
    velocity = np.array([5.0, 1.0, -2.0])
    _, on = field(np.zeros(3), EAST, velocity, entry, distance)
    _, beside = field(np.array([0, 1e-7, 0]), EAST, velocity, entry, distance)
    np.testing.assert_allclose(on, beside, atol=1e-5)


@pytest.mark.parametrize("entry", [math.pi / 2, 0.8])
@pytest.mark.parametrize("distance", [1.0, 3.0])
def test_a_point_approaches_as_the_field_says(entry: float, distance: float) -> None:
    """Without dynamics, e' = -V sin(χ∞ 2/π atan(k e)): its solution by small steps is what is flown."""
    law = VectorField(entry_angle=entry, boundary=distance)
    leg = [[0, 0, 10], [60, 0, 10]]
    report = flown(leg, vehicle=Point(), speed=4.0, start=(0.0, 3.0, 14.0), tracker=law, rate=200)
    k, error, expected = math.pi / (2 * entry * distance), 5.0, [5.0]
    for _ in range(len(report.time) - 1):
        for _ in range(10):
            error -= 4.0 * math.sin(entry * 2 / math.pi * math.atan(k * error)) / 2000
        expected.append(error)
    across = np.linalg.norm(report.position[:, 1:] - [0, 10], axis=1)
    np.testing.assert_allclose(across[:2000], expected[:2000], atol=0.03)


def test_close_to_the_path_the_error_falls_by_e_over_the_boundary() -> None:
    plan = plan_for([[0, 0, 10], [60, 0, 10]], vehicle=Point())
    law = VectorField(boundary=2.0, heading_gain=0.0)
    here = at([20, 0.001, 10], [5, 0, 0])
    command, _ = law.step(law.start(plan.course, here), plan.course, here, 0.02)
    assert command.velocity[1] / command.velocity[0] == pytest.approx(-0.001 / 2.0, rel=1e-3)


@pytest.mark.parametrize("radius", [5.0, 15.0])
def test_an_orbit_is_held(radius: float) -> None:
    t = np.linspace(0, 2 * np.pi, 240)
    points = np.column_stack([radius * np.sin(t), radius - radius * np.cos(t), 0 * t + 10])
    report = flown(points, tracker=VectorField(), speed=4.0)
    assert report.arrived
    assert report.captured.max() <= 0.06


def test_a_crosswind_leaves_no_offset() -> None:
    report = flown([[0, 0, 0], [120, 0, 0]], vehicle=Point(), speed=3.0, wind=Wind((0, 1.5, 0)), tracker=VectorField())
    assert report.arrived
    assert report.error[len(report.error) // 2 :].max() < 0.05
