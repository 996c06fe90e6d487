"""The tutorial's corridor problems, against optima in 60 digits."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosstrack.trajectory.certified.extremes import largest_norm
from crosstrack.trajectory.certified.polyline_distance import largest_deviation
from crosstrack.trajectory.constrained.bounded import solve
from crosstrack.trajectory.constrained.corridor import subdivide
from crosstrack.trajectory.minimum_derivative import minimum

CASES = json.loads((Path(__file__).parents[1] / "data" / "minimum_jerk_optima.json").read_text())["cases"][1:]


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_knot_boxes_give_the_optimum(case: dict[str, Any]) -> None:
    points = np.array(case["knots"], float)
    found = solve(points, case["times"], corridor=case["corridor"], guide=case["guide"])
    assert found.cost == pytest.approx(case["objective"], rel=1e-8)
    assert found.curve.cost(3) == pytest.approx(case["cost"], rel=1e-5)
    assert found.active["corridor"] == sum(case["active"])
    assert 0 <= found.gap < 1e-7
    off = np.abs(found.curve(np.array(case["times"][1:-1])) - points[1:-1])
    assert off.max() <= case["corridor"]
    far = largest_deviation(found.curve, np.array(case["waypoints"], float)).value
    assert far == pytest.approx(case["max_deviation"], abs=1e-4)
    assert largest_norm(found.curve, 1).value == pytest.approx(case["max_speed"], rel=1e-4)
    assert largest_norm(found.curve, 2).value == pytest.approx(case["max_acceleration"], rel=1e-4)


def test_each_axis_has_as_many_active_boxes_as_the_optimum() -> None:
    case = CASES[0]
    for axis, active in enumerate(case["active"]):
        found = solve(np.array(case["knots"])[:, axis : axis + 1], case["times"], corridor=case["corridor"])
        assert found.active["corridor"] == active


def test_subdividing_the_waypoints_gives_the_tutorials_knots() -> None:
    case = CASES[0]
    waypoints = np.array(case["waypoints"], float)
    lengths = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))]
    points, times = subdivide(waypoints, lengths / lengths[-1] * case["times"][-1], 0.2)
    np.testing.assert_allclose(points, case["knots"], atol=1e-12)
    np.testing.assert_allclose(times, case["times"], atol=1e-12)


def test_a_corridor_of_no_use_leaves_the_curve_of_its_own_freedom() -> None:
    """Boxes so wide that none holds give the curve from end to end: its pieces are one polynomial."""
    points = np.array([[0.0, 0.0], [1.0, 3.0], [2.0, -1.0], [4.0, 0.0]])
    times = np.array([0.0, 0.5, 2.0, 3.0])
    curve, direct = minimum(points, times, corridor=50.0), minimum(points[[0, -1]], times[[0, -1]])
    sample = np.linspace(0, 3, 50)
    np.testing.assert_allclose(curve(sample), direct(sample), atol=1e-5)
