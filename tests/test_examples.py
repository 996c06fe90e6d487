"""The missions that ship: each says what it is documented to say, and flies to its end."""

import math
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from PIL import Image

from crosstrack.flight.flight import Flight
from crosstrack.flight.summary import summary
from crosstrack.follow.carrot import Carrot
from crosstrack.mission import Mission, load, schema
from crosstrack.mission.check import remarks
from crosstrack.mission.flying import fly_together
from crosstrack.types import Outcome
from crosstrack.world.world import World

FOLDER = Path(__file__).parents[1] / "examples"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))


def example(name: str) -> Mission:
    return load(FOLDER / f"{name}.yaml")


@cache
def flights_of(name: str) -> list[Flight]:
    """Return the flights of an example, one for each vehicle, flown once."""
    return fly_together(example(name))


def flight_of(name: str) -> Flight:
    """Return the flight of an example's only vehicle."""
    (flight,) = flights_of(name)
    return flight


def flown(name: str) -> dict[str, Any]:
    """Return the summary of an example's flight."""
    return summary(flight_of(name))


@pytest.mark.parametrize("name", NAMES)
def test_every_example_arrives(name: str) -> None:
    assert {flight.outcome for flight in flights_of(name)} == {Outcome.ARRIVED}


@pytest.mark.parametrize("name", NAMES)
def test_every_example_satisfies_the_schema_and_says_what_it_shows(name: str) -> None:
    Draft202012Validator(schema()).validate(example(name).document())
    assert (FOLDER / f"{name}.yaml").read_text().startswith("# ")


@pytest.mark.parametrize("name", NAMES)
def test_no_example_has_a_leg_too_close_to_an_obstacle(name: str) -> None:
    assert [remark for remark in remarks(example(name)) if "obstacle" in remark] == []


@pytest.mark.parametrize(
    ("name", "start", "corners", "lookahead", "most"),
    [
        ("article_two_points", [3, 3], [[0, 0], [10, 15]], 1.0, 0.012),
        ("article_four_points", [6, 3], [[0, 0], [10, 15], [15, 20], [20, 5]], 1.0, 0.089),
        ("article_four_points_short", [6, 3], [[0, 0], [10, 15], [15, 20], [20, 5]], 0.1, 0.003),
    ],
)
def test_the_article_s_runs(
    name: str, start: list[float], corners: list[list[float]], lookahead: float, most: float
) -> None:
    plan = example(name).build()
    assert plan.scenario.position.tolist() == [*start, 0]
    assert plan.scenario.yaw == 0.5
    assert plan.route.points[:, :2].tolist() == corners
    assert plan.tracker == Carrot(lookahead=lookahead, heading_gain=0.5)
    assert plan.scenario.cruise == 3
    assert plan.vehicle == load(FOLDER / f"{name}.yaml", ["vehicle={kind: point}"]).vehicle
    assert flown(name)["cross_track_rms_captured_m"] <= most


@pytest.mark.parametrize(
    ("name", "speed", "lookahead", "longest", "rms", "worst"),
    [
        ("airsim_path", 1, 1.5, 26, 0.05, math.inf),
        ("airsim_path_short", 1, 0.8, 26, 0.05, math.inf),
        ("airsim_path_5", 5, 0.8, 12, 0.10, math.inf),
        ("airsim_path_10", 10, 1.5, 11, math.inf, 0.5),
    ],
)
def test_the_airsim_path(name: str, speed: float, lookahead: float, longest: float, rms: float, worst: float) -> None:
    plan = example(name).build()
    assert plan.scenario.position.tolist() == [0, 0, 3]
    assert plan.scenario.yaw == pytest.approx(math.pi / 2)
    corners = [[0, 0, 3], [0, 5, 3], [8, 5, 3], [12, 8, 3], [9, 4, 3]]
    assert plan.route.points.tolist() == corners
    assert plan.scenario.cruise == speed
    assert plan.tracker == Carrot(lookahead=lookahead, heading_gain=0.8)
    found = flown(name)
    assert found["flight_time_s"] <= longest
    assert found["cross_track_rms_captured_m"] <= rms
    assert found["cross_track_max_m"] <= worst


def test_the_square() -> None:
    plan = example("square").build()
    assert plan.route.length == pytest.approx(80)
    found = flown("square")
    assert found["max_speed_mps"] <= 5.3
    assert found["flight_time_s"] <= 18.6
    assert found["cross_track_rms_m"] <= 0.15
    assert found["cross_track_max_m"] <= 0.4


