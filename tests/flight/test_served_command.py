"""`crosstrack serve` ends as it should, whoever ends it, and leaves what it was asked for."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

from crosstrack.airsim.client.blocking import Client
from crosstrack.airsim.server.serve import warm_up
from crosstrack.errors import LinkLost

COMMAND = [sys.executable, "-m", "crosstrack", "serve", "--port", "0", "--lockstep"]
MISSION = "start: {position: [0, 0, 2]}\nroute: [[6, 0, 5]]\nworld: {shapes: [{box: {min: [1, 2, 0], max: [3, 4, 9]}}]}"


@contextmanager
def started(folder: Path, *flags: str) -> Iterator[tuple["subprocess.Popen[str]", int]]:
    """Start a server in a folder; it is killed where it does not end by itself."""
    warm_up()
    process = subprocess.Popen([*COMMAND, *flags], cwd=folder, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stderr is not None
        for line in process.stderr:
            if match := re.search(r"Serving AirSim's API at 127\.0\.0\.1:(\d+)", line):
                yield process, int(match[1])
                break
    finally:
        process.kill()
        process.communicate()


def fly(port: int) -> None:
    """Fly a little."""
    with Client("127.0.0.1", port) as client:
        client.enable_api_control(True)
        client.takeoff().join()
        client.move_by_velocity(1.0, 0.0, 0.0, 2.0).join()


def ended(process: "subprocess.Popen[str]", *signals: signal.Signals) -> tuple[int, str]:
    """Send signals; return the exit code and what was said after that."""
    for number in signals:
        process.send_signal(number)
    _, said = process.communicate(timeout=60)
    return process.returncode, said


def test_the_server_ends_when_told_and_leaves_a_log_and_a_report(tmp_path: Path) -> None:
    (tmp_path / "box.yaml").write_text(MISSION)
    with started(tmp_path, "--out", "left", "--world", "box.yaml") as (process, port):
        fly(port)
        code, said = ended(process, signal.SIGTERM)
    assert code == 0
    assert "Traceback" not in said
    assert "left/report.html" in said
    assert sorted(path.name for path in (tmp_path / "left").iterdir()) == ["report.html", "session.mcap"]
    page = (tmp_path / "left" / "report.html").read_text()
    assert "takeoff(20)" in page
    assert "moveByVelocity(1, 0, 0, 2" in page
    with (tmp_path / "left" / "session.mcap").open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert {"/moves", "/world", "/tf"} <= {channel.topic for channel in summary.channels.values()}


def test_a_client_in_mid_flight_is_told_and_nothing_is_written_unasked(tmp_path: Path) -> None:
    with started(tmp_path) as (process, port), Client("127.0.0.1", port) as client:
        client.enable_api_control(True)
        client.takeoff().join()
        client.pause(True)
        endless = client.move_by_velocity(1.0, 0.0, 0.0, 1e6)
        assert client.ping()
        assert ended(process, signal.SIGINT)[0] == 0
        with pytest.raises(LinkLost):
            endless.join()
    assert list(tmp_path.iterdir()) == []


def test_told_twice_it_ends_at_once(tmp_path: Path) -> None:
    with started(tmp_path, "--out", "left") as (process, port):
        fly(port)
        code, said = ended(process, signal.SIGINT, signal.SIGTERM)
    assert code == 130
    assert "Traceback" not in said
    assert not (tmp_path / "left" / "report.html").exists()


def test_a_killed_server_leaves_a_log_that_can_be_read(tmp_path: Path) -> None:
    with started(tmp_path, "--out", "left") as (process, port):
        fly(port)
        process.kill()
    names = set()
    with (tmp_path / "left" / "session.mcap").open("rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        for record in StreamReader(stream).records:
            names.add(getattr(record, "topic", ""))
            if stream.tell() == size:
                break
    assert {"/moves", "/world", "/tf"} <= names


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "left").write_text("")
    command = [*COMMAND, "--out", "left"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2
    assert "must be a folder, found a file" in done.stderr
    assert "Traceback" not in done.stderr
