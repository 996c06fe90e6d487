"""What the log says now and then: points seen, and courses planned again."""

from pathlib import Path

import numpy as np
import pytest
from conftest import make_flight
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from crosstrack.flight.events import REPLANNED, SEEN, decoded, encoded
from crosstrack.flight.flight import flight_of, thinned
from crosstrack.flight.log import LogWriter
from crosstrack.flight.observer import Sample
from crosstrack.flight.recording import read_log

RNG = np.random.default_rng(1)
POINTS = RNG.normal(size=(7, 3)).round(2)


@pytest.mark.parametrize("topic", [SEEN, REPLANNED])
@pytest.mark.parametrize("count", [0, 1, 7])
def test_there_and_back(topic: str, count: int) -> None:
    time, points = decoded(topic, encoded(topic, 12.25, POINTS[:count]))
    assert time == 12.25
    np.testing.assert_allclose(points, POINTS[:count], atol=1e-6)


@pytest.mark.parametrize("topic", [SEEN, REPLANNED])
def test_damaged_messages_are_refused(topic: str) -> None:
    data = encoded(topic, 1.0, POINTS)
    for size in range(0, len(data), 5):
        with pytest.raises(ValueError, match=topic):
            decoded(topic, data[:size])


def test_the_log_keeps_them_and_ros_reads_them(tmp_path: Path) -> None:
    flight = make_flight(duration=3.0)
    names = list(vars(flight.record))
    rows = [Sample(**{name: getattr(flight.record, name)[k] for name in names}) for k in range(len(flight.record.time))]
    for k in (10, 60, 110):
        object.__setattr__(rows[k], "seen", POINTS + k)
    object.__setattr__(rows[60], "course", POINTS)
    writer = LogWriter(tmp_path / "flight.mcap")
    writer.begin(flight.plan)
    for row in rows:
        writer.sample(row)
    writer.end(flight.outcome, flight.effort)

    read, whole = read_log(writer.path), flight_of(flight.plan, flight.outcome, rows, flight.effort)
    np.testing.assert_allclose(read.seen, whole.seen, atol=1e-5)
    assert [replan.time for replan in read.replans] == [rows[60].time]
    np.testing.assert_array_equal(read.replans[0].points, whole.replans[0].points)
    with writer.path.open("rb") as stream:
        messages = list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages([SEEN]))
    assert [round(message.log_time / 1e9, 6) for _, _, message, _ in messages] == [0.2, 1.2, 2.2]
    cloud = messages[0][3]
    assert [(field.name, field.offset) for field in cloud.fields] == [("x", 0), ("y", 4), ("z", 8)]
    seen = np.frombuffer(bytes(cloud.data), np.float32).reshape(cloud.width, 3)
    np.testing.assert_allclose(seen, POINTS + 10, atol=1e-5)


def test_one_point_of_every_cube_is_kept() -> None:
    cloud = RNG.uniform(0, 1, size=(5000, 3))
    kept = thinned([cloud[:2000], cloud[2000:]])
    assert len(kept) == len(np.unique(np.floor(kept / 0.1), axis=0)) == 1000 - (1000 - len(kept))
    assert len(kept) > 980
    assert thinned([]).shape == (0, 3)
