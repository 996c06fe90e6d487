"""Settings from outside the file."""

import pytest

from crosstrack.errors import InputError
from crosstrack.follow.carrot import Carrot
from crosstrack.mission import Mission, loads
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.generate import Gap

TEXT = (
    "start: {position: [0, 0, 10]}\nroute: [[20, 0, 10], [20, 20, 10]]\n"
    "tracker: {kind: carrot, lookahead: 1}\nvehicle: {kind: quadrotor, airframe: racer, radius: 0.3}\n"
)


def set_to(*settings: str, text: str = TEXT) -> Mission:
    return loads(text, settings=settings)


def test_values_are_read_as_yaml() -> None:
    mission = set_to(
        "tracker.lookahead=2", "speed=1e-1", "loop=true", "wind.gusts=light", "wind.mean=[1, 2, 0]", "route.1.2=12",
        "start.yaw=1.5", "name=a=b",
    )  # fmt: skip
    assert mission.tracker == Carrot(lookahead=2)
    assert (mission.speed, mission.loop, mission.wind.gusts) == (0.1, True, "light")
    assert mission.wind.mean == (1, 2, 0)
    assert mission.route is not None
    assert mission.route[1] == (20, 20, 12)
    assert mission.start.yaw == 1.5
    assert mission.name == "a=b"


def test_what_the_file_leaves_out_can_be_set() -> None:
    text = "start: {position: [0, 0, 10]}\nroute: [[20, 0, 10]]\n"
    mission = set_to(
        "tracker.lookahead=3", "vehicle.airframe=crazyflie", "limits.speed=6", "world.ground=-1", text=text
    )
    assert mission.tracker == Carrot(lookahead=3)
    assert mission.vehicle == Quadrotor(airframe="crazyflie")
    assert (mission.limits.speed, mission.world.ground) == (6, -1)
    gap = set_to("world.generate={kind: gap, origin: [50, 0]}", "world.generate.seed=4").world.generate
    assert gap == Gap(seed=4, origin=(50, 0))


def test_another_kind_keeps_the_fields_that_both_have() -> None:
    assert set_to("vehicle.kind=point").vehicle == Point(radius=0.3)
    assert set_to("vehicle.kind=point", "vehicle.lag=0.1").vehicle == Point(radius=0.3, lag=0.1)


def test_later_settings_win() -> None:
    assert set_to("speed=3", "speed=4").speed == 4


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("tracker.lookahed=2", "there is no 'lookahed' here; did you mean 'lookahead'? known: kind, lookahead"),
        ("sped=2", "there is no 'sped' here; did you mean 'speed'? known: name, start"),
        ("speed.fast=2", "there is no 'fast' here; known: none"),
        ("route.7.0=2", "'7' is no index of a list of 2, counted from 0"),
        ("route.x=2", "'x' is no index of a list of 2"),
        ("tracker.lookahead", "must be PATH=VALUE, such as tracker.lookahead=2"),
        ("=2", "there is no '' here"),
        ("speed=[1", "not YAML"),
        ("world.shapes.0.box=1", "there is no '0' here"),
    ],
)
def test_settings_that_name_nothing_are_told_with_what_there_is(setting: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        set_to(setting)
    assert message in str(caught.value)


def test_all_bad_settings_are_told_at_once() -> None:
    with pytest.raises(InputError, match="3 problems"):
        set_to("a=1", "b=2", "tracker.c=3")


def test_bad_values_are_told_by_their_path_without_a_line_of_the_file() -> None:
    with pytest.raises(InputError) as caught:
        set_to("tracker.lookahead=-2", "vehicle.kind=boat")
    assert {str(problem)[:24] for problem in caught.value.problems} == {
        "tracker.lookahead: must ",
        "vehicle.kind: unknown ve",
    }
