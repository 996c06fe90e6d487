"""What the product promises, flown: the articles' settings, squares, wind, and random paths of every kind."""

import numpy as np
import pytest
from flights import Report, flown, plan_for
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.flight.loop import fly
from crosstrack.follow.carrot import Carrot
from crosstrack.types import Outcome
from crosstrack.vehicles.point import Point

SQUARE = [[0, 0, 10], [20, 0, 10], [20, 20, 10], [0, 20, 10], [0, 0, 10]]
AIRSIM = [[0, 0, 3], [5, 0, 3], [5, 8, 3], [8, 12, 3], [4, 9, 3]]
FOUR = [[0, 0, 0], [10, 15, 0], [15, 20, 0], [20, 5, 0]]


def article(points: object, start: tuple[float, float, float], lookahead: float) -> Report:
    law = Carrot(lookahead=lookahead, heading_gain=0.5)
    return flown(points, vehicle=Point(), start=start, yaw=0.5, speed=3.0, tracker=law)


def test_the_article_two_points() -> None:
    report = article([[0, 0, 0], [10, 15, 0]], (3.0, 3.0, 0.0), 1.0)
    assert report.arrived
    assert report.captured_rms <= 0.012


@pytest.mark.parametrize(("lookahead", "most"), [(1.0, 0.089), (0.1, 0.003)])
def test_the_article_four_points(lookahead: float, most: float) -> None:
    report = article(FOUR, (6.0, 3.0, 0.0), lookahead)
    assert report.arrived
    assert report.captured_rms <= most


@pytest.mark.parametrize("lookahead", [None, 0.8, 1.5])
@pytest.mark.parametrize(
    ("speed", "seconds", "rms", "worst"), [(1.0, 26.0, 0.05, 0.3), (5.0, 12.0, 0.10, 0.4), (10.0, 11.0, 0.3, 0.5)]
)
def test_the_airsim_path(speed: float, seconds: float, rms: float, worst: float, lookahead: float | None) -> None:
    law = Carrot(lookahead=lookahead) if lookahead else Carrot()
    report = flown(AIRSIM, speed=speed, tracker=law)
    assert report.arrived
    assert report.time[-1] <= seconds
    assert report.captured_rms <= rms
    assert report.error.max() <= worst


@pytest.mark.parametrize("law", [Carrot(), Carrot(lookahead=1.5)])
def test_the_square(law: Carrot) -> None:
    report = flown(SQUARE, tracker=law)
    assert report.arrived
    assert report.time[-1] <= 18.6
    assert report.speed.max() <= 5.3
    assert report.rms <= 0.15
    assert report.error.max() <= 0.4


@st.composite
def missions(draw: st.DrawFn) -> tuple[list[list[float]], float, float]:
    """Return a route of any kind, a speed and a tolerance.

    Routes lie in the plane or in space, open or closed, reversing, dense, with points twice. Long ones are flown fast.
    """
    spread = draw(st.sampled_from([0.5, 3.0, 12.0]))
    flat = draw(st.booleans())
    number = st.floats(-spread, spread).map(lambda x: round(x, 2))
    point = st.tuples(number, number, st.just(0.0) if flat else number)
    points = [list(p) for p in draw(st.lists(point, min_size=2, max_size=8, unique=True))]
    kind = draw(st.sampled_from(["plain", "closed", "reversing", "dense", "twice"]))
    if kind == "closed":
        points.append(points[0])
    elif kind == "reversing":
        points += points[-2::-1]
    elif kind == "dense":
        share = np.linspace(0, len(points) - 1, 40 * len(points))
        columns = [np.interp(share, np.arange(len(points)), [p[k] for p in points]) for k in range(3)]
        points = np.column_stack(columns).tolist()
    elif kind == "twice":
        points = [p for p in points for _ in range(2)]
    speed = draw(st.sampled_from([2.0, 6.0, 12.0] if spread < 12 else [6.0, 12.0]))
    tolerance = draw(st.sampled_from([0.05, 0.3, 1.0]))
    return [[x, y, z + 30.0] for x, y, z in points], speed, tolerance


def strayed(report: Report, tolerance: float) -> float:
    """Return the greatest cross-track error; where the tolerance blurs the legs, the distance to any of the route."""
    route = report.flight.plan.route
    if np.ptp(route.points, axis=0).max() > max(1.5, 5 * tolerance):
        return float(report.error.max())
    feet = [route(route.project(position, 0.0, route.length)) for position in report.position]
    return float(np.linalg.norm(report.position - feet, axis=1).max())


def check(mission: tuple[list[list[float]], float, float]) -> None:
    """Fly a random mission to its end."""
    points, speed, tolerance = mission
    report = Report(fly(plan_for(points, speed=speed, tolerance=tolerance)))
    assert report.outcome is Outcome.ARRIVED
    assert np.isfinite(report.position).all()
    assert report.end_error <= 0.2
    assert strayed(report, tolerance) <= max(tolerance, 0.4)
    assert report.time[-1] <= 1.5 * report.flight.plan.course.speed.duration + 3


test_random_paths_are_flown_to_their_end = settings(max_examples=50)(given(missions())(check))
test_many_random_paths_are_flown_to_their_end = pytest.mark.slow(settings(max_examples=4000)(given(missions())(check)))
