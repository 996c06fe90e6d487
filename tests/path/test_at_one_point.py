"""Evaluated at one arc length, curves and speeds are what they are as a row of many."""

import numpy as np
import pytest

from crosstrack.follow.course import plan_course
from crosstrack.path.pace import course_of
from crosstrack.path.polyline import Polyline
from crosstrack.protocols import Course
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Envelope

ENVELOPE = Envelope(12.0, 6.0, 8.0, 4.0, 0.09)
POINTS = np.array([[0.0, 0, 10], [12, 3, 11], [18, 14, 12], [5, 20, 10], [5, 20, 14]])


def stopping() -> PiecewisePolynomial:
    """Return a trajectory that rests in the middle."""
    there = minimum(POINTS[:3], np.array([0.0, 3.0, 6.0]), 4)
    on = minimum(POINTS[2:], np.array([0.0, 3.0, 6.0]), 4)
    return PiecewisePolynomial(
        np.concatenate([there.durations, on.durations]), np.concatenate([there.coefficients, on.coefficients])
    )


@pytest.mark.parametrize(
    "course",
    [plan_course(Polyline(POINTS), 0.3, 8.0, ENVELOPE), course_of(stopping(), ENVELOPE)],
    ids=["route", "plan"],
)
def test_one_is_as_many(course: Course) -> None:
    length = course.path.length
    stops = getattr(course.path, "stops", np.empty(0))
    near = [stop + step for stop in stops for step in (-0.06, -0.03, 0.0, 0.03, 0.06)]
    s = np.concatenate([np.linspace(-0.1 * length, 1.1 * length, 397), near, [0.0, length]])
    for order in (0, 1, 2):
        alone = np.array([course.path(float(value), order) for value in s])
        np.testing.assert_array_equal(alone, course.path(s, order))
    for order in (0, 1):
        one = np.array([float(course.speed(float(value), order)) for value in s])
        np.testing.assert_allclose(one, course.speed(s, order), rtol=1e-12, atol=1e-9)
