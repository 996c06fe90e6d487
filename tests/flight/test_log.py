import io
import signal
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.records import ChunkIndex
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError
from crosstrack.flight.flight import Flight
from crosstrack.flight.log import LogWriter
from crosstrack.flight.observer import Sample
from crosstrack.flight.record import Record
from crosstrack.flight.recording import read_log
from crosstrack.types import Outcome

Messages = dict[str, list[Any]]


def samples(record: Record) -> Iterator[Sample]:
    columns = [getattr(record, field.name) for field in fields(Record)]
    for values in zip(*columns, strict=True):
        row: list[Any] = [value if np.ndim(value) else float(value) for value in values]
        yield Sample(*row)


def write(flight: Flight, path: Path) -> Path:
    writer = LogWriter(path)
    writer.begin(flight.plan)
    for row in samples(flight.record):
        writer.sample(row)
    writer.end(flight.outcome, flight.effort)
    return path


def same(one: Record, other: Record, count: int | None = None) -> bool:
    return all(
        getattr(one, field.name).tobytes() == getattr(other, field.name)[:count].tobytes() for field in fields(Record)
    )


@pytest.fixture
def log(flight: Flight, tmp_path: Path) -> Path:
    return write(flight, tmp_path / "flight.mcap")


@pytest.fixture
def decoded(log: Path) -> Messages:
    """All messages by topic, as the library of the ROS 2 project reads them."""
    found: Messages = {}
    with log.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, content in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message, content))
    return found


def xyz(value: Any) -> list[float]:
    return [value.x, value.y, value.z]


def xyzw(value: Any) -> list[float]:
    return [*xyz(value), value.w]


def column(messages: Messages, topic: str, pick: Callable[[Any], Any]) -> Any:
    return np.array([pick(content) for _, content in messages[topic]])


def test_reading_returns_what_was_flown_bit_for_bit(flight: Flight, log: Path) -> None:
    read = read_log(log)
    assert same(read.record, flight.record)
    assert read.document == flight.plan.document
    assert read.files == flight.plan.files
    assert (read.outcome, read.effort) == (flight.outcome, flight.effort)


@pytest.mark.parametrize("rotors", [0, 1, 6])
def test_any_number_of_rotors(fly_along: Callable[..., Flight], tmp_path: Path, rotors: int) -> None:
    time = np.cumsum(np.random.default_rng(rotors).uniform(0.01, 0.03, 90))
    position = np.column_stack([time, np.zeros(90), np.full(90, 3.0)])
    route = [[0, 0, 3], [5, 0, 3]]
    flight = fly_along(route, time, position, time, rotors=rotors, clearance=np.inf)
    assert same(read_log(write(flight, tmp_path / "a.mcap")).record, flight.record)


def test_numbers_that_are_not_finite_come_back(flight: Flight, tmp_path: Path) -> None:
    position = flight.record.position.copy()
    position[-1] = [np.nan, np.inf, -np.inf]
    lost = replace(flight, record=replace(flight.record, position=position), outcome=Outcome.LOST_CONTROL)
    read = read_log(write(lost, tmp_path / "a.mcap"))
    assert same(read.record, lost.record)
    assert read.outcome is Outcome.LOST_CONTROL


def test_an_independent_decoder_reads_the_motion(flight: Flight, decoded: Messages) -> None:
    record = flight.record
    pose = column(decoded, "/vehicle/odometry", lambda m: xyz(m.pose.pose.position))
    np.testing.assert_array_equal(pose, record.position)
    quaternion = column(
        decoded, "/vehicle/odometry", lambda m: [*xyz(m.pose.pose.orientation), m.pose.pose.orientation.w]
    )
    np.testing.assert_array_equal(quaternion, record.attitude)
    in_body = column(decoded, "/vehicle/odometry", lambda m: xyz(m.twist.twist.linear))
    expected = Rotation.from_quat(record.attitude).inv().apply(record.velocity)
    np.testing.assert_allclose(in_body, expected, atol=1e-12)
    rate = column(decoded, "/vehicle/odometry", lambda m: xyz(m.twist.twist.angular))
    np.testing.assert_array_equal(rate, record.rate)
    velocity = column(decoded, "/vehicle/velocity", lambda m: xyz(m.vector))
    np.testing.assert_array_equal(velocity, record.velocity)
    estimate = column(decoded, "/vehicle/estimate", lambda m: xyz(m.point))
    np.testing.assert_array_equal(estimate, record.estimate)


