"""Planners: within every limit, through every waypoint, and as near to the legs as they promise."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.plan.minimum import DURATIONS, Minimum, MinimumJerk, MinimumSnap, motion_limits
from crosstrack.protocols import PlanningTask
from crosstrack.trajectory.flatness.yaw import Faced
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Envelope
from crosstrack.world.world import World

SQUARE = np.array([[0, 0, 10], [20, 0, 10], [20, 20, 12], [0, 20, 12], [0, 0, 10.0]])
ENVELOPE = Envelope(speed=12.0, speed_vertical=4.0, acceleration=7.0, acceleration_vertical=2.5, response_time=0.2)


def task(waypoints: Array = SQUARE, speed: float = 5.0, tolerance: float = 0.5, **more: Any) -> PlanningTask:
    envelope = Envelope(**({name: getattr(ENVELOPE, name) for name in Envelope.__slots__} | more))
    return PlanningTask(waypoints, speed, tolerance, envelope, World(), 0.2)


def sizes(curve: PiecewisePolynomial, asked: PlanningTask) -> Array:
    """Return how much of each limit a trajectory uses, at samples."""
    times = np.linspace(0, curve.duration, 4000)
    velocity, acceleration = curve(times, 1), curve(times, 2)
    envelope = asked.envelope
    return np.array(
        [
            np.linalg.norm(velocity, axis=1).max() / asked.speed,
            np.abs(velocity[:, 2]).max() / envelope.speed_vertical,
            np.linalg.norm(acceleration, axis=1).max() / envelope.acceleration,
            np.abs(acceleration[:, 2]).max() / envelope.acceleration_vertical,
        ]
    )


def from_legs(points: Array, corners: Array) -> Array:
    """Return the distance of points (n, 3) from the nearest of straight legs."""
    starts, legs = corners[:-1], np.diff(corners, axis=0)
    offset = points[:, None] - starts
    share = np.clip((offset * legs).sum(-1) / (legs**2).sum(-1), 0, 1)
    distances: Array = np.linalg.norm(offset - share[..., None] * legs, axis=-1).min(axis=1)
    return distances


@pytest.mark.parametrize("times", DURATIONS)
@pytest.mark.parametrize("planner", [MinimumSnap, MinimumJerk])
@pytest.mark.parametrize("guide", [None, "auto", 0, 5.0])
def test_the_tightest_limit_is_met_and_none_is_broken(planner: type[Minimum], times: Any, guide: Any) -> None:
    asked = task()
    curve = planner(guide=guide, times=times).curve(asked)
    used = sizes(curve, asked)
    assert used.max() <= 1
    assert used.max() > 0.999
    if guide is None:  # near the waypoints, not through them
        path = curve(np.linspace(0, curve.duration, 4000))
        assert from_legs(path, SQUARE).max() <= asked.tolerance
        np.testing.assert_allclose(path[[0, -1]], SQUARE[[0, -1]], atol=1e-6)
    else:
        np.testing.assert_allclose(curve(curve.knots), SQUARE, atol=1e-6)
    np.testing.assert_allclose(curve(np.array([0, curve.duration]), 1), 0, atol=1e-6)


@pytest.mark.parametrize(
    ("times", "more", "tight"),
    [
        ("trapezoid", {"speed_vertical": 0.2}, 1),
        ("trapezoid", {"acceleration": 0.5}, 2),
        ("constant", {"acceleration_vertical": 0.01}, 3),
    ],
)
def test_each_limit_is_the_tightest_where_it_is_low(times: Any, more: dict[str, Any], tight: int) -> None:
    asked = task(**more)
    used = sizes(MinimumJerk(guide=0, times=times).curve(asked), asked)
    assert int(np.argmax(used)) == tight
    assert used.max() == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("guide", [None, "auto"])
@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), count=st.integers(2, 6), radius=st.sampled_from([0.1, 0.5, 2.0]))
def test_the_corridor_is_kept(guide: Any, seed: int, count: int, radius: float) -> None:
    waypoints = np.random.default_rng(seed).uniform(0, 20, (count, 3))
    asked = task(waypoints, tolerance=0.7)
    planner = MinimumSnap(corridor=radius, guide=guide)
    curve = planner.curve(asked)
    path = curve(np.linspace(0, curve.duration, 3000))
    assert from_legs(path, waypoints).max() <= radius
    assert sizes(curve, asked).max() <= 1
    assert planner.allowed(asked.tolerance) == radius
    assert MinimumSnap(guide=guide).allowed(asked.tolerance) == asked.tolerance


def test_a_wider_corridor_is_never_slower_and_a_turn_on_the_spot_is_flown() -> None:
    route = np.array([[0, 0, 5], [10, 0, 5], [0, 0, 5], [0, 8, 5.0]])
    times = [MinimumJerk(corridor=radius).curve(task(route)).duration for radius in (0.05, 0.3, 1.0)]
    assert times == sorted(times, reverse=True)


def test_without_a_guide_the_shape_is_that_of_the_closed_form() -> None:
    asked = task()
    durations = DURATIONS["trapezoid"](SQUARE, motion_limits(asked), 4)
    shape = minimum(SQUARE, np.concatenate([[0], np.cumsum(durations)]), 4)
    curve = MinimumSnap(guide=0).curve(asked)
    share = np.linspace(0, 1, 101)
    np.testing.assert_allclose(curve(share * curve.duration), shape(share * shape.duration), atol=1e-9)
    assert MinimumSnap(guide=0).allowed(0.5) is None


def test_a_heavier_guide_is_nearer_to_the_legs() -> None:
    def mean(weight: float) -> float:
        curve = MinimumSnap(guide=weight).curve(task())
        return float(from_legs(curve(np.linspace(0, curve.duration, 2000)), SQUARE).mean())

    found = [mean(weight) for weight in (0, 0.1, 10, 1000)]
    assert found == sorted(found, reverse=True)
    assert found[-1] < 0.5 * found[0]


def test_fastest_is_faster_and_optimal_has_less_effort() -> None:
    asked = task(np.array([[0, 0, 0], [1, 0, 0], [15, 0, 3], [15, 9, 3], [14, 9, 3.0]]))
    ways: tuple[Any, ...] = ("trapezoid", "optimal", "fastest")
    made = {times: MinimumSnap(guide=0, times=times).curve(asked) for times in ways}
    assert made["fastest"].duration < made["trapezoid"].duration
    # for the same shape the effort goes with duration^-7
    effort = {times: curve.cost(4) * curve.duration**7 for times, curve in made.items()}
    assert effort["optimal"] < effort["trapezoid"]


def test_yaw_along_the_velocity() -> None:
    made = MinimumJerk(guide=0, yaw="velocity").plan(task())
    assert isinstance(made, Faced)
    velocity = made(3.0, 1)
    assert np.cos(made.yaw(3.0) - np.arctan2(velocity[1], velocity[0])) == pytest.approx(1)
    assert isinstance(MinimumJerk(guide=0).plan(task()), PiecewisePolynomial)
