"""Corridors at the edges of what can be asked: what has no answer, touches, is tiny, huge, far or long."""

from typing import Any

import numpy as np
import pytest

from crosstrack.errors import Infeasible, InputError
from crosstrack.trajectory.constrained.bounded import solve
from crosstrack.trajectory.constrained.corridor import Boxes, Polytopes, Tube, subdivide
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum

CORNER = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 1.0]])
TIMES = np.array([0.0, 1.0, 2.0])


def boxes(*corners: list[float]) -> Boxes:
    """Return boxes of the lower corners of two and the upper ones."""
    return Boxes(np.array(corners[:2]), np.array(corners[2:]))


@pytest.mark.parametrize(
    ("arguments", "place", "message"),
    [
        ({"corridor": boxes([0.1, -1], [0, -1], [2, 1], [3, 2])}, "corridor of segment 0", "waypoint 0"),
        ({"corridor": boxes([-1, -1], [0, -1], [2, 1], [3, 0.9])}, "corridor of segment 1", "waypoint 2"),
        ({"start": [[3, 0]], "limits": MotionLimits(speed=2)}, "speed", "velocity given at waypoint 0 is 1 m/s"),
        ({"limits": MotionLimits(speed=1.2)}, "speed", "from waypoint 1 to 2 in 1 s takes 1.41421 m/s"),
        ({"limits": MotionLimits(acceleration=1)}, "acceleration", "even if this alone gave way"),
        ({"corridor": boxes([-1, -1], [1.1, -1], [1, 1], [3, 2])}, "corridor of segment", "at 1 s"),
    ],
)
def test_what_cannot_be_met_is_named(arguments: dict[str, Any], place: str, message: str) -> None:
    with pytest.raises(Infeasible) as caught:
        minimum(CORNER, TIMES, **arguments)
    assert any(place in problem.place and message in problem.message for problem in caught.value.problems)


def test_the_least_speed_named_is_a_true_bound() -> None:
    """A curve of one segment has no freedom: it needs 15/8 of its mean speed."""
    with pytest.raises(Infeasible, match=r"the nearest is 0\.005 m/s outside"):
        minimum([[0.0], [1.0]], [0.0, 1.0], limits=MotionLimits(speed=1.87))
    assert minimum([[0.0], [1.0]], [0.0, 1.0], limits=MotionLimits(speed=1.876)).cost(3) == pytest.approx(720)


def test_what_is_named_as_missing_is_not_enough_less() -> None:
    points, times = CORNER, TIMES
    with pytest.raises(Infeasible) as caught:
        minimum(points, times, limits=MotionLimits(acceleration=4.0))
    by = float(caught.value.problems[0].message.split("by ")[-1].split(" ")[0])
    with pytest.raises(Infeasible):
        minimum(points, times, limits=MotionLimits(acceleration=4.0 + 0.99 * by))


