"""Vehicles that fly at the same time."""

import numpy as np
import pytest
from flights import plan_for
from hypothesis import given
from hypothesis import strategies as st

import crosstrack as ct
from crosstrack.errors import InputError
from crosstrack.flight.loop import fly, fly_together
from crosstrack.flight.separation import nearest
from crosstrack.flight.summary import summary_together
from crosstrack.types import Outcome

EAST, NORTH = [[0, 0, 10], [20, 0, 10]], [[10, -10, 10], [10, 10, 10]]


@given(st.integers(0, 10_000))
def test_the_least_distance_is_that_of_dense_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    before, now = rng.normal(size=(2, 4, 3))
    radii = rng.uniform(0.1, 0.5, 4)
    s = np.linspace(0, 1, 2001)[:, None, None]
    places = before + s * (now - before)
    gaps = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1).min(axis=0) + 1e9 * np.eye(4)
    apart, between = nearest(before, now, radii)
    np.testing.assert_allclose(apart, gaps.min(axis=1), atol=2e-3)
    np.testing.assert_allclose(between, (gaps - radii[:, None] - radii).min(axis=1), atol=2e-3)


def test_far_apart_each_flies_as_if_alone() -> None:
    plans = [plan_for(EAST), plan_for([[0, 50, 10], [30, 50, 10]], seed=2)]
    together = fly_together(plans)
    for plan, flight in zip(plans, together, strict=True):
        alone = fly(plan)
        assert flight.outcome is alone.outcome is Outcome.ARRIVED
        np.testing.assert_array_equal(flight.record.position, alone.record.position)
        assert (alone.record.separation == np.inf).all()
    assert together[0].record.separation.min() == pytest.approx(50.0, abs=0.2)


def test_paths_that_cross_at_the_same_time_end_in_a_collision() -> None:
    flights = fly_together([plan_for(EAST), plan_for(NORTH)])
    assert [flight.outcome for flight in flights] == [Outcome.COLLIDED] * 2
    last = flights[0].record.separation[-1]
    assert last < 0.4
    found = summary_together(flights)
    assert (found["collided"], found["arrived"]) == (True, False)
    assert found["min_separation_m"] == pytest.approx(last)
    assert [vehicle["outcome"] for vehicle in found["vehicles"]] == ["collided", "collided"]


def test_one_that_has_arrived_is_still_in_the_way() -> None:
    short = plan_for([[8, 0, 10], [10, 0, 10]])
    flights = fly_together([short, plan_for([[-10, 0, 10], [20, 0, 10]])])
    assert flights[0].outcome is Outcome.ARRIVED
    assert flights[1].outcome is Outcome.COLLIDED
    assert flights[1].record.position[-1, 0] == pytest.approx(10 - 0.4, abs=0.25)


FLEET = """
vehicles:
  - {name: a, start: {position: [0, 0, 5]}, route: [[10, 0, 5]]}
  - {name: b, start: {position: [0, 4, 5]}, route: [[10, 4, 5]]}
speed: 3
"""


def test_a_mission_of_several_vehicles() -> None:
    mission = ct.loads(FLEET)
    assert ct.loads(str(mission.document())).document() == mission.document()
    one, two = ct.fly_together(mission)
    assert (one.plan.name, two.plan.name) == ("a", "b")
    assert one.outcome is two.outcome is Outcome.ARRIVED
    assert one.metrics.min_separation_m == pytest.approx(4.0, abs=0.05)
    with pytest.raises(InputError, match="vehicles: are several"):
        ct.fly(mission)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("name: b", "name: a"), "vehicles[1].name: 'a' is the name of another vehicle too"),
        (("[0, 4, 5]}", "[0, 0.3, 5]}"), "vehicles[1].start: is 0.3 m from that of 'a'; at least two radii, 0.4 m"),
        (("[[10, 4, 5]]", "[[10, 4, -5]]"), "vehicles[1].route[0]: (10, 4, -5) lies 5 m below the ground"),
        (("route: [[10, 4, 5]]", "goal: [10, 4, -5]"), "vehicles[1].goal: (10, 4, -5) lies 5 m below the ground"),
        (("start: {position: [0, 4, 5]}, ", ""), "vehicles[1].start: is required"),
        (("speed: 3", "speed: 30"), "speed: 30 m/s is above limits.speed, 12 m/s"),
    ],
)
def test_what_is_wrong_with_one_of_them(change: tuple[str, str], message: str) -> None:
    with pytest.raises(InputError) as caught:
        ct.loads(FLEET.replace(*change))
    assert message in str(caught.value)
    assert len(caught.value.problems) == 1
