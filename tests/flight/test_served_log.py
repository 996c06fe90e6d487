"""The log of a served session, as the libraries of others read it; whole, cut off, and at its limit."""

import io
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader
from mcap_ros2.decoder import DecoderFactory
from scenery import at, call, simulated
from scipy.spatial.transform import Rotation
from served_flown import PATH, RED, SEEN_FOR, TURN, flown

from crosstrack import frames
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.flight import served_log
from crosstrack.flight.served import Recorder
from crosstrack.flight.served_log import COLLISIONS, MARKERS, MOVES, OBJECTS

Messages = dict[str, list[tuple[int, Any]]]
LINES, POINTS, ARROW, TEXT = 5, 8, 0, 9


def decoded(path: Path) -> Messages:
    """Return time (ns) and content of all messages by topic, as the library of the ROS 2 project reads them."""
    found: Messages = {}
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, content))
    return found


def texts(messages: Messages, topic: str) -> list[dict[str, Any]]:
    """Return the contents of a topic of JSON."""
    return [json.loads(content.data) for _, content in messages[topic]]


def xyz(value: Any) -> list[float]:
    return [value.x, value.y, value.z]


@pytest.fixture(scope="module")
def messages() -> Messages:
    return decoded(flown().log)


def test_the_log_holds_the_tracks_bit_for_bit(messages: Messages) -> None:
    for name, track in flown().session.tracks.items():
        written = messages[f"/{name}/odometry"]
        rows = len(written)
        np.testing.assert_array_equal([xyz(one.pose.pose.position) for _, one in written], track.position[:rows])
        np.testing.assert_allclose([stamp * 1e-9 for stamp, _ in written], track.time[:rows], atol=1e-9)
        turns = Rotation.from_quat(track.attitude[:rows])
        body = [xyz(one.twist.twist.linear) for _, one in written]
        np.testing.assert_allclose(body, turns.inv().apply(track.velocity[:rows]), atol=1e-9)
        assert rows >= len(track.time) - 1
        assert {one.child_frame_id for _, one in written} == {name}
    seen = [one.transforms[0].child_frame_id for _, one in messages["/tf"]]
    assert set(seen) == set(flown().session.tracks)


def test_the_log_holds_the_moves_and_their_answers(messages: Messages) -> None:
    told, calls = texts(messages, MOVES), flown().session.calls
    assert len(told) == sum(one.count for one in calls)
    (path,) = [one for one in told if one["name"] == "moveOnPath" and one["answer"] in ("true", "false")]
    assert path["answer"] == str(flown().answers["path"]).lower()
    assert {one["vehicle"] for one in told} == {"", "One", "Two"}
    assert [one["ends_s"] for one in told] == sorted(one["ends_s"] for one in told)


def test_the_log_holds_the_collisions(messages: Messages) -> None:
    told, touches = texts(messages, COLLISIONS), flown().session.touches
    assert [(one["vehicle"], one["object"]) for one in told] == [(one.vehicle, one.thing) for one in touches]
    np.testing.assert_allclose([one["position_m"] for one in told], [one.position for one in touches], atol=1e-4)


def test_the_log_holds_what_was_drawn(messages: Messages) -> None:
    drawn = [marker for _, array in messages[MARKERS] for marker in array.markers]
    assert [marker.type for marker in drawn] == [POINTS, LINES, ARROW, TEXT, LINES]
    assert len({marker.id for marker in drawn}) == len(drawn)
    points, lines, arrow, text, transforms = drawn
    corners = frames.enu_from_ned(PATH)
    for marker in (points, lines, arrow):
        np.testing.assert_allclose([xyz(point) for point in marker.points], corners, atol=1e-5)
    assert (points.color.r, points.color.g, points.color.b, points.color.a) == RED
    assert points.lifetime.sec + points.lifetime.nanosec * 1e-9 == pytest.approx(SEEN_FOR)
    assert (lines.lifetime.sec, lines.lifetime.nanosec) == (0, 0)
    assert lines.color.a == 0.5
    assert text.text == "<b>here</b>"
    np.testing.assert_allclose(xyz(text.pose.position), corners[1], atol=1e-5)
    ends = np.array([xyz(point) for point in transforms.points]).reshape(3, 2, 3)
    north = frames.enu_from_ned(Rotation.from_quat(TURN).apply([1.0, 0.0, 0.0]))
    np.testing.assert_allclose(ends[0, 1] - ends[0, 0], north, atol=1e-5)
    assert [(color.r, color.g, color.b) for color in transforms.colors[::2]] == [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


def test_the_log_holds_the_objects_once_where_they_stay(messages: Messages) -> None:
    ((_, world),) = messages[OBJECTS]
    corners = np.array([xyz(point) for marker in world.markers for point in marker.points])
    np.testing.assert_array_equal([corners.min(axis=0), corners.max(axis=0)], [[-20, 20, 0], [20, 21, 10]])


def spawned(simulator: Simulator) -> None:
    """Let a client put something into the world."""
    call(simulator, "simSpawnObject", "new", "Cube", at(5, 0, -1), np.ones(3), False, False)


def test_objects_that_change_are_written_again(tmp_path: Path) -> None:
    simulator = simulated()
    recorder = Recorder(simulator, tmp_path / "a.mcap")
    simulator.idle(0.5)
    spawned(simulator)
    simulator.idle(25.0)
    recorder.close()
    counts = [len(array.markers) for _, array in decoded(tmp_path / "a.mcap")[OBJECTS]]
    assert counts == [0, 1]


def streamed(data: bytes) -> int:
    """Return how many messages can be read of a log that may be cut off."""
    count = 0
    try:
        for record in StreamReader(io.BytesIO(data), emit_chunks=False).records:
            assert not isinstance(record, Chunk)
            count += isinstance(record, Message)
    except (McapError, EOFError, struct.error):
        pass
    return count


def test_a_log_can_be_read_wherever_it_was_cut_off() -> None:
    whole, unfinished = streamed(flown().log.read_bytes()), flown().unfinished
    assert streamed(unfinished) > 0.9 * whole
    rng = np.random.default_rng(1)
    counts = [streamed(unfinished[:cut]) for cut in sorted(rng.integers(100, len(unfinished), 5))]
    assert counts == sorted(counts)
    assert 0 < counts[-1] < whole


def test_a_log_ends_at_its_limit_and_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(served_log, "LARGEST", 20_000)
    simulator = simulated()
    recorder = Recorder(simulator, tmp_path / "a.mcap")
    call(simulator, "enableApiControl", True, "")
    vehicle = simulator.vehicle("")
    for _ in range(20):
        vehicle.quadrotor.velocity[:] = 1.0, 0.0, -10.0
        vehicle.quadrotor["grounded"] = False
        simulator.idle(1.0)
    session = recorder.close()
    (note,) = session.notes
    assert "The log ends early" in note
    messages = decoded(tmp_path / "a.mcap")
    (name,) = session.tracks
    rows = len(messages[f"/{name}/odometry"])
    assert 0 < rows < len(session.tracks[name].time) / 2


def test_a_full_disk_ends_the_log_and_not_the_flight(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    simulator = simulated()
    recorder = Recorder(simulator, tmp_path / "a.mcap")
    assert recorder.log is not None

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recorder.log._file, "chunk", full)
    call(simulator, "simPlotPoints", np.ones((2, 3)), np.ones(4, np.float32), 5.0, 1.0, False)
    simulator.idle(3.0)
    session = recorder.close()
    assert session.duration == pytest.approx(3.0, abs=0.03)
    assert session.notes == ("The log ends early: No space left on device.",)