@pytest.mark.parametrize(
    ("arguments", "place"),
    [
        ({"corridor": -1.0}, "corridor"),
        ({"corridor": float("nan")}, "corridor"),
        ({"corridor": Tube([1.0, 2.0, 3.0])}, "corridor.radius"),
        ({"corridor": Tube(0.0)}, "corridor.radius"),
        ({"corridor": Boxes([[0, 0]], [[1, 1]])}, "corridor.low"),
        ({"corridor": Boxes([[0, 0], [2, 2]], [[1, 1], [1, 3]])}, "corridor.low[1, 0]"),
        ({"corridor": Polytopes([([[1, 0]], [1])])}, "corridor.faces"),
        ({"corridor": Polytopes([([[1, 0]], [1]), ([[0, 0]], [1])])}, "corridor.faces[1].A"),
        ({"corridor": Polytopes([([[1, 0]], [1, 2]), ([[1, 0]], [1])])}, "corridor.faces[0]"),
        ({"limits": MotionLimits(speed=-1)}, "limits.speed"),
        ({"limits": MotionLimits(speed_vertical=1)}, "limits.speed_vertical"),
        ({"corridor": 0.1, "periodic": True}, "periodic"),
    ],
)
def test_bad_input_is_named(arguments: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as caught:
        minimum(CORNER, TIMES, **arguments)
    assert place in [problem.place for problem in caught.value.problems]


def test_boxes_that_only_touch_are_crossed_where_they_touch() -> None:
    found = solve(CORNER, TIMES, corridor=boxes([-0.2, -0.2], [1.0, -0.2], [1.0, 0.2], [2.2, 1.2]))
    assert found.curve(1.0)[0] == pytest.approx(1.0, abs=1e-9)
    assert found.margins["corridor"] >= -1e-9


def test_a_start_on_a_face_is_left_inwards() -> None:
    curve = minimum(CORNER, TIMES, corridor=boxes([0.0, 0.0], [0.5, -0.2], [1.2, 0.2], [2.2, 1.2]))
    assert (curve(np.linspace(0, 1, 500)) >= -1e-7).all()


def test_open_sides_of_boxes_do_not_hold() -> None:
    low, high = np.full((2, 2), -np.inf), np.full((2, 2), np.inf)
    free = minimum(CORNER[[0, -1]], TIMES[[0, -1]])
    curve = minimum(CORNER, TIMES, corridor=Boxes(low, high))
    np.testing.assert_allclose(curve(np.linspace(0, 2, 9)), free(np.linspace(0, 2, 9)), atol=1e-6)
    low[:, 1] = -0.05
    assert minimum(CORNER, TIMES, corridor=Boxes(low, high))(np.linspace(0, 2, 99))[:, 1].min() >= -0.05


def test_steady_flight_along_a_line_costs_nothing() -> None:
    points, times = np.linspace([0, 0, 0], [10, 0, 0], 11), np.arange(11.0)
    ends = [[1.0, 0, 0]]
    found = solve(points, times, start=ends, end=ends, corridor=Tube(0.1), limits=MotionLimits(speed=1.5))
    assert found.cost < 1e-15
    assert found.margins["speed"] == pytest.approx(0.5)


def test_a_tube_lets_a_vehicle_turn_back_before_the_end() -> None:
    """Out and back along one line both chords hold the start, and staying there is free; unless the end is passed."""
    points = np.array([[0.0, 0], [1, 0], [0, 0]])
    assert solve(points, TIMES, corridor=Tube(0.1)).cost < 1e-9
    assert solve(points, TIMES, corridor=Tube(0.1), through=[False, True, False]).curve(1.0)[0] == pytest.approx(1)


def test_repeated_waypoints_are_balls_of_the_tube() -> None:
    points = np.array([[0.0, 0], [1, 0], [1, 0], [2, 1]])
    curve = minimum(points, [0, 1, 2, 3], corridor=Tube(0.1))
    assert np.linalg.norm(curve(np.linspace(1, 2, 500)) - points[1], axis=1).max() <= 0.1 + 1e-9


@pytest.mark.parametrize("radius", [1e-3, 0.3, 1e6])
@pytest.mark.parametrize("s", [2, 3, 4])
def test_tubes_from_narrow_to_wide(radius: float, s: int) -> None:
    points, times = subdivide([[0, 0, 0], [2, 1, 0], [3, -1, 1], [5, 0, 0]], [0, 4, 8, 12], 0.6)
    found = solve(points, times, s, corridor=Tube(radius))
    assert found.margins["corridor"] >= 0.0
    assert found.gap <= 1e-3


def test_far_coordinates_cost_no_accuracy() -> None:
    points, times = subdivide([[0, 0, 0], [2, 1, 0], [3, -1, 1]], [0, 2, 4], 0.5)
    near, far = (solve(points + offset, times, corridor=Tube(0.2)) for offset in (0.0, [4.5e5, 5.4e6, 300.0]))
    assert far.cost == pytest.approx(near.cost, rel=1e-6)


def test_a_short_segment_beside_long_ones() -> None:
    points, times = np.array([[0, 0], [0.001, 0], [300, 5], [300, 6]]), [0, 0.001, 1000, 1001]
    found = solve(points, times, corridor=Tube(0.5))
    assert found.margins["corridor"] >= 0.0
    assert found.gap <= 1e-3


def test_a_thousand_segments() -> None:
    rng = np.random.default_rng(4)
    route = np.cumsum(rng.normal(size=(100, 3)) * [1, 1, 0.3], axis=0)
    points, times = subdivide(route, 2.0 * np.arange(100), 0.15)
    assert len(points) > 800
    found = solve(points, times, corridor=Tube(0.2), limits=MotionLimits(speed=4.0))
    assert found.margins["corridor"] >= 0.0
    assert found.margins["speed"] >= 0.0
    assert found.gap <= 1e-3
