import numpy as np
import pytest

from crosstrack.errors import InputError
from crosstrack.trajectory.conditions import conditions
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.times.fastest import fastest
from crosstrack.trajectory.times.optimal import least_effort
from crosstrack.trajectory.times.tightness import stretched_time
from crosstrack.trajectory.times.timing import rescaled, trapezoid
from crosstrack.types import Array

LIMITS = MotionLimits(speed=4.0, speed_vertical=1.5, acceleration=5.0, acceleration_vertical=3.0, jerk=30.0)


def route(seed: int, segments: int = 6) -> Array:
    return np.random.default_rng(seed).uniform(0, 20, (segments + 1, 3))


def times(durations: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(durations)])


@pytest.mark.parametrize("s", [3, 4])
def test_slopes_of_the_stretched_time(s: int) -> None:
    points = route(0, 5)
    y = np.log(np.random.default_rng(1).uniform(0.7, 4.0, 5))
    asked = conditions(points, times(np.exp(y)), s, None, None, None, False, None)

    def at(y: Array) -> float:
        return stretched_time(asked, np.exp(y), LIMITS.bounds(3), 20.0)[0]

    _, slopes = stretched_time(asked, np.exp(y), LIMITS.bounds(3), 20.0)
    numeric = [(at(y + e) - at(y - e)) / 2e-5 for e in np.eye(5) * 1e-5]
    np.testing.assert_allclose(slopes, numeric, atol=1e-7)
    assert slopes.sum() == pytest.approx(0.0, abs=1e-12)  # the pace alone changes nothing


@pytest.mark.parametrize(("s", "seed"), [(3, 1), (4, 2), (4, 3)])
def test_limits_hold_and_one_is_met(s: int, seed: int) -> None:
    found = fastest(route(seed), LIMITS, s)
    curve = found.curve
    assert found.converged
    t = np.linspace(0, curve.duration, 50_001)
    most = [
        np.linalg.norm(curve(t, order)[:, list(axes)], axis=1).max() / top for _, order, axes, top in LIMITS.bounds(3)
    ]
    assert max(most) <= 1.0
    assert max(most) > 1.0 - 1e-5
    np.testing.assert_allclose(curve(curve.knots), route(seed), atol=1e-9)


@pytest.mark.parametrize(("s", "seed"), [(3, 4), (4, 5)])
def test_no_durations_nearby_are_faster(s: int, seed: int) -> None:
    points = route(seed)
    found = fastest(points, LIMITS, s).curve
    stop_and_go = trapezoid(points, LIMITS)
    assert found.duration < rescaled(minimum(points, times(stop_and_go), s), LIMITS).duration
    assert found.duration < rescaled(least_effort(points, 30.0, s).curve, LIMITS).duration
    rng = np.random.default_rng(seed)
    for size in (0.003, 0.01, 0.03, 0.1, 0.3):
        for _ in range(8):
            durations = found.durations * np.exp(rng.normal(0, size, len(found.durations)))
            other = rescaled(minimum(points, times(durations), s), LIMITS)
            assert other.duration > found.duration * (1 - 2e-3)


def test_one_leg_has_its_closed_form() -> None:
    leg = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]
    # rest to rest with least jerk: 15/8 l/T at most, and 10/√3 l/T²
    assert fastest(leg, MotionLimits(speed=2.0, acceleration=9.0)).curve.duration == pytest.approx(75 / 16, rel=1e-7)
    slow = fastest(leg, MotionLimits(speed=20.0, acceleration=0.5)).curve.duration
    assert slow == pytest.approx(np.sqrt(100 / np.sqrt(3)), rel=1e-7)


def test_a_plane_route_under_a_speed_limit_alone() -> None:
    found = fastest([[0, 0], [10, 0], [10, 10], [0, 10]], MotionLimits(speed=3.0))
    assert found.converged
    assert 10.0 < found.curve.duration < 20.0


def test_a_hundred_segments() -> None:
    points = route(6, 100)
    found = fastest(points, MotionLimits(speed=4.0, acceleration=5.0), 4)
    assert found.converged
    even = rescaled(least_effort(points, 500.0, 4).curve, MotionLimits(speed=4.0, acceleration=5.0))
    assert found.curve.duration < 0.9 * even.duration


def test_what_is_wrong_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        fastest([[0, 0], [0, 0], [1, 1]], MotionLimits(speed=0.0, acceleration_vertical=1.0))
    places = [problem.place for problem in caught.value.problems]
    assert places == ["waypoints[1]", "limits.speed", "limits.acceleration_vertical"]
    with pytest.raises(InputError, match="at least one limit"):
        fastest([[0, 0], [1, 1]], MotionLimits())
    with pytest.raises(InputError, match="derivative: must be 2, 3 or 4"):
        fastest([[0, 0], [1, 1]], MotionLimits(speed=1.0), 7)
