"""What is recorded of a served session, against what its client knows, and against geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenery import call, simulated
from scipy.spatial.transform import Rotation
from served_flown import PATH, SECOND_START, WALL, flown

from crosstrack import frames
from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.structs import YawMode
from crosstrack.flight import served, served_calls
from crosstrack.flight.served import PERIOD, Recorder
from crosstrack.flight.served_calls import Call, Calls, Touches, clean, described
from crosstrack.flight.served_markers import axes
from crosstrack.flight.served_track import COLUMNS, Rows, Track
from crosstrack.types import Array
from crosstrack.world.world import World


def at(track: Track, time: float) -> Array:
    """Return where a vehicle was at a time (s)."""
    return np.array([np.interp(time, track.time, axis) for axis in track.position.T])


def named(name: str, vehicle: str = "") -> list[Call]:
    """Return the calls of a name."""
    return [one for one in flown().session.calls if one.name == name and vehicle in one.vehicle]


def test_the_track_is_where_the_client_saw_the_vehicle() -> None:
    known, session = flown(), flown().session
    track, path = session.tracks["One"], named("moveOnPath")[-1]
    seen = frames.enu_from_ned(known.moved.kinematics_estimated.position)
    np.testing.assert_allclose(at(track, path.ends), seen, atol=0.02)
    assert known.moved.timestamp * 1e-9 == pytest.approx(path.ends, abs=0.03)
    legs = [np.linalg.norm(track.position - frames.enu_from_ned(corner), axis=1).min() for corner in PATH]
    assert max(legs) < 1.5


def test_each_vehicle_begins_at_its_own_start() -> None:
    north, east = SECOND_START
    np.testing.assert_allclose(flown().session.tracks["Two"].position[0], [east, north, 0.0], atol=0.01)
    np.testing.assert_allclose(flown().session.tracks["One"].position[0], [0.0, 0.0, 0.0], atol=0.01)


def test_moving_vehicles_are_sampled_20_times_a_second_of_simulated_time() -> None:
    track, path = flown().session.tracks["One"], named("moveOnPath")[-1]
    times = track.time[(track.time > path.begins) & (track.time < path.ends)]
    assert np.diff(times).max() < 0.05 + 0.022
    assert len(times) == pytest.approx((path.ends - path.begins) / (PERIOD * 1e-9), rel=0.03)


def test_velocity_is_the_derivative_of_position() -> None:
    track, path = flown().session.tracks["One"], named("moveOnPath")[-1]
    rows = np.flatnonzero((track.time > path.begins) & (track.time < path.ends))[1:-1]
    slope = (track.position[rows + 1] - track.position[rows - 1]) / (track.time[rows + 1] - track.time[rows - 1])[
        :, None
    ]
    np.testing.assert_allclose(slope, track.velocity[rows], atol=0.15)


def test_a_reset_is_a_jump_that_no_one_flew() -> None:
    session = flown().session
    (reset,) = named("reset")
    for track in session.tracks.values():
        (jump,) = track.jumps
        assert track.time[jump - 1] <= reset.begins <= track.time[jump] + 1e-9
        steps = np.linalg.norm(np.diff(track.position, axis=0), axis=1)
        assert track.length == pytest.approx(steps.sum() - steps[jump - 1])


def test_calls_are_listed_with_what_they_answered() -> None:
    known = flown()
    wrong, path = named("moveOnPath")
    assert wrong.answer
    assert wrong.answer in known.error
    assert path.answer == str(known.answers["path"]).lower()
    assert path.arguments.startswith("2 points, 3, ")
    (superseded,) = named("moveToPosition")
    by_velocity = named("moveByVelocity", "Two")[0]
    assert superseded.answer == str(known.answers["superseded"]).lower() == "false"
    assert superseded.ends == pytest.approx(by_velocity.begins)
    assert by_velocity.answer == str(known.answers["by velocity"]).lower() == "true"
    assert by_velocity.ends - by_velocity.begins == pytest.approx(5.0, abs=0.05)


def test_calls_that_follow_one_another_closely_are_one_stream() -> None:
    stream = named("moveByVelocity", "Two")[1]
    assert stream.count == 20
    assert stream.ends - stream.begins == pytest.approx(20 * 0.1, rel=0.3)
    assert [one.count for one in flown().session.calls if one is not stream] == [1] * (len(flown().session.calls) - 1)


def test_collisions_are_where_the_ball_of_the_vehicle_touches_the_wall() -> None:
    known, (first, *_) = flown(), flown().session.collisions
    assert (first.vehicle, first.thing) == ("Two", known.hit.object_name)
    assert World((WALL,)).distance(first.position) == pytest.approx(RADIUS, abs=2e-3)
    by_velocity = named("moveByVelocity", "Two")[0]
    assert by_velocity.begins < first.begins < by_velocity.ends
    np.testing.assert_allclose(at(flown().session.tracks["Two"], first.begins), first.position, atol=0.3)


def test_standing_on_the_ground_is_no_collision() -> None:
    session = flown().session
    assert {one.thing for one in session.collisions} == {"Box_1"}
    assert {one.thing for one in session.touches} == {"Box_1", "Ground"}


def test_nothing_calls_the_recorder_once_it_is_closed() -> None:
    simulator = simulated()
    recorder = Recorder(simulator)
    before = (len(simulator.watchers), len(simulator.resetters))
    recorder.close()
    after = (len(simulator.watchers), len(simulator.resetters))
    assert (before, after) == ((1, before[1]), (0, before[1] - 1))


@given(st.lists(st.integers(0, 2), min_size=1, max_size=40))
def test_what_stands_still_takes_no_room_and_loses_nothing(places: list[int]) -> None:
    rows, kept = Rows(), 0
    for index, place in enumerate(places):
        kept += len(rows.add(np.array([float(index), *[float(place)] * (COLUMNS - 1)])))
    track = rows.track()
    assert kept == rows.count <= len(track.time) <= kept + 1
    times = np.arange(len(places), dtype=float)
    np.testing.assert_array_equal([at(track, time)[0] for time in times], places)
    changes = np.count_nonzero(np.diff(places))
    assert len(track.time) <= 2 * (changes + 1)


def test_tracks_end_at_their_limit_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served, "MOST_ROWS", 12)
    simulator = simulated()
    recorder = Recorder(simulator)
    call(simulator, "enableApiControl", True, "")
    vehicle = simulator.vehicle("")
    vehicle.quadrotor.velocity[:] = 0.0, 0.0, -30.0
    vehicle.quadrotor["grounded"] = False
    simulator.idle(2.0)
    session = recorder.close()
    track = session.tracks[vehicle.name]
    assert len(track.time) == 12
    assert track.time[-1] < 1.0 < session.duration
    (note,) = session.notes
    assert "12 samples" in note


def test_calls_and_contacts_are_counted_beyond_their_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_calls, "MOST", 3)
    calls, touches = Calls(), Touches()
    for time in range(5):
        calls.begin("a", "hover", (), float(time))("true", time + 0.5)
        assert (touches.add("a", f"{time}", False, np.zeros(3), float(time)) is not None) is (time < 3)
    assert [one.ends for one in calls.made] == [0.5, 1.5, 2.5]
    assert (calls.passed, touches.passed) == (2, 2)


def test_a_contact_goes_on_until_it_is_left_alone() -> None:
    touches = Touches()
    for time in (0.0, 0.9, 1.8, 3.0):
        touches.add("a", "wall", False, np.array([time, 0.0, 0.0]), time)
    assert [(one.begins, one.ends, one.count) for one in touches.made] == [(0.0, 1.8, 3), (3.0, 3.0, 1)]
    assert touches.made[0].position[0] == 0.0


def test_an_error_ends_a_stream() -> None:
    calls = Calls()
    for number, answer in enumerate(["true", "no way", "true", "true"]):
        calls.begin("a", "moveToZ", (float(number),), 0.1 * number)(answer, 0.1 * number + 0.05)
    assert [(one.count, one.answer) for one in calls.made] == [(2, "no way"), (2, "true")]


@given(st.text(st.characters(), max_size=300))
def test_texts_of_clients_can_be_written_to_files(text: str) -> None:
    found = clean(text)
    assert len(found.encode()) >= len(found)
    assert "\0" not in found
    assert len(found) <= served_calls.LONGEST


def test_half_letters_are_replaced() -> None:
    assert clean("a\udc80b\0c") == "a?bc"
    assert described((1.5, True, np.zeros((4, 3)), YawMode(False, 90.0), 3e38)) == "1.5, true, 4 points, yaw 90 °, ∞"


@given(st.integers(0, 2**32 - 1))
def test_axes_of_transforms_are_turned_axes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns, points = Rotation.random(4, rng), rng.normal(size=(4, 3))
    pairs = axes(points, turns.as_quat(), 0.7).reshape(4, 3, 2, 3)
    np.testing.assert_array_equal(pairs[:, :, 0], np.repeat(points[:, None], 3, axis=1))
    ned = frames.ned_from_enu(pairs[:, :, 1] - pairs[:, :, 0]) / 0.7
    np.testing.assert_allclose(ned, np.swapaxes(turns.as_matrix(), 1, 2), atol=1e-12)
