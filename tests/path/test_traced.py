"""Trajectories as paths: arc length against closed forms and quadrature, projection against brute force, stops."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from crosstrack.errors import InputError
from crosstrack.path.pace import course_of, pace_of
from crosstrack.path.traced import traced
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array, Envelope

ENVELOPE = Envelope(12.0, 6.0, 8.0, 4.0, 0.09)


@dataclass(frozen=True)
class Cycloid:
    """x = r (t - sin t), z = r (1 - cos t): arches of length 8 r with cusps between, s(t) = 4 r (1 - cos t/2)."""

    duration: float
    radius: float = 2.0

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        t = np.clip(np.asarray(t, float), 0.0, self.duration)
        phase = t + order * math.pi / 2
        x, z = -np.sin(phase), -np.cos(phase)
        if order == 0:
            x, z = x + t, z + 1
        return self.radius * np.stack([x + (1.0 if order == 1 else 0.0), np.zeros_like(t), z], axis=-1)


@dataclass(frozen=True)
class Helix:
    """Radius 3, pitch 2π h, at the phase t + sin(t) / 2: the curvature is 3 / (9 + h²)."""

    rise: float = 1.0
    duration: float = 9.0

    def __call__(self, t: float | Array, order: int = 0) -> Array:
        t = np.clip(np.asarray(t, float), 0.0, self.duration)
        phase, rate = t + 0.5 * np.sin(t), 1 + 0.5 * np.cos(t)
        if order == 0:
            return np.stack([3 * np.cos(phase), 3 * np.sin(phase), self.rise * phase], axis=-1)
        assert order == 1
        direction = np.stack([-3 * np.sin(phase), 3 * np.cos(phase), np.full_like(phase, self.rise)], axis=-1)
        return np.asarray(rate[..., None] * direction)


corner = st.tuples(*[st.floats(-20, 20).map(lambda x: round(x, 2))] * 3)
tours = st.lists(corner, min_size=2, max_size=7).filter(
    lambda points: all(math.dist(a, b) > 0.5 for a, b in pairwise(points))
)


def tour(points: object, pace: float = 3.0, derivative: int = 4) -> PiecewisePolynomial:
    corners = np.array(points, float)
    legs = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    return minimum(corners, np.concatenate([[0.0], np.cumsum(legs / pace)]), derivative)


def there_and_back() -> PiecewisePolynomial:
    """x = 10 t - 5 t² from t = 0 to 2, begun and ended at 10 m/s: it turns on the spot at x = 5."""
    return PiecewisePolynomial(np.array([2.0]), np.array([[[0.0, 0, 0], [10.0, 0, 0], [-5.0, 0, 0]]]))


@settings(max_examples=8)
@given(tours, st.sampled_from([2, 3, 4]))
def test_length_and_times_agree_with_quadrature(points: list[tuple[float, float, float]], derivative: int) -> None:
    curve = tour(points, derivative=derivative)
    path = traced(curve)
    legs = [
        quad(lambda t: float(np.linalg.norm(curve(t, 1))), a, b, epsabs=1e-9, epsrel=1e-9, limit=200)[0]
        for a, b in zip(curve.knots[:-1], curve.knots[1:], strict=True)
    ]
    assert path.length == pytest.approx(sum(legs), rel=1e-8)
    np.testing.assert_allclose(path.at(curve.knots[1:]), np.cumsum(legs), rtol=1e-8)
    times = np.linspace(0, curve.duration, 200)
    np.testing.assert_allclose(path(path.at(times)), curve(times), atol=1e-8 * path.length)


@settings(max_examples=25)
@given(tours, st.floats(0.02, 0.98))
def test_tangent_and_curvature_are_derivatives_by_arc_length(
    points: list[tuple[float, float, float]], share: float
) -> None:
    curve = tour(points)
    path = traced(curve)
    s = share * path.length
    bend = path(s, 2)
    h = 1e-5 * min(1.0, 1 / (1e-9 + float(np.linalg.norm(bend))))
    np.testing.assert_allclose(path(s, 1), (path(s + h) - path(s - h)) / (2 * h), atol=1e-4)
    assert np.linalg.norm(path(s, 1)) == pytest.approx(1, abs=1e-12)
    assert bend @ path(s, 1) == pytest.approx(0, abs=1e-9 * (1 + float(np.linalg.norm(bend))))
    change = (path(s + h, 1) - path(s - h, 1)) / (2 * h)
    np.testing.assert_allclose(bend, change, atol=1e-3 * (1 + float(np.linalg.norm(bend)) ** 2))


def test_helix_has_its_length_and_curvature() -> None:
    curve = Helix()
    path = traced(curve)
    speed = math.sqrt(10)

    def phase(t: Array) -> Array:
        return t + 0.5 * np.sin(t)

    assert path.length == pytest.approx(speed * float(phase(np.array(9.0))), rel=1e-10)
    s = np.linspace(0, path.length, 50)
    np.testing.assert_allclose(np.linalg.norm(path(s, 2), axis=1), 3 / 10, rtol=1e-6)
    np.testing.assert_allclose(speed * phase(path.time(s)), s, atol=1e-8)


def test_cycloid_has_cusps_at_its_stops() -> None:
    curve = Cycloid(4 * math.pi)
    path = traced(curve)
    assert path.length == pytest.approx(32, rel=1e-9)
    np.testing.assert_allclose(path.stops, [0, 16], atol=1e-8)
    t = np.linspace(0, 2 * math.pi, 40)
    np.testing.assert_allclose(path.at(t), 8 * (1 - np.cos(t / 2)), atol=1e-8)
    cusp = path.stops[1]
    np.testing.assert_allclose(path(cusp, 1), [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(path(cusp - 1e-6, 1), [0, 0, -1], atol=1e-3)
    np.testing.assert_allclose(path(cusp, 2), 0)
    np.testing.assert_allclose(path(path.length, 1), [0, 0, -1], atol=1e-6)


def test_a_turn_on_the_spot_is_one_point_with_two_directions() -> None:
    path = traced(there_and_back())
    assert path.length == pytest.approx(10, abs=1e-12)
    np.testing.assert_allclose(path.stops, [5.0], atol=1e-12)
    np.testing.assert_allclose(path(np.array([4.999, path.stops[0], 5.001]), 1)[:, 0], [1.0, -1.0, -1.0])
    np.testing.assert_allclose(path(np.array([4.0, 6.0]))[:, 0], 4.0, atol=1e-12)


def test_a_rest_takes_no_length() -> None:
    to, rest = minimum(np.array([[0.0, 0, 0], [4.0, 0, 0]]), np.array([0.0, 3.0]), 3), np.zeros((1, 6, 3))
    rest[0, 0] = [4.0, 0, 0]
    away = to.coefficients.copy()
    away[0] = np.roll(away[0], 1, axis=1)
    away[0, 0] += [4.0, 0, 0]
    curve = PiecewisePolynomial(np.array([3.0, 5.0, 3.0]), np.concatenate([to.coefficients, rest, away]))
    path = traced(curve)
    assert path.length == pytest.approx(8, abs=1e-9)
    np.testing.assert_allclose(path.stops, [0, 4], atol=1e-9)
    np.testing.assert_allclose(path(path.stops[1], 1), [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(path(3.9, 1), [1, 0, 0], atol=1e-9)
    assert path.time(3.9) < 3 < 8 < path.time(4.1)


@settings(max_examples=25)
@given(tours, st.integers(0, 10**6))
def test_projection_is_as_close_as_brute_force(points: list[tuple[float, float, float]], seed: int) -> None:
    path = traced(tour(points))
    rng = np.random.default_rng(seed)
    for _ in range(5):
        near, reach = rng.uniform(0, path.length), rng.uniform(0.05, path.length)
        window = np.linspace(near, min(near + reach, path.length), 4001)
        point = path(rng.choice(window)) + rng.normal(0, 2, 3)
        s = path.project(point, near, reach)
        assert near <= s <= min(near + reach, path.length)
        nearest = np.linalg.norm(path(window) - point, axis=1).min()
        assert np.linalg.norm(path(s) - point) <= nearest + 1e-9


def test_projection_goes_round_a_turn_on_the_spot_once() -> None:
    path = traced(there_and_back())
    turn = path.stops[0]
    assert path.project(np.array([4.0, 1, 0]), 3.5, 3.0) == pytest.approx(4)
    assert path.project(np.array([6.0, 0, 0]), 4.5, 3.0) == turn
    assert path.project(np.array([4.5, 0, 0]), 5.0, 3.0) == pytest.approx(5.5)


def test_a_millisecond_beside_a_thousand_seconds_far_from_the_origin() -> None:
    origin = np.array([500_000.0, 4_000_000.0, 100.0])
    points = origin + np.array([[0.0, 0, 0], [800, 0, 0], [800.001, 0, 0], [801, 5, 3]])
    curve = minimum(points, np.array([0.0, 1000.0, 1000.001, 1003.0]), 3)
    path = traced(curve)
    times = np.concatenate([np.linspace(0, 1000, 99), np.linspace(1000, 1003, 99)])
    np.testing.assert_allclose(path(path.at(times)), curve(times), atol=1e-6)
    at_knots = path.at(curve.knots[1:3])
    assert at_knots[1] - at_knots[0] == pytest.approx(0.001, rel=0.5)


@settings(max_examples=15)
@given(tours)
def test_the_pace_is_the_speed_of_the_trajectory_and_leads_away_from_stops(
    points: list[tuple[float, float, float]],
) -> None:
    curve = tour(points)
    course = course_of(curve, ENVELOPE)
    path, speed = traced(curve), course.speed
    assert speed.duration == curve.duration
    assert course.trajectory is curve
    s = np.linspace(0, path.length, 2001)[1:-1]
    apart = np.abs(s[:, None] - path.stops).min(axis=1) > 0.051
    own = np.linalg.norm(curve(path.time(s), 1), axis=1)
    np.testing.assert_allclose(speed(s)[apart], own[apart], rtol=1e-6, atol=1e-9)
    assert (speed(s) >= own * (1 - 1e-9)).all()
    assert speed(0.0) > 0
    assert speed(path.length) == pytest.approx(0, abs=1e-6)
    h = 1e-6
    gain = (speed(s[apart] + h) ** 2 - speed(s[apart] - h) ** 2) / (4 * h)
    np.testing.assert_allclose(speed(s[apart], 1), gain, atol=1e-3 * (1 + np.abs(gain).max()))


def test_the_pace_does_not_stop_where_the_path_turns_on_the_spot() -> None:
    path = traced(there_and_back())
    pace = pace_of(path, 2.0)
    rim = math.sqrt(2 * 10 * 0.05)  # v² = 2 a s
    np.testing.assert_allclose(pace(np.array([4.96, 4.999, 5.0, 5.001, 5.049])), rim, rtol=1e-6)
    np.testing.assert_allclose(pace(np.array([4.9, 5.1])), math.sqrt(2), rtol=1e-6)
    np.testing.assert_allclose(pace(np.array([4.0, 5.0, 6.0]), 1), [-10.0, 0.0, 10.0], atol=1e-6)


def test_what_is_no_path_is_told() -> None:
    flat = PiecewisePolynomial(np.array([1.0]), np.array([[[0.0, 0.0], [1.0, 1.0]]]))
    still = PiecewisePolynomial(np.array([1.0]), np.ones((1, 1, 3)))
    broken = PiecewisePolynomial(np.array([1.0, 1.0]), np.array([[[0.0] * 3, [1] * 3], [[1] * 3, [np.nan] * 3]]))
    for curve, words in ((flat, "2 dimensions"), (still, "stands still"), (broken, "not finite at t = 1")):
        with pytest.raises(InputError, match=words):
            traced(curve)