def test_the_figure_of_eight_crosses_itself_and_closes() -> None:
    mission = example("figure_eight")
    points = mission.points
    assert np.linalg.norm(points[-1] - points[0]) == 0
    middle = len(points) // 2
    assert np.linalg.norm(points[middle] - points[0]) < 0.5
    assert flown("figure_eight")["flown_length_m"] == pytest.approx(mission.build().route.length, rel=0.02)


def test_the_spiral_climbs_all_the_way() -> None:
    points = example("spiral").points
    assert (np.diff(points[:, 2]) > 0).all()
    turned = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(6 * math.pi, abs=0.01)


def test_the_survey_comes_from_its_plan() -> None:
    mission = example("survey")
    assert mission.survey is not None
    assert mission.start.takeoff
    assert mission.speed == 6
    assert len(mission.waypoints) == 1 + 10 + 2
    np.testing.assert_allclose(np.abs(np.diff(mission.waypoints[1:11:2, 1])), 8, atol=0.1)
    assert remarks(mission) == [
        "survey.plan: mission.items[2].Items[1] and 9 more: camera trigger distance (206) is not flown"
    ]
    np.testing.assert_allclose(flight_of("survey").record.position[-1], [0, 0, 0], atol=0.2)


def test_the_gusty_crossing_has_wind() -> None:
    plan = example("gusty_crossing").build()
    assert plan.scenario.wind.gusts == "moderate"
    assert math.hypot(*plan.scenario.wind.mean) == pytest.approx(8, abs=0.1)
    assert flown("gusty_crossing")["cross_track_rms_m"] < plan.scenario.cruise


def test_rooms_stay_clear_of_the_walls_of_the_picture() -> None:
    plan = example("rooms").build()
    walls = np.array([[0.1, 15, 1], [12, 15, 1], [26, 5, 1], [17, 6, 1]])
    assert (plan.scenario.world.distance(walls) < 0).all()
    marks_on_the_floor = np.array([[8, 5, 1], [22, 15, 1]])
    assert (plan.scenario.world.distance(marks_on_the_floor) > 0.5).all()
    assert flown("rooms")["min_clearance_m"] > plan.vehicle.radius


def test_the_demo_finds_its_way_past_what_is_on_no_map() -> None:
    plan = example("demo").build()
    assert isinstance(plan.told, World)
    assert isinstance(plan.scenario.world, World)
    hidden = np.array([[11.5, 9.6, 1.5], [20.2, 9, 1.5], [30, 10.3, 1.5]])
    assert (plan.scenario.world.distance(hidden) < 0).all()
    assert (plan.told.distance(hidden) > 0).all()
    flight, found = flight_of("demo"), flown("demo")
    assert found["replans"] >= 1
    assert found["min_clearance_m"] >= plan.vehicle.radius
    unmapped = [shape for shape in plan.scenario.world.shapes if shape not in plan.told.shapes]
    assert len(unmapped) == 3
    assert (np.abs(World(tuple(unmapped)).distance(flight.seen)) < 0.02).sum() > 100


def test_the_city_flight_takes_off_flies_over_roofs_and_stays_clear() -> None:
    mission = example("city")
    plan = mission.build()
    assert plan.scenario.position.tolist() == [0, 0, 0]
    roofs = plan.scenario.world.distance(np.array([[12.5, 37.5, 5], [62.5, 37.5, 5], [87.5, 87.5, 5]]))
    assert (roofs < 0).all()
    assert flown("city")["min_clearance_m"] > plan.vehicle.radius
    assert flight_of("city").outcome is Outcome.ARRIVED


def test_what_a_camera_on_the_server_sees_is_drawn(tmp_path: Path) -> None:
    """Sky above, ground below, and something between, in each of the four pictures."""
    out = tmp_path / "views.png"
    subprocess.run([sys.executable, str(FOLDER / "airsim_views.py"), str(out)], check=True, capture_output=True)
    pixels = np.asarray(Image.open(out)).astype(int)
    assert pixels.shape == (576, 1024, 3)
    for part in (pixels[:288, :512], pixels[:288, 512:], pixels[288:, :512], pixels[288:, 512:]):
        assert np.abs(part[10, 200] - part[-10, 200]).max() > 30
        assert len(np.unique(part.reshape(-1, 3), axis=0)) >= 5
