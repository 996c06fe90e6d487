"""Loading, resolving, saving: what a mission says is what is flown."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose

from crosstrack.errors import InputError
from crosstrack.follow.carrot import Carrot
from crosstrack.mission import Mission, Start, from_document, load, loads, save, schema
from crosstrack.mission.load import dump
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor

SQUARE = "start: {position: [0, 0, 10]}\nroute: [[20, 0, 10], [20, 20, 10], [0, 20, 10], [0, 0, 10]]\n"


def test_defaults_are_those_of_the_contract() -> None:
    document = loads(SQUARE).document()
    assert document == {
        "name": "mission",
        "start": {"position": [0, 0, 10], "yaw": 0, "takeoff": False, "on_route": True},
        "route": [[20, 0, 10], [20, 20, 10], [0, 20, 10], [0, 0, 10]],
        "speed": 5, "tolerance": 0.3, "frame": "enu", "loop": False,
        "world": {"ground": 0, "shapes": [], "unmapped": [], "moving": []},
        "vehicle": {"kind": "quadrotor", "airframe": "generic", "radius": 0.2},
        "tracker": document["tracker"],
        "avoid": [], "replan": "auto", "map": "known", "sensors": [], "vehicles": [],
        "limits": {"speed": 12, "acceleration": 8, "tilt_deg": 45},
        "wind": {"mean": [0, 0, 0], "gusts": "none"},
        "air": {"temperature": 288.15, "pressure": 101325},
        "noise": {"position": 0, "velocity": 0, "acceleration": 0, "delay": 0},
            "mismatch": {"mass": 1, "drag": 1, "motor_time": 1},
        "timing": {"rate": 50, "timeout": 300},
        "seed": 1,
    }  # fmt: skip
    assert document["tracker"]["kind"] == "carrot"


def test_the_contract_s_own_mission_loads_from_yaml_and_from_json() -> None:
    document = {
        "name": "square",
        "start": {"position": [0, 0, 10], "yaw": 0},
        "route": [[20, 0, 10], [20, 20, 10], [0, 20, 10], [0, 0, 10]],
        "speed": 5,
        "tolerance": 0.3,
        "world": {"bounds": [[-60, -60, 0], [90, 90, 60]], "shapes": []},
        "vehicle": {"kind": "quadrotor", "airframe": "generic", "radius": 0.2},
        "tracker": {"kind": "carrot", "lookahead": 1.5},
        "limits": {"speed": 12, "acceleration": 8, "tilt_deg": 45},
        "wind": {"mean": [0, 0, 0], "gusts": "none"},
        "noise": {"position": 0.0, "velocity": 0.0, "delay": 0.0},
        "timing": {"rate": 50, "timeout": 300},
        "seed": 1,
    }
    mission = loads(json.dumps(document))
    assert mission == loads(dump(document)) == from_document(document)
    assert mission.tracker == Carrot(lookahead=1.5)
    assert mission.name == "square"


def test_the_name_is_the_file_s_when_none_is_given(tmp_path: Path) -> None:
    (tmp_path / "lap.yaml").write_text(SQUARE)
    (tmp_path / "named.yaml").write_text(SQUARE + "name: tour\n")
    assert load(tmp_path / "lap.yaml").name == "lap"
    assert load(str(tmp_path / "named.yaml")).name == "tour"


def test_building_makes_the_plan_that_the_mission_says() -> None:
    mission = loads(
        SQUARE + "speed: 4\nseed: 7\ntiming: {rate: 100, timeout: 60}\nwind: {mean: [1, 2, 0]}\n"
        "limits: {speed: 6}\nworld: {ground: -1, shapes: [{sphere: {center: [5, 5, 5], radius: 1}}]}\n"
    )
    plan = mission.build()
    assert plan.route.length == pytest.approx(80)
    assert plan.timeout == 60
    assert plan.document == mission.document()
    scenario = plan.scenario
    assert (scenario.period, scenario.cruise, scenario.seed, scenario.limits.speed) == (0.01, 4, 7, 6)
    assert scenario.wind.mean == (1, 2, 0)
    assert scenario.world.ground == -1
    assert scenario.position.tolist() == [0, 0, 10]
    assert float(scenario.world.distance(np.array([5.0, 5.0, 9.0]))) == pytest.approx(3)


@pytest.mark.parametrize(
    ("lines", "points"),
    [
        ("start: {position: [1, 2, 3]}\nroute: [[4, 5], [6, 7]]", [[1, 2, 3], [4, 5, 3], [6, 7, 3]]),
        ("start: {position: [1, 2, 3], on_route: false}\nroute: [[4, 5], [6, 7]]", [[4, 5, 3], [6, 7, 3]]),
        ("start: {position: [1, 2, 3]}\nroute: [[4, 5]]\nloop: true", [[1, 2, 3], [4, 5, 3], [1, 2, 3]]),
        (
            "start: {position: [1, 2, 3], on_route: false}\nroute: [[4, 5], [6, 7]]\nloop: true",
            [[4, 5, 3], [6, 7, 3], [4, 5, 3]],
        ),
        (
            "start: {position: [1, 2, 3], takeoff: true}\nroute: [[4, 5]]\nloop: true",
            [[1, 2, 0], [1, 2, 3], [4, 5, 3], [1, 2, 3]],
        ),
        (
            "start: {position: [1, 2, 3], takeoff: true}\nworld: {ground: 1}\nroute: [[4, 5, 6]]",
            [[1, 2, 1], [1, 2, 3], [4, 5, 6]],
        ),
    ],
)
def test_the_route_is_made_of_start_points_and_closing(lines: str, points: list[list[float]]) -> None:
    mission = loads(lines)
    assert mission.points.tolist() == points
    assert_allclose(mission.scenario().position, points[0] if mission.start.on_route else [1, 2, 3])


def test_a_mission_made_in_python_is_checked_when_it_is_built() -> None:
    good = Mission(start=Start((0, 0, 10)), route=((20, 0), (20, 20)))
    assert good.build().route.length == pytest.approx(40)
    with pytest.raises(InputError, match=r"speed: must be greater than 0, found -3"):
        Mission(start=Start((0, 0, 10)), route=((20, 0),), speed=-3).build()
    with pytest.raises(InputError, match=r"above limits\.speed"):
        Mission(start=Start((0, 0, 10)), route=((20, 0),), speed=30).build()
    with pytest.raises(InputError, match="known kinds: quadrotor, point"):
        Mission(start=Start((0, 0, 10)), route=((20, 0),), vehicle="quadrotor").build()


def test_another_vehicle_keeps_what_both_have() -> None:
    mission = loads(SQUARE + "vehicle: {kind: quadrotor, airframe: racer, radius: 0.4}")
    assert mission.with_vehicle("point").vehicle == Point(radius=0.4)
    assert mission.with_vehicle("point").with_vehicle("quadrotor").vehicle == Quadrotor(radius=0.4)
    with pytest.raises(InputError, match="unknown vehicle 'boat'; known: quadrotor, point"):
        mission.with_vehicle("boat")


def test_files_come_from_the_mission_s_folder_or_from_contents(tmp_path: Path) -> None:
    examples = Path(__file__).parents[2] / "examples"
    mission = load(examples / "rooms.yaml")
    plan = mission.build()
    assert dict(plan.files) == {"rooms.png": (examples / "rooms.png").read_bytes()}
    again = from_document(plan.document, plan.files).build()
    probes = np.random.default_rng(1).uniform([0, 0, 0], [40, 30, 3], size=(200, 3))
    np.testing.assert_array_equal(again.scenario.world.distance(probes), plan.scenario.world.distance(probes))
    with pytest.raises(InputError, match=r"rooms.png: no such file; there are: none"):
        from_document(plan.document, {})


def test_names_of_files_in_a_log_are_not_paths(tmp_path: Path) -> None:
    (tmp_path / "secret.plan").write_text("{}")
    with pytest.raises(InputError, match="no such file; there are: other"):
        from_document({"start": {"position": [0, 0, 1]}, "route": str(tmp_path / "secret.plan")}, {"other": b""})


coordinate = st.floats(-500, 500).map(lambda value: round(value, 3))
height = st.floats(0, 100).map(lambda value: round(value, 3))
space = st.tuples(coordinate, coordinate, height).map(list)
plane = st.tuples(coordinate, coordinate).map(list)
positive = st.floats(0.01, 12)


@st.composite
def documents(draw: st.DrawFn) -> dict[str, Any]:
    """Draw missions that are right: obstacles lie beyond every waypoint."""
    sphere = {"sphere": {"center": [2000, 2000, draw(height)], "radius": draw(positive)}}
    cylinder = {"cylinder": {"center": [3000, draw(coordinate)], "radius": draw(positive), "z": [-1, draw(height)]}}
    box = {"box": {"min": [-3000, -3000, 0], "max": [-2900, -2900, draw(positive)]}}
    prism = {"prism": {"polygon": [[900, 0], [950, 0], [900, draw(positive)]], "z": [0, 1]}}
    forest = {"kind": "forest", "seed": draw(st.integers(0, 9)), "size": [3, 3, 3], "origin": [5000, 0]}
    full: dict[str, Any] = {
        "name": draw(st.sampled_from(["a", "Übung 1", "no", "1e3", "true", "x: y", "-", "#1", "'"])),
        "start": {"position": [*draw(plane), 101], "yaw": draw(coordinate), "on_route": draw(st.booleans())},
        "route": [[600, 600, 5] if draw(st.booleans()) else [600, 600]],
        "loop": draw(st.booleans()),
        "speed": draw(positive),
        "tolerance": draw(positive),
        "world": {
            "bounds": [[-1e4, -1e4, -1], [1e4, 1e4, 1e3]],
            "ground": -0.5,
            "shapes": draw(st.permutations([sphere, cylinder, box, prism])),
            **({"generate": forest} if draw(st.booleans()) else {}),
        },
        "vehicle": draw(
            st.sampled_from([{"kind": "point", "acceleration": 3}, {"kind": "quadrotor", "airframe": "racer"}])
        ),
        "tracker": {"kind": "carrot", "lookahead": draw(positive)},
        "wind": {"mean": draw(space), "gusts": draw(st.sampled_from(["none", "light", "moderate", "severe"]))},
        "noise": {"position": draw(positive), "delay": draw(positive)},
        "timing": {"rate": draw(st.floats(1, 1000)), "timeout": draw(positive)},
        "origin": {"latitude": draw(st.floats(-90, 90)), "longitude": draw(st.floats(-180, 180))},
        "seed": draw(st.integers(0, 2**63 - 1)),
    }
    points = draw(st.lists(space if len(full["route"][0]) == 3 else plane, min_size=1, max_size=4))
    full["route"] += points
    keep = draw(st.sets(st.sampled_from(sorted(full))))
    return {name: value for name, value in full.items() if name in keep | {"start", "route"}}


@settings(max_examples=60)
@given(documents())
def test_missions_survive_saving_and_loading(document: dict[str, Any]) -> None:
    mission = from_document(document)
    assert loads(dump(document)) == mission
    assert loads(json.dumps(document)) == mission
    assert loads(dump(mission.document())) == mission
    assert from_document(json.loads(json.dumps(mission.document()))) == mission
    Draft202012Validator(SCHEMA).validate(document)
    Draft202012Validator(SCHEMA).validate(mission.document())


SCHEMA = schema()


def test_saving_writes_a_file_that_loads_equal(tmp_path: Path) -> None:
    mission = loads(SQUARE + "world: {generate: {kind: city, origin: [50, 50]}}")
    save(mission, tmp_path / "out.yaml")
    assert load(tmp_path / "out.yaml") == mission


def test_the_schema_is_one_and_refuses_what_the_loader_refuses() -> None:
    Draft202012Validator.check_schema(SCHEMA)
    validator = Draft202012Validator(SCHEMA)
    good: dict[str, Any] = {"start": {"position": [0, 0, 10]}, "route": [[20, 0, 10]]}
    assert validator.is_valid(good)
    wrongs: list[dict[str, Any]] = [
        {"sped": 1}, {"speed": 0}, {"speed": "5"}, {"route": []}, {"route": [[1]]}, {"tracker": {"kind": "carot"}},
        {"tracker": {"kind": "carrot", "lookahed": 1}}, {"vehicle": {"kind": "point", "airframe": "racer"}},
        {"tracker": {"lookahead": 1}}, {"seed": 1.5}, {"world": {"generate": {"kind": "forest", "density": -1}}},
        {"world": {"shapes": [{"cube": {}}]}}, {"wind": {"mean": [1, 2]}}, {"limits": {"tilt_deg": 81}},
    ]  # fmt: skip
    for wrong in wrongs:
        assert not validator.is_valid(good | wrong), wrong
        with pytest.raises(InputError):
            from_document(good | wrong)
    described = SCHEMA["properties"]["speed"]
    assert described["default"] == 5
    assert "m/s" in described["description"]


def test_tuples_and_arrays_do_as_lists() -> None:
    route = np.array([[20.0, 0.0, 10.0], [20.0, 20.0, 10.0]])
    mission = from_document({"start": {"position": (0, 0, 10)}, "route": route, "seed": np.int64(3)})
    assert mission == loads("start: {position: [0, 0, 10]}\nroute: [[20, 0, 10], [20, 20, 10]]\nseed: 3")


def test_every_broken_source_of_a_world_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        loads(SQUARE + "world:\n  image: {file: no.png}\n  cloud: {file: no.ply}\n")
    assert [problem.place for problem in caught.value.problems] == ["world.image", "world.cloud"]
    assert len({problem.line for problem in caught.value.problems}) == 2


def test_a_route_of_fifty_thousand_points_is_read() -> None:
    points = ",".join(f"[{k / 1000},0,10]" for k in range(1, 50_001))
    assert len(loads(f"start: {{position: [0, 0, 10]}}\nroute: [{points}]\n").points) == 50_001