def test_an_independent_decoder_reads_the_rest(flight: Flight, decoded: Messages) -> None:
    record = flight.record
    transforms = column(decoded, "/tf", lambda m: xyz(m.transforms[0].transform.translation))
    np.testing.assert_array_equal(transforms, record.position)
    speeds = column(decoded, "/vehicle/rotors", lambda m: m.velocity)
    np.testing.assert_array_equal(speeds, record.rotor_speeds)
    assert decoded["/vehicle/rotors"][0][1].name == ["rotor_1", "rotor_2", "rotor_3", "rotor_4"]
    asked = column(decoded, "/command/velocity", lambda m: xyz(m.twist.linear))
    np.testing.assert_array_equal(asked, record.command_velocity)
    asked = column(decoded, "/command/acceleration", lambda m: xyz(m.accel.linear))
    np.testing.assert_array_equal(asked, record.command_acceleration)
    asked = column(decoded, "/command/rate", lambda m: xyz(m.vector))
    np.testing.assert_array_equal(asked, record.command_rate)
    asked = column(decoded, "/command/attitude", lambda m: [*xyz(m.quaternion), m.quaternion.w])
    np.testing.assert_array_equal(asked, record.command_attitude)
    np.testing.assert_array_equal(column(decoded, "/command/thrust", lambda m: m.data), record.command_thrust)
    np.testing.assert_array_equal(column(decoded, "/tracker/aim", lambda m: xyz(m.point)), record.aim)
    np.testing.assert_array_equal(column(decoded, "/wind", lambda m: xyz(m.vector)), record.wind)
    for name, values in {"progress": record.progress, "clearance": record.clearance, "time": record.time}.items():
        topic = f"/tracker/{name}" if name == "progress" else f"/{name}"
        np.testing.assert_array_equal(column(decoded, topic, lambda m: m.data), values)


def test_stamps_are_the_time_of_the_sample(flight: Flight, decoded: Messages) -> None:
    for message, content in decoded["/vehicle/odometry"]:
        assert message.log_time == content.header.stamp.sec * 10**9 + content.header.stamp.nanosec
        assert message.publish_time == message.log_time
    logged = np.array([message.log_time for message, _ in decoded["/time"]]) * 1e-9
    np.testing.assert_allclose(logged, flight.record.time, atol=1e-9)
    assert [message.sequence for message, _ in decoded["/time"]] == list(range(len(flight.record.time)))
    assert {content.header.frame_id for _, content in decoded["/vehicle/odometry"]} == {"world"}


def test_the_scene_is_logged_once(flight: Flight, decoded: Messages) -> None:
    ((_, route),) = decoded["/route"]
    points = np.array([xyz(pose.pose.position) for pose in route.poses])
    np.testing.assert_allclose(points[[0, -1]], flight.plan.route(np.array([0.0, flight.plan.route.length])))
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.11
    assert len(decoded["/course"]) == 1
    ((_, world),) = decoded["/world"]
    (marker,) = world.markers
    scenario: Any = flight.plan.scenario
    ((name, vertices, triangles),) = scenario.world.meshes()
    assert (marker.ns, marker.type) == (name, 11)
    np.testing.assert_array_equal([xyz(point) for point in marker.points], vertices[triangles].reshape(-1, 3))


def test_the_index_counts_and_finds_every_message(flight: Flight, log: Path) -> None:
    count = len(flight.record.time)
    with log.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    topics = {channel.topic: number for number, channel in summary.channels.items()}
    counts = summary.statistics.channel_message_counts
    assert {counts[topics[name]] for name in ("/route", "/course", "/world")} == {1}
    assert {counts[number] for name, number in topics.items() if name not in ("/route", "/course", "/world")} == {count}
    assert summary.statistics.message_count == sum(counts.values()) == 17 * count + 3
    assert summary.statistics.message_end_time == round(flight.record.time[-1] * 1e9)
    data = log.read_bytes()
    assert sum(indexed(data, chunk) for chunk in summary.chunk_indexes) == summary.statistics.message_count


