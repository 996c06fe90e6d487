"""QGroundControl plans: in, out, and everything that is wrong with them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack import frames
from crosstrack.errors import InputError
from crosstrack.frames import Origin
from crosstrack.mission import export_plan, from_document, load
from crosstrack.mission.export import plan_document
from crosstrack.mission.qgroundcontrol import PlanFile, local_from_plan, plan_from_local, read_plan

HOME = Origin(47.397742, 8.545594, 488.0)


def item(command: int, *params: object, frame: int = 3, **more: Any) -> dict[str, Any]:
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": list(params), **more}


def at(x: float, y: float, height: float, command: int = 16, frame: int = 3, wait: float = 0) -> dict[str, Any]:
    """Return an item at a local place."""
    ((latitude, longitude, _),) = plan_from_local(np.array([[x, y, 0.0]]), HOME).tolist()
    return item(command, wait, 0, 0, None, latitude, longitude, height, frame=frame)


def plan(*items: Any, **more: Any) -> bytes:
    mission = {
        "version": 2,
        "plannedHomePosition": [HOME.latitude, HOME.longitude, HOME.altitude],
        "items": list(items),
    }
    return json.dumps({"fileType": "Plan", "version": 1, "mission": mission, **more}).encode()


def read(*items: Any, **more: Any) -> PlanFile:
    return read_plan("test.plan", plan(*items, **more))


def test_waypoints_splines_and_loiters_are_flown_through() -> None:
    found = read(at(10, 0, 5), at(10, 20, 6, command=82), at(0, 20, 7, command=17), at(0, 0, 8, wait=3))
    np.testing.assert_allclose(found.points, [[10, 0, 5], [10, 20, 6], [0, 20, 7], [0, 0, 8]], atol=1e-6)
    assert found.home == HOME
    assert found.remarks == (
        "mission.items[2]: loiter (17) is flown through, without circling or waiting",
        "mission.items[3]: the wait of 3 s is not flown",
    )


def test_altitudes_over_home_over_the_sea_and_over_flat_terrain() -> None:
    found = read(at(10, 0, 5), at(20, 0, 498, frame=0), at(30, 0, 7, frame=10), at(40, 0, 9, frame=6))
    np.testing.assert_allclose(found.points[:, 2], [5, 10, 7, 9], atol=1e-9)
    assert found.remarks == ("mission.items[2]: the terrain is taken to be flat, at the home's altitude",)


def test_takeoff_is_over_home_unless_it_says_where() -> None:
    found = read(item(22, 0, 0, 0, None, 0, 0, 12), at(10, 0, 12))
    assert found.takeoff
    np.testing.assert_allclose(found.points, [[0, 0, 12], [10, 0, 12]], atol=1e-6)
    there = read(at(3, 4, 12, command=22), at(10, 0, 12))
    np.testing.assert_allclose(there.points[0], [3, 4, 12], atol=1e-6)
    assert not read(at(10, 0, 12)).takeoff


def test_landing_and_returning_come_down_from_the_height_reached() -> None:
    landed = read(at(10, 0, 12), at(20, 0, 0, command=21))
    np.testing.assert_allclose(landed.points, [[10, 0, 12], [20, 0, 12], [20, 0, 0]], atol=1e-6)
    home = read(at(10, 0, 12), item(20, 0, 0, 0, 0, 0, 0, 0, frame=2))
    np.testing.assert_allclose(home.points, [[10, 0, 12], [0, 0, 12], [0, 0, 0]], atol=1e-6)


def test_the_first_speed_is_the_mission_s_and_later_ones_are_told() -> None:
    change = [item(178, 1, speed, -1, 0, 0, 0, 0, frame=2) for speed in (7, 3)]
    found = read(change[0], at(10, 0, 5), change[1], at(20, 0, 5))
    assert found.speed == 7
    assert found.remarks == ("mission.items[2]: change speed (178) is not flown",)


@pytest.mark.parametrize("kind", ["survey", "CorridorScan", "StructureScan"])
def test_scans_are_flown_by_the_items_they_were_made_into(kind: str) -> None:
    scan = {
        "type": "ComplexItem",
        "complexItemType": kind,
        "TransectStyleComplexItem": {"Items": [at(10, 0, 5), item(206, 5, 0, 1, 0, 0, 0, 0, frame=2), at(10, 30, 5)]},
    }
    found = read(at(0, 0, 5), scan, at(20, 0, 5))
    np.testing.assert_allclose(found.points[1:3], [[10, 0, 5], [10, 30, 5]], atol=1e-6)
    assert len(found.points) == 4
    assert found.remarks == ("mission.items[1].Items[1]: camera trigger distance (206) is not flown",)


def test_nothing_is_dropped_silently() -> None:
    found = read(
        at(0, 5, 5),
        item(177, 1, 2, 0, 0, 0, 0, 0, frame=2),
        item(206, 1, 2, 0, 0, 0, 0, 0, frame=2),
        item(206, 1, 2, 0, 0, 0, 0, 0, frame=2),
        item(31337, 1, 2, 0, 0, 0, 0, 0, frame=2),
        {"type": "ComplexItem", "complexItemType": "fwLandingPattern"},
        geoFence={"polygons": [{"polygon": []}], "circles": [], "version": 2},
        rallyPoints={"points": [[1, 2, 3]], "version": 2},
    )
    assert found.remarks == (
        "mission.items[1]: jump (177) is not flown",
        "mission.items[2] and 1 more: camera trigger distance (206) is not flown",
        "mission.items[4]: command (31337) is not flown",
        "mission.items[5]: fwLandingPattern without flight items is not flown",
        "geoFence.polygons: not imported; set world.bounds to fence the flight",
        "rallyPoints.points: not imported",
    )


@pytest.mark.parametrize(
    ("content", "messages"),
    [
        (b"", ["not JSON"]),
        (b"\xff\xfe", ["not JSON"]),
        (b"[" * 100_000, ["not JSON"]),
        (b" " * 4_000_001, ["larger than 4000000 bytes"]),
        (b"[]", ["fileType: is not 'Plan'"]),
        (b'{"fileType": "GeoFence"}', ["fileType: is not 'Plan'"]),
        (b'{"fileType": "Plan"}', ["mission.items: is missing or no list"]),
        (b'{"fileType": "Plan", "mission": {"items": []}}', ["plannedHomePosition: must be [latitude, longitude"]),
        (b'{"fileType": "Plan", "mission": {"items": [], "plannedHomePosition": [1, NaN, 3]}}', ["found [1, nan, 3]"]),
        (plan(), ["mission.items: holds no waypoint"]),
        (plan(5), ["mission.items[0]: is neither a SimpleItem nor a ComplexItem"]),
        (plan({"type": "SimpleItem"}), ["mission.items[0]: must have a command number and 7 params"]),
        (plan(item(16, 0, 0, 0)), ["mission.items[0]: must have a command number and 7 params"]),
        (plan(item(16, 0, 0, 0, None, 95, 8, 5)), ["must have a latitude and a longitude, found 95, 8"]),
        (plan(item(16, 0, 0, 0, None, None, None, 5)), ["must have a latitude and a longitude, found None, None"]),
        (plan(item(16, 0, 0, 0, None, 47, 8, "5")), ["altitude must be a number, found '5'"]),
        (plan(item(16, 0, 0, 0, None, 47, 8, True)), ["altitude must be a number, found True"]),
        (
            plan(item(16, 0, 0, 0, None, 47, 8, 5, frame=1), 7, item(16, 0, 0, 0, None, 47, 8, None)),
            [
                "mission.items[0]: frame 1 is unknown; allowed: 0",
                "mission.items[1]: is neither",
                "mission.items[2]: alt",
            ],
        ),
    ],
)
def test_malformed_plans_are_told_at_every_fault(content: bytes, messages: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        read_plan("bad.plan", content)
    assert len(caught.value.problems) == len(messages)
    for problem, message in zip(caught.value.problems, messages, strict=True):
        assert message in str(problem)


junk = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.sampled_from(["Plan", "SimpleItem", "ComplexItem", "x"]),
    lambda inner: (
        st.lists(inner, max_size=7)
        | st.dictionaries(
            st.sampled_from(
                ["type", "command", "params", "frame", "TransectStyleComplexItem", "Items", "complexItemType"]
            ),
            inner,
        )
    ),
    max_leaves=12,
)
params = st.lists(st.none() | st.floats() | st.integers(-200, 200), min_size=7, max_size=7)
simple = st.fixed_dictionaries(
    {
        "type": st.just("SimpleItem"),
        "command": st.sampled_from([16, 20, 21, 22, 82, 178, 206, 1 << 70]),
        "params": params | junk,
    },
    optional={"frame": st.sampled_from([0, 3, 10]) | junk},
)


@given(st.lists(simple | junk, max_size=4), st.booleans())
def test_any_items_are_read_or_refused(items: list[Any], scan: bool) -> None:
    wrapped = [{"type": "ComplexItem", "TransectStyleComplexItem": {"Items": items}}] if scan else items
    try:
        found = read_plan("fuzz.plan", plan(*wrapped))
    except InputError:
        return
    assert np.isfinite(found.points).all()


@given(st.lists(st.tuples(*[st.floats(-10_000, 10_000)] * 2, st.floats(0, 500)), min_size=1, max_size=5))
def test_places_come_back_within_a_millimetre_at_ten_kilometres(points: list[tuple[float, float, float]]) -> None:
    local = np.array(points)
    np.testing.assert_allclose(local_from_plan(plan_from_local(local, HOME), HOME), local, atol=1e-6)


def test_horizontal_places_are_those_of_the_tangent_plane() -> None:
    geodetic = plan_from_local(np.array([[3000.0, -4000.0, 30.0]]), HOME)
    assert geodetic[0, 2] == pytest.approx(518)
    level = [*geodetic[0, :2], HOME.altitude]
    np.testing.assert_allclose(frames.local_from_geodetic(level, HOME)[:2], [3000, -4000], atol=1e-6)


def mission_document(**more: Any) -> dict[str, Any]:
    return {"start": {"position": [0, 0, 10]}, "route": [[20, 0, 10], [20, 25, 12]], "speed": 4, **more}


def test_an_exported_mission_is_a_plan_as_qgroundcontrol_reads_it() -> None:
    found = plan_document(from_document(mission_document()))
    assert (found["fileType"], found["version"], found["mission"]["version"]) == ("Plan", 1, 2)
    assert isinstance(found["groundStation"], str)
    assert found["geoFence"] == {"circles": [], "polygons": [], "version": 2}
    assert found["rallyPoints"] == {"points": [], "version": 2}
    assert found["mission"]["plannedHomePosition"] == [47.641468, -122.140165, 122]
    items = found["mission"]["items"]
    assert [entry["command"] for entry in items] == [178, 16, 16, 16]
    assert [entry["doJumpId"] for entry in items] == [1, 2, 3, 4]
    for entry in items:
        assert entry["type"] == "SimpleItem"
        assert entry["autoContinue"] is True
        assert len(entry["params"]) == 7
    assert items[0]["params"][1] == 4
    assert [entry["frame"] for entry in items[1:]] == [3, 3, 3]
    assert [entry["params"][6] for entry in items[1:]] == [10, 10, 12]


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"start": {"position": [5, 6, 7], "takeoff": True}},
        {"start": {"position": [5, 6, 7], "on_route": False}},
        {"loop": True},
        {"frame": "ned", "start": {"position": [0, 0, -10]}, "route": [[20, 0, -10], [20, 25, -12]]},
        {"origin": {"latitude": -33.9, "longitude": 151.2, "altitude": 6}},
    ],
)
def test_a_mission_exported_and_imported_flies_the_same_route(more: dict[str, Any], tmp_path: Path) -> None:
    mission = from_document(mission_document(**more))
    export_plan(mission, tmp_path / "out.plan")
    again = from_document({"route": "out.plan"}, tmp_path)
    assert again.speed == 4
    assert again.start.takeoff is mission.start.takeoff
    np.testing.assert_allclose(again.build().route.points, mission.build().route.points, atol=1e-5)
    assert again.place == mission.place


def test_the_mission_s_own_fields_win_over_the_plan_s(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_bytes(plan(item(178, 1, 7, -1, 0, 0, 0, 0, frame=2), at(10, 0, 5), at(20, 0, 5)))
    (tmp_path / "m.yaml").write_text("route: a.plan\n")
    taken = load(tmp_path / "m.yaml")
    assert taken.speed == 7
    np.testing.assert_allclose(taken.start.position, [10, 0, 5], atol=1e-6)
    (tmp_path / "m.yaml").write_text("route: a.plan\nspeed: 2\nstart: {position: [0, 0, 3]}\n")
    own = load(tmp_path / "m.yaml")
    assert own.speed == 2
    assert own.start.position == (0, 0, 3)


def test_an_origin_moves_the_plan(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_bytes(plan(at(10, 0, 5), at(20, 0, 5)))
    ((latitude, longitude, _),) = plan_from_local(np.array([[4.0, 3.0, 0.0]]), HOME).tolist()
    origin = {"latitude": latitude, "longitude": longitude, "altitude": 480}
    moved = from_document({"route": "a.plan", "origin": origin}, tmp_path)
    np.testing.assert_allclose(moved.waypoints, [[6, -3, 13], [16, -3, 13]], atol=1e-4)


def test_in_ned_the_plan_keeps_its_place_and_the_start_is_found_from_it(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_bytes(plan(at(10, 0, 5), at(20, 0, 5)))
    mission = from_document({"route": "a.plan", "frame": "ned"}, tmp_path)
    np.testing.assert_allclose(mission.start.position, [0, 10, -5], atol=1e-6)
    np.testing.assert_allclose(mission.points, [[10, 0, 5], [10, 0, 5], [20, 0, 5]], atol=1e-6)


def test_a_broken_plan_is_told_with_the_rest_of_the_mission(tmp_path: Path) -> None:
    (tmp_path / "a.plan").write_bytes(plan(5))
    with pytest.raises(InputError) as caught:
        from_document({"route": "a.plan", "start": {"position": [0, 0, 1]}, "speed": "fast"}, tmp_path)
    assert [problem.place for problem in caught.value.problems] == ["speed", "route"]
    assert "a.plan: mission.items[0]: is neither" in str(caught.value)
