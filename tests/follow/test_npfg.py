"""NPFG: the bearing and the wind triangle against the papers' formulas, computed another way."""

import math

import numpy as np
import pytest
from conftest import Steady
from flights import flown
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.npfg import Npfg, air_course, bearing, error_bound
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.types import Array, Envelope, State, Wind
from crosstrack.vehicles.point import Point

ABLE = Envelope(20.0, 20.0, 50.0, 50.0, 0.01)


@given(st.floats(-9, 9), st.floats(-math.pi, math.pi), st.floats(0.3, 6))
def test_the_bearing_in_the_plane_is_that_of_the_paper(error: float, heading: float, bound: float) -> None:
    """Computed with angles: the course differs from the path's by π/2 (1 - (1 - ē)²), towards the path."""
    tangent = np.array([math.cos(heading), math.sin(heading), 0])
    left = np.array([-tangent[1], tangent[0], 0])
    toward, proximity = bearing(-error * left, tangent, bound)
    normalised = min(1.0, abs(error) / bound)
    course = heading - math.copysign(math.pi / 2 * (1 - (1 - normalised) ** 2), error)
    # An error of 1e-9 m is none: that turns the bearing by π 1e-9 / 0.3 at most.
    np.testing.assert_allclose(toward, [math.cos(course), math.sin(course), 0], atol=2e-8)
    assert proximity == pytest.approx(math.cos(course - heading) ** 2, abs=1e-9)


@given(st.floats(2, 9), st.floats(0.8, 5), st.floats(0.4, 1.0), st.floats(-1e-4, 1e-4), st.floats(-1e-4, 1e-4))
def test_near_a_straight_path_the_error_has_period_and_damping(
    v: float, period: float, damping: float, y: float, slope: float
) -> None:
    path = Polyline([[0, 0, 10], [100, 0, 10]])
    course = Course(path, Steady(v, path.length), ABLE, corners=path.points)
    velocity = v * np.array([math.cos(slope), math.sin(slope), 0])
    here = State(0.0, np.array([20.0, y, 10]), velocity, np.array([0.0, 0, 0, 1]), np.zeros(3))
    law = Npfg(period=period, damping=damping, reaction=0.0)
    command, _ = law.step(law.start(course, here), course, here, 0.02)
    omega = 2 * math.pi / period
    expected = -(omega**2) * y - 2 * damping * omega * v * slope
    assert command.acceleration[1] == pytest.approx(expected, rel=0.01, abs=0.01 * omega**2 * 1e-4)


def test_the_error_bound_grows_with_the_ground_speed_and_does_not_vanish() -> None:
    assert error_bound(8.0, 0.5) == pytest.approx(4.0)
    assert error_bound(0.0, 0.5) == pytest.approx(0.25)
    assert error_bound(1.0 - 1e-9, 0.5) == pytest.approx(error_bound(1.0 + 1e-9, 0.5))


vectors = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-2, 2)).map(np.array)


@given(vectors, st.floats(-math.pi, math.pi), st.floats(1, 8))
def test_the_wind_triangle_closes_where_it_can(wind: Array, course: float, airspeed: float) -> None:
    toward = np.array([math.cos(course), math.sin(course), 0])
    air = airspeed * air_course(toward, wind, airspeed)
    crosswind = wind - (wind @ toward) * toward
    assert np.linalg.norm(air) == pytest.approx(airspeed)
    drift = air + wind - ((air + wind) @ toward) * toward
    # What cannot be held is the least drift there is.
    least = max(0.0, float(np.linalg.norm(crosswind)) - airspeed)
    assert np.linalg.norm(drift) == pytest.approx(least, abs=1e-6)


@pytest.mark.parametrize(
    ("wind", "ground"), [((-4.5, 0.0, 0.0), (-1.5, 0.0)), ((-2.0, 4.0, 0.0), (0.0, 4 - math.sqrt(5)))]
)
def test_in_excess_wind_it_flies_backwards_along_its_bearing(
    wind: tuple[float, float, float], ground: tuple[float, float]
) -> None:
    """Against a headwind along the path; in a crosswind that carries it off, on the straight way to the path."""
    route = [[-300, 0, 0], [300, 0, 0]]
    report = flown(route, vehicle=Point(), speed=3.0, wind=Wind(wind), tracker=Npfg(), start=(0.0, 0.0, 0.0))
    half = len(report.time) // 2
    velocity = (report.position[-1] - report.position[half]) / (report.time[-1] - report.time[half])
    np.testing.assert_allclose(velocity[:2], ground, atol=0.1)
