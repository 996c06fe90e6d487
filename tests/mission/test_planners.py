"""Missions with a planner: what they may say, what follows from it, and what is certified."""

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from crosstrack.errors import InputError
from crosstrack.follow.carrot import Carrot
from crosstrack.mission import from_document, loads, schema
from crosstrack.mission.certified import certified, remarks
from crosstrack.mission.flying import fly
from crosstrack.plan.minimum import MinimumJerk, MinimumSnap
from crosstrack.track.feed_forward import FeedForward
from crosstrack.trajectory.files.json_file import to_json
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Outcome

HOP = "start: {position: [0, 0, 5]}\nroute: [[6, 0, 5], [6, 5, 6]]\nspeed: 3\n"
SNAP = "planner: {kind: minimum_snap, guide: 0}\n"
CURVE = minimum([[0, 0, 5], [6, 0, 5], [6, 5, 6]], [0, 4, 8], 4)


def told(text: str, settings: tuple[str, ...] = (), folder: Path | str = ".") -> list[str]:
    with pytest.raises(InputError) as caught:
        loads(text, folder, settings).build()
    return [str(problem) for problem in caught.value.problems]


def test_the_tracker_follows_from_the_planner() -> None:
    assert loads(HOP).tracker == Carrot()
    assert loads(HOP + SNAP).tracker == FeedForward()
    assert loads(HOP + SNAP).document()["tracker"]["kind"] == "feed_forward"
    assert loads(HOP + SNAP + "tracker: {kind: carrot}").tracker == Carrot()
    assert loads(HOP, settings=["planner.kind=minimum_jerk"]).planner == MinimumJerk()
    assert loads(HOP, settings=["tracker.lookahead=2"]).tracker == Carrot(lookahead=2)
    assert loads(HOP + SNAP, settings=["tracker.lead=0.5"]).tracker == FeedForward(lead=0.5)


def test_a_document_with_a_planner_is_valid_and_loads_equal() -> None:
    mission = loads(HOP + "planner: {kind: minimum_snap, times: optimal, yaw: velocity, guide: 2}")
    assert mission.planner == MinimumSnap(times="optimal", yaw="velocity", guide=2)
    Draft202012Validator(schema()).validate(mission.document())
    assert from_document(mission.document()) == mission
    assert "planner" not in loads(HOP).document()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "planner: minimum_snap",
            "planner: must be {kind: NAME, ...}; known kinds: minimum_snap, minimum_jerk, auto, file",
        ),
        ("planner: {kind: minimum_snp}", "planner.kind: unknown planner 'minimum_snp'; did you mean 'minimum_snap'?"),
        ("planner: {kind: minimum_snap, guide: -1}", "planner.guide: must be 'auto' or at least 0, found -1"),
        ("planner: {kind: minimum_snap, corridor: 0}", "planner.corridor: must be greater than 0, found 0"),
        ("planner: {kind: minimum_snap, guide: much}", "planner.guide: must be 'auto' or a number, found 'much'"),
        ("planner: {kind: minimum_snap, times: best}", "planner.times: must be 'constant', 'trapezoid', 'square_root'"),
        ("planner: {kind: minimum_snap, gide: 1}", "planner.gide: unknown; did you mean 'guide'?"),
        ("planner: {kind: file}", "planner.file: is required"),
        ("planner: {kind: file, file: no.json}", "planner: no.json: no such file: no.json"),
        (
            "tracker: {kind: feed_forward}",
            "tracker: feed_forward follows a trajectory: add a planner, such as planner:",
        ),
    ],
)
def test_one_wrong_line_is_one_problem_with_its_line(line: str, message: str) -> None:
    (problem,) = told(HOP + line)
    assert problem.startswith(f"line 4: {message}")


def test_a_planner_needs_a_start_on_the_route_and_a_vehicle_that_stops() -> None:
    (problem,) = told(HOP.replace("5]}", "5], on_route: false}") + SNAP)
    assert problem == "line 4: planner: plans from the start, which must be on the route: start.on_route is false"
    (problem,) = told(HOP + SNAP + "vehicle: {kind: point}\n")
    assert problem == "planner: plans from rest to rest, and this kind of vehicle cannot stop"


def test_a_file_s_problems_are_told_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text('{"version": 1}')
    text = HOP + "planner: {kind: file, file: t.json}"
    with pytest.raises(InputError, match=r"t\.json: 5 problems") as caught:
        loads(text, tmp_path).build()
    assert caught.value.source == "t.json"


def test_a_flight_of_a_file_is_that_of_its_planner(tmp_path: Path) -> None:
    planned = loads(HOP + SNAP).build()
    trajectory = planned.course.trajectory
    assert isinstance(trajectory, PiecewisePolynomial)
    (tmp_path / "t.json").write_text(to_json(trajectory))
    mission = loads(HOP + "planner: {kind: file, file: t.json}", tmp_path)
    assert mission.names == ["t.json"]
    first, second = fly(planned), fly(mission)
    assert first.outcome is Outcome.ARRIVED
    np.testing.assert_array_equal(first.record.position, second.record.position)
    assert set(second.plan.files) == {"t.json"}
    again = from_document(second.plan.document, second.plan.files).build()
    np.testing.assert_array_equal(again.course.path.length, second.plan.course.path.length)


def test_tracking_is_measured_against_the_clock() -> None:
    flight = fly(loads(HOP + SNAP))
    trajectory = flight.plan.course.trajectory
    assert trajectory is not None
    late = np.linalg.norm(flight.record.position - trajectory(flight.record.time - flight.record.time[0]), axis=1)
    assert flight.metrics.tracking_max_m == pytest.approx(late.max())
    assert flight.metrics.tracking_rms_m is not None
    assert 0 < flight.metrics.tracking_rms_m < late.max() < 0.05
    assert fly(loads(HOP)).metrics.tracking_rms_m is None


def test_a_certificate_says_what_holds() -> None:
    mission = loads(HOP + "planner: {kind: minimum_snap}\nworld: {bounds: [[-5, -5, 0], [10, 10, 20]]}\n")
    found = certified(mission, mission.build())
    assert found.broken == []
    assert remarks(found) == []
    lines = {line.quantity: line for line in found.lines}
    assert lines["largest speed"].limit == 3
    assert lines["largest speed"].value <= 3
    assert lines["largest deviation from the route"].limit == mission.tolerance
    assert "least clearance" not in lines
    document = json.loads(json.dumps(found.document(), allow_nan=False))
    assert document["holds"] is True
    assert document["duration_s"] == found.trajectory.duration


def test_a_certificate_says_what_is_broken(tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(to_json(CURVE))
    wall = "shapes: [{box: {min: [3, -1, 0], max: [3.2, 1, 9]}}]"
    low = "bounds: [[-5, -5, 0], [10, 4, 20]]"
    text = HOP.replace("speed: 3", "speed: 1") + "planner: {kind: file, file: t.json}\n"
    mission = loads(text, tmp_path)
    found = certified(mission, mission.build())
    assert [line.quantity for line in found.broken] == ["largest speed"]
    (remark,) = remarks(found)
    assert remark.startswith("the trajectory's largest speed is 2.")
    assert "m/s, above 1 m/s, after " in remark
    walled = loads(text + "world: {" + wall + "}", tmp_path)
    found = certified(walled, walled.build())
    assert [line.quantity for line in found.broken] == ["largest speed", "least clearance"]
    assert found.lines[-2].value < 0
    with pytest.raises(InputError, match=r"outside world\.bounds"):
        loads(text + "world: {" + low + "}", tmp_path)
