"""Recordings: a table and pictures in a folder of their own, as often as the settings say."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scenery import at, call, put, simulated

from crosstrack.airsim.scene.files import inside
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers.recording import prepare
from crosstrack.airsim.server.simulator import Simulator


def recording(folder: Path, **more: object) -> str:
    """Return settings that record into a folder."""
    vehicles = {name: {"VehicleType": "SimpleFlight", "X": x} for name, x in (("A", 0), ("B", 5))}
    return json.dumps({"Recording": {"Folder": str(folder), **more}, "Vehicles": vehicles})


def table(folder: Path) -> list[list[str]]:
    """Return the lines of the table of the only recording."""
    (found,) = folder.glob("*/airsim_rec.txt")
    return [line.split("\t") for line in found.read_text().splitlines()]


def recorded(simulator: Simulator, seconds: float) -> None:
    """Record for a time."""
    call(simulator, "startRecording")
    assert call(simulator, "isRecording")
    simulator.idle(seconds)
    call(simulator, "stopRecording")
    assert not call(simulator, "isRecording")


def test_a_recording(tmp_path: Path) -> None:
    simulator = simulated(settings=recording(tmp_path, RecordInterval=0.2))
    put(simulator, at(1, 2, -3), "A")
    simulator.vehicle("A").quadrotor["grounded"] = True
    recorded(simulator, 1.0)
    simulator.idle(1.0)
    lines = table(tmp_path)
    assert "\t".join(lines[0]) == "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile"
    assert [line[0] for line in lines[1:]] == ["A", "B"] * 5
    times = np.array([int(line[1]) for line in lines[1::2]])
    assert np.diff(times).tolist() == [210] * 4
    assert [float(part) for part in lines[1][2:9]] == pytest.approx([1, 2, -3, 1, 0, 0, 0])
    for line in lines[1:]:
        (found,) = tmp_path.glob(f"*/images/{line[9]}")
        with Image.open(found) as picture:
            assert picture.size == (256, 144)
    assert len(list(tmp_path.glob("*/images/*"))) == 10


def test_only_what_moves(tmp_path: Path) -> None:
    simulator = simulated(settings=recording(tmp_path, RecordOnMove=True))
    simulator.vehicle("A").quadrotor["grounded"] = True
    simulator.vehicle("B").quadrotor["grounded"] = True
    call(simulator, "startRecording")
    simulator.idle(0.3)
    put(simulator, at(7, 0, 0), "B")
    simulator.vehicle("B").quadrotor["grounded"] = True
    simulator.idle(0.3)
    call(simulator, "stopRecording")
    assert [line[0] for line in table(tmp_path)[1:]] == ["A", "B", "B"]


def test_pictures_of_all_kinds_of_files(tmp_path: Path) -> None:
    cameras = [
        {"CameraName": "0", "ImageType": 1, "PixelsAsFloat": True, "VehicleName": "B"},
        {"CameraName": "bottom_center", "ImageType": 5, "Compress": False, "VehicleName": "B"},
    ]
    simulator = simulated(settings=recording(tmp_path, RecordInterval=10, Cameras=cameras))
    recorded(simulator, 0.1)
    lines = table(tmp_path)
    assert [len(line[9].split(";")) if len(line) > 9 and line[9] else 0 for line in lines[1:]] == [0, 2]
    depth, numbers = (next(tmp_path.glob(f"*/images/{name}")) for name in lines[2][9].split(";"))
    head, size, scale, data = depth.read_bytes().split(b"\n", 3)
    assert (head, size, float(scale)) == (b"Pf", b"256 144", -1.0)
    values = np.frombuffer(data, "<f4").reshape(144, 256)[::-1]  # its rows go up
    assert values[0, 0] > 1000 > values[-1, 0]
    with Image.open(numbers) as picture:
        assert (picture.format, picture.size) == ("PPM", (256, 144))


def test_every_recording_has_its_folder(tmp_path: Path) -> None:
    simulator = simulated(settings=recording(tmp_path))
    for _ in range(3):
        recorded(simulator, 0.05)
    call(simulator, "startRecording")
    call(simulator, "startRecording")
    call(simulator, "stopRecording")
    call(simulator, "stopRecording")
    assert len(list(tmp_path.iterdir())) == 5


def test_recording_from_the_start_on(tmp_path: Path) -> None:
    simulator = simulated(settings=recording(tmp_path, Enabled=True))
    prepare(simulator)
    assert call(simulator, "isRecording")
    call(simulator, "stopRecording")


def test_what_cannot_be_recorded_is_refused(tmp_path: Path) -> None:
    simulator = simulated(settings=recording(tmp_path, Cameras=[{"CameraName": "none"}]))
    with pytest.raises(Refused):
        call(simulator, "startRecording")
    (tmp_path / "file").write_text("")
    simulator = simulated(settings=recording(tmp_path / "file"))
    with pytest.raises(Refused, match="no recording"):
        call(simulator, "startRecording")
    assert not call(simulator, "isRecording")


def test_names_of_files_stay_in_the_folder(tmp_path: Path) -> None:
    evil = "../../evil"
    text = json.dumps(
        {"Recording": {"Folder": str(tmp_path / "in")}, "Vehicles": {evil: {"VehicleType": "SimpleFlight"}}}
    )
    recorded(simulated(settings=text), 0.05)
    assert [one.name for one in tmp_path.iterdir()] == ["in"]


def test_where_clients_may_write(tmp_path: Path) -> None:
    home, other, out = tmp_path / "home", tmp_path / "other", tmp_path / "out"
    for folder in (home, other, out):
        folder.mkdir()
    (home / "link").symlink_to(out)
    (home / "folder.binvox").mkdir()
    allowed = (home, other)
    assert inside("a.binvox", allowed, ".binvox") == (home / "a.binvox").resolve()
    assert inside(str(other / "sub" / "a.BINVOX"), allowed, ".binvox") is not None
    bad = (
        "../a.binvox",
        str(out / "a.binvox"),
        "link/a.binvox",
        "a.py",
        "a",
        "",
        "folder.binvox",
        "a\0.binvox",
        "home/../.binvox",
    )
    for name in bad:
        assert inside(name, allowed, ".binvox") is None, name
