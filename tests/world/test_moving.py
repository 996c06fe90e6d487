"""Obstacles that move: where they are, the balls around them, and how near a moving point comes."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from crosstrack.mission.load import loads
from crosstrack.protocols import Traffic
from crosstrack.types import Array
from crosstrack.world.build import WorldSpec
from crosstrack.world.moving import Moving, MovingObstacles, moved
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World

ELL = ((0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0))
SOLIDS: list[Shape] = [
    Sphere((1, 2, 3), 0.7),
    Cylinder((1, 2), 0.4, (0, 5)),
    Box((0, 0, 0), (0.2, 4, 3)),
    Box((0, 0, 0), (1, 1, 1)),
    Prism(ELL, (1, 2)),
]
coordinate = st.floats(-8, 8)
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)


def surface(shape: Shape, count: int = 4000) -> Array:
    """Return points on and inside a solid."""
    points = np.random.default_rng(0).uniform(-1, 6, size=(300_000, 3))
    return points[World((shape,)).distance(points) <= 0][:count]


@pytest.mark.parametrize("shape", SOLIDS)
@given(shift=point, points=st.lists(point, min_size=1, max_size=8).map(np.array))
@settings(max_examples=20)
def test_a_moved_solid_is_at_the_distance_that_the_solid_is_from_points_moved_back(
    shape: Shape, shift: Array, points: Array
) -> None:
    here = World((moved(shape, shift),)).distance(points)
    np.testing.assert_allclose(here, World((shape,)).distance(points - shift), atol=1e-12)


@pytest.mark.parametrize(
    ("turns", "time", "expected", "sense"),
    [(None, 7.0, 14.0, 1), (3.0, 2.0, 4.0, 1), (3.0, 4.0, 4.0, -1), (3.0, 6.5, 1.0, 1), (3.0, 11.0, 2.0, -1)],
)
def test_it_keeps_on_or_goes_back_and_forth(turns: float | None, time: float, expected: float, sense: int) -> None:
    traffic: Traffic = MovingObstacles((Moving(Sphere((1, 0, 5), 0.5), (2, 0, 0), turns),))
    others = traffic.others(time)
    np.testing.assert_allclose(others.position, [[1 + expected, 0, 5]])
    np.testing.assert_array_equal(others.velocity, [[sense * 2.0, 0, 0]])
    np.testing.assert_array_equal(others.radius, [0.5])
    assert not others.avoids.any()
    assert traffic.at(time).distance(np.array([1 + expected, 0, 7.0])) == pytest.approx(1.5)


@pytest.mark.parametrize("shape", SOLIDS)
def test_the_balls_hold_the_solid_and_not_much_more(shape: Shape) -> None:
    others = MovingObstacles((Moving(shape, (1, -1, 0)),)).others(2.0)
    assert len(others.radius) <= 64
    inside = surface(shape) + [2, -2, 0]
    assert len(inside) > 300
    gaps = np.linalg.norm(inside[:, None] - others.position, axis=2) - others.radius
    assert (gaps.min(axis=1) <= 1e-9).all()
    reach = World((moved(shape, np.array([2.0, -2, 0])),)).distance(others.position) + others.radius
    assert reach.max() <= (1e-12 if isinstance(shape, Sphere) else 2 * others.radius.max())
    thinnest = {Cylinder: 0.4, Sphere: 0.7}.get(type(shape), 0.5)
    assert others.radius.max() <= 2 * thinnest


def test_the_velocity_of_the_balls_is_the_derivative_of_their_place() -> None:
    traffic = MovingObstacles(tuple(Moving(shape, (1, 2, -0.5), 1.7) for shape in SOLIDS))
    for time in (0.3, 1.9, 4.0):
        before, now, after = (traffic.others(time + step) for step in (-1e-4, 0, 1e-4))
        np.testing.assert_allclose((after.position - before.position) / 2e-4, now.velocity, atol=1e-9)


@given(start=point, end=point, velocity=point, center=point, before=st.floats(0, 5), lasts=st.floats(0.01, 4))
def test_the_least_distance_of_two_straight_flights_is_that_of_the_closed_form(
    start: Array, end: Array, velocity: Array, center: Array, before: float, lasts: float
) -> None:
    traffic = MovingObstacles((Moving(Sphere(tuple(center.tolist()), 0.5), tuple(velocity.tolist())),))
    apart = start - center - before * velocity
    closing = (end - start) / lasts - velocity
    square = float(closing @ closing)
    nearest = min(max(-float(apart @ closing) / square, 0.0), lasts) if square > 0 else 0.0
    expected = float(np.linalg.norm(apart + nearest * closing)) - 0.5
    assert traffic.swept(start, end, before, before + lasts) == pytest.approx(expected, abs=3e-6)


@given(start=point, end=point, velocity=point, before=st.floats(0, 5), lasts=st.floats(0, 6))
@settings(max_examples=30)
def test_no_instant_of_a_flight_among_turning_obstacles_is_nearer_than_the_least(
    start: Array, end: Array, velocity: Array, before: float, lasts: float
) -> None:
    traffic = MovingObstacles(tuple(Moving(shape, tuple(velocity.tolist()), 0.9) for shape in SOLIDS))
    found = traffic.swept(start, end, before, before + lasts)
    parts = np.linspace(0, 1, 60)
    sampled = [float(traffic.at(before + s * lasts).distance(start + s * (end - start))) for s in parts]
    assert found <= min(sampled) + 2e-3
    speeds = np.linalg.norm(end - start) + float(np.linalg.norm(velocity)) * lasts
    assert found >= min(sampled) - speeds / 59 - 1e-3


def test_a_bullet_through_a_thin_wall_is_seen() -> None:
    wall = Moving(Box((-0.005, -5, 0), (0.005, 5, 5)), (30, 0, 0))
    traffic = MovingObstacles((wall, Moving(Sphere((50, 50, 5), 1), (0, 0, 0))))
    stands = np.array([1.5, 0.0, 2.0])
    assert traffic.swept(stands, stands, 0.0, 0.1) < 0
    assert traffic.swept(stands, stands, 0.1, 0.2) == pytest.approx(3 - 0.005 - 1.5)
    ahead = stands + [3.0, 0, 0]
    assert traffic.swept(stands, ahead, 0.0, 0.1) == pytest.approx(1.495)


MOVING: list[dict[str, Any]] = [
    {"shape": {"sphere": {"center": [5, 1, 5], "radius": 0.5}}, "velocity": [0, 1, 0]},
    {"shape": {"cylinder": {"center": [9, 1], "radius": 0.3, "z": [1, 4]}}, "velocity": [0, -1, 0], "turns": 4},
]


def test_the_vehicle_is_told_of_what_is_mapped() -> None:
    spec = TypeAdapter(WorldSpec).validate_python(
        {
            "ground": 0.5,
            "shapes": [{"sphere": {"center": [0, 0, 5], "radius": 1}}],
            "unmapped": [{"sphere": {"center": [9, 0, 5], "radius": 2}}],
            "moving": MOVING,
        }
    )
    truth = spec.build({})
    told = spec.told(truth)
    at = np.array([9.0, 0, 5])
    assert truth.distance(at) == -2
    assert told.distance(at) == 8
    assert told.ground == 0.5
    traffic = spec.traffic()
    assert traffic is not None
    assert traffic.at(0.0).ground == 0.5
    assert traffic.at(1.0).distance(np.array([5.0, 2.0, 5.0])) == -0.5
    plain = replace(spec, unmapped=(), moving=())
    assert plain.told(truth) is truth
    assert plain.traffic() is None


def test_every_error_of_a_moving_obstacle_has_its_place() -> None:
    broken = [
        {"shape": {}, "velocity": [1, 0, 0]},
        {"shape": MOVING[0]["shape"], "velocity": [1, math.inf, 0], "turns": 0},
        {"velocity": [1, 0]},
    ]
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(WorldSpec).validate_python({"moving": broken})
    places = {".".join(str(part) for part in error["loc"]) for error in caught.value.errors()}
    assert {
        "moving.0.shape",
        "moving.1.velocity.1",
        "moving.1.turns",
        "moving.2.shape",
        "moving.2.velocity.2",
    } <= places


def test_a_mission_in_north_east_down_moves_the_same() -> None:
    flown = "start: {position: [0, 0, %s]}\nroute: [[3, 0, %s]]\nworld: "
    enu = loads(
        flown % (5, 5) + "{unmapped: [{sphere: {center: [1, 9, 6], radius: 1}}], moving: [{shape: {box: "
        "{min: [2, 6, 4], max: [3, 8, 5]}}, velocity: [0.5, -1, 0.25], turns: 3}]}"
    )
    ned = loads(
        "frame: ned\n" + flown % (-5, -5) + "{unmapped: [{sphere: {center: [9, 1, -6], radius: 1}}], moving: [{shape: "
        "{box: {min: [6, 2, -5], max: [8, 3, -4]}}, velocity: [-1, 0.5, -0.25], turns: 3}]}"
    )
    assert ned.enu.world.unmapped == enu.world.unmapped
    assert ned.enu.world.moving == enu.world.moving