def indexed(data: bytes, chunk: ChunkIndex) -> int:
    """Follow every entry of a chunk's message index to its message; return how many there are."""
    at = chunk.chunk_start_offset + 9 + 8 + 8 + 8 + 4 + 4 + len(chunk.compression) + 8
    unpacked = zstandard.decompress(data[at : at + chunk.compressed_size])
    found = 0
    for channel, offset in chunk.message_index_offsets.items():
        opcode, _, number, size = struct.unpack_from("<BQHI", data, offset)
        assert (opcode, number) == (7, channel)
        for stamp, place in struct.iter_unpack("<QQ", data[offset + 15 : offset + 15 + size]):
            kind, _, owner, _, logged = struct.unpack_from("<BQHIQ", unpacked, place)
            assert (kind, owner, logged) == (5, channel, stamp)
            found += 1
    return found


def test_a_second_is_on_the_disk_before_the_next_ends(flight: Flight, tmp_path: Path) -> None:
    writer = LogWriter(tmp_path / "a.mcap")
    writer.begin(flight.plan)
    for row in samples(flight.record):
        writer.sample(row)
        if round(50 * row.time) % 17 == 0:
            assert read_log(writer.path).record.time[-1] >= row.time - 1.0
    writer.end(flight.outcome, flight.effort)


def test_a_log_cut_anywhere_holds_the_flight_up_to_there(flight: Flight, log: Path, tmp_path: Path) -> None:
    data, cut = log.read_bytes(), tmp_path / "cut.mcap"
    lengths = set()
    for size in np.random.default_rng(5).integers(0, len(data) - 1, 30):
        cut.write_bytes(data[:size])
        try:
            read = read_log(cut)
        except InputError:
            lengths.add(0)
            continue
        assert same(read.record, flight.record, len(read.record.time))
        lengths.add(len(read.record.time))
    assert len(lengths) > 5


def test_a_damaged_log_is_never_read_wrongly(flight: Flight, log: Path, tmp_path: Path) -> None:
    data, damaged = log.read_bytes(), tmp_path / "damaged.mcap"
    refused = 0
    for place in np.random.default_rng(6).integers(0, len(data), 30):
        damaged.write_bytes(data[:place] + bytes([data[place] ^ 0x55]) + data[place + 1 :])
        try:
            read = read_log(damaged)
        except InputError:
            refused += 1
            continue
        assert same(read.record, flight.record)
        assert (read.document, read.files) == (flight.plan.document, flight.plan.files)
    assert refused > 15


@pytest.mark.parametrize("content", [b"", b"name: square\n", b"\x89MCAP0\r\n", bytes(4096)])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"other\.mcap"):
        read_log(path)


def test_a_log_of_something_else_is_refused(tmp_path: Path) -> None:
    stream = io.BytesIO()
    writer: Any = Writer(stream)
    writer.start()
    channel = writer.register_channel("/other", "json", 0)
    writer.add_message(channel, 0, b"{}", 0)
    writer.finish()
    path = tmp_path / "other.mcap"
    path.write_bytes(stream.getvalue())
    with pytest.raises(InputError, match="no mission"):
        read_log(path)


def test_a_chunk_that_claims_too_much_is_not_unpacked(tmp_path: Path) -> None:
    bomb = zstandard.compress(bytes(1 << 29))
    body = struct.pack("<QQQII", 0, 0, 1 << 29, zlib.crc32(b""), 4) + b"zstd" + struct.pack("<Q", len(bomb)) + bomb
    path = tmp_path / "bomb.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body)
    with pytest.raises(InputError, match="at most"):
        read_log(path)


WRITE_FOR_EVER = """
import runpy, sys, time
from dataclasses import replace
from pathlib import Path
here = runpy.run_path(sys.argv[1])
make = runpy.run_path(sys.argv[2])["make_flight"]
flight = make()
writer = here["LogWriter"](Path(sys.argv[3]))
writer.begin(flight.plan)
rows = list(here["samples"](flight.record))
lap = 0
while True:
    for row in rows:
        writer.sample(replace(row, time=row.time + lap * (rows[-1].time + 0.02)))
    lap += 1
    print(lap, flush=True)
"""


def test_a_killed_process_leaves_a_log_to_read(flight: Flight, tmp_path: Path) -> None:
    path, root = tmp_path / "killed.mcap", Path(__file__).parents[1]
    arguments = [sys.executable, "-c", WRITE_FOR_EVER, __file__, str(root / "conftest.py"), str(path)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"1\n"
        process.send_signal(signal.SIGKILL)
    read = read_log(path)
    assert read.outcome is None
    count = len(flight.record.time)
    assert len(read.record.time) >= count - 51
    np.testing.assert_array_equal(read.record.position[: count - 51], flight.record.position[: count - 51])
