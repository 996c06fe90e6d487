"""The report of a flight along a trajectory: planned beside flown, by the clock."""

import numpy as np
import pytest

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import scene
from crosstrack.mission import loads
from crosstrack.mission.flying import fly
from crosstrack.show.figures import plan_view, space
from crosstrack.show.panels import Panel, panels
from crosstrack.show.report import view
from crosstrack.show.style import PALETTE

HOP = "start: {position: [0, 0, 5]}\nroute: [[6, 0, 5], [6, 5, 6]]\nspeed: 3\n"


@pytest.fixture(scope="module")
def planned() -> Flight:
    return fly(loads(HOP + "planner: {kind: minimum_snap, guide: 0}"))


def panel(flight: Flight, title: str) -> Panel:
    return next(found for found in panels(flight, flight.cross_track) if found.title == title)


@pytest.mark.parametrize(("title", "order"), [("Speed", 1), ("Acceleration", 2)])
def test_planned_is_the_trajectory_by_the_clock(planned: Flight, title: str, order: int) -> None:
    trajectory = planned.plan.course.trajectory
    assert trajectory is not None
    flown, asked = panel(planned, title).series[:2]
    expected = np.linalg.norm(trajectory(planned.record.time - planned.record.time[0], order), axis=1)
    np.testing.assert_allclose(asked.values, expected)
    assert np.abs(flown.values - expected).mean() < 0.1 * expected.max()


def test_the_tracking_error_has_a_panel_only_with_a_trajectory(planned: Flight) -> None:
    title = "Distance to the trajectory's point"
    assert panel(planned, title).series[0].values.max() == planned.metrics.tracking_max_m
    carrot = fly(loads(HOP))
    assert not {title, "Acceleration"} & {found.title for found in panels(carrot, carrot.cross_track)}


def test_the_trajectory_is_drawn_beside_the_route(planned: Flight) -> None:
    shown, drawn = [view(planned, "hop", PALETTE[0])], scene(planned.plan)
    for figure in (space(shown, drawn), plan_view(shown, drawn)):
        assert [trace["name"] for trace in figure["data"]][:3] == ["route", "trajectory", "flown"]
