"""The command: what it prints where, what it leaves behind, and how it exits."""

import errno
import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from crosstrack import __version__
from crosstrack.cli.app import run
from crosstrack.errors import LinkLost
from crosstrack.flight.chunks import ChunkWriter
from crosstrack.mission import load
from crosstrack.vehicles.quadrotor import QuadrotorSession

HOP = "start: {position: [0, 0, 5]}\nroute: [[4, 0, 5], [4, 4, 5]]\nspeed: 3\n"
KEYS = {
    "outcome", "outcome_text", "arrived", "collided", "flight_time_s", "cross_track_rms_m", "cross_track_max_m",
    "cross_track_rms_captured_m", "cross_track_max_captured_m", "final_error_m", "final_speed_mps",
    "min_clearance_m", "path_length_m", "flown_length_m", "max_speed_mps", "mean_speed_mps", "min_separation_m",
    "replans", "safety_interventions", "planning_time_s", "decision_time_s", "decision_time_p99_s", "wall_time_s",
}  # fmt: skip
FILES = ("summary.json", "flight.mcap", "report.html")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder with one short mission."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hop.yaml").write_text(HOP)
    return tmp_path


def command(*arguments: str, cwd: Path, **more: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "crosstrack", *arguments],
        cwd=cwd, capture_output=True, text=True, check=False, timeout=120, **more,
    )  # fmt: skip


def test_fly_writes_summary_log_and_report_and_prints_the_summary_alone(folder: Path) -> None:
    done = command("fly", "hop.yaml", "--json", cwd=folder)
    assert done.returncode == 0
    summary = json.loads(done.stdout)
    assert set(summary) >= KEYS
    assert summary["outcome"] == "arrived"
    assert summary["path_length_m"] == pytest.approx(8)
    assert summary == json.loads((folder / "runs/hop/summary.json").read_text())
    assert all((folder / "runs/hop" / name).stat().st_size for name in FILES)
    assert "Getting ready" in done.stderr
    assert "Flying hop: " in done.stderr
    assert "Arrived at the last waypoint." in done.stderr


def test_without_json_the_outcome_and_the_report_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", "hop.yaml", "--out", "here", "--set", "speed=2", "--vehicle", "point"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Arrived at the last waypoint.\n")
    assert "Report: here/report.html" in out
    assert json.loads((folder / "here/summary.json").read_text())["mean_speed_mps"] == pytest.approx(2, abs=0.01)


@pytest.mark.parametrize(
    ("more", "code", "outcome"),
    [
        ("timing: {timeout: 1}\n", 3, "timed_out"),
        ("world: {bounds: [[-1, -1, 0], [5, 5, 9]]}\nwind: {mean: [0, -60, 0]}\n", 3, "left_bounds"),
        ("world: {shapes: [{box: {min: [2, -1, 0], max: [2.1, 1, 9]}}]}\n", 4, "collided"),
    ],
)
def test_flights_that_fail_leave_everything_behind(
    folder: Path, capsys: pytest.CaptureFixture[str], more: str, code: int, outcome: str
) -> None:
    (folder / "bad.yaml").write_text(HOP + more)
    assert run(["fly", "bad.yaml", "--json"]) == code
    captured = capsys.readouterr()
    assert json.loads(captured.out)["outcome"] == outcome
    assert all((folder / "runs/bad" / name).stat().st_size for name in FILES)
    if code == 4:
        assert "note: the leg from (0, 0, 5) to (4, 0, 5) goes through an obstacle" in captured.err


def test_a_lost_link_exits_5(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    advance, calls = QuadrotorSession.advance, iter(range(10))

    def failing(self: QuadrotorSession, wanted: Any, duration: float) -> None:
        if next(calls, None) is None:
            raise LinkLost("no answer for 1 s")
        advance(self, wanted, duration)

    monkeypatch.setattr(QuadrotorSession, "advance", failing)
    assert run(["fly", "hop.yaml", "--json"]) == 5
    assert json.loads((folder / "runs/hop/summary.json").read_text())["outcome"] == "link_lost"
    assert (folder / "runs/hop/report.html").exists()


@pytest.mark.parametrize("signals", [1, 2])
def test_ctrl_c_ends_the_flight_with_log_and_report(folder: Path, signals: int) -> None:
    (folder / "long.yaml").write_text(
        "start: {position: [0, 0, 5]}\nroute: [[90000, 0, 5]]\nspeed: 1\ntiming: {rate: 50, timeout: 100000}\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "crosstrack", "fly", "long.yaml", "--json"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("Flying"):
            break
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    if signals == 2:
        process.send_signal(signal.SIGINT)
        time.sleep(0.05)
        process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in err
    if signals == 1:
        assert json.loads(out)["outcome"] == "interrupted"
        assert all((folder / "runs/long" / name).stat().st_size for name in FILES)


def test_in_a_terminal_a_bar_shows_the_progress(folder: Path) -> None:
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "crosstrack", "fly", "hop.yaml", "--json"],
        cwd=folder, stdout=subprocess.PIPE, stderr=theirs, text=True, env={**os.environ, "TERM": "xterm"},
    )  # fmt: skip
    os.close(theirs)
    seen = b""
    while True:
        try:
            chunk = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        seen += chunk
    os.close(ours)
    out, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert json.loads(out)["arrived"]
    assert " of 8 m" in seen.decode()


def test_replay_makes_the_same_summary_and_report_from_the_log_alone(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    examples = Path(__file__).parents[1] / "examples"
    assert run(["fly", str(examples / "rooms.yaml"), "--out", "flown", "--json", "--set", "timing.timeout=2"]) == 3
    first = json.loads(capsys.readouterr().out)
    log = folder / "elsewhere.mcap"
    (folder / "flown/flight.mcap").rename(log)
    assert run(["replay", str(log), "--out", "again", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == first
    report = (folder / "again/report.html").read_text()
    assert "rooms" in report
    assert run(["replay", str(log)]) == 0
    assert (folder / "report.html").exists()


def test_replay_of_a_log_that_ends_early_says_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fly", "hop.yaml", "--json"]) == 0
    log = folder / "runs/hop/flight.mcap"
    (folder / "cut.mcap").write_bytes(log.read_bytes()[: int(log.stat().st_size * 0.6)])
    capsys.readouterr()
    assert run(["replay", "cut.mcap", "--out", "cut", "--json"]) == 0
    captured = capsys.readouterr()
    assert "the log ends before the flight did" in captured.err
    assert 0 < json.loads(captured.out)["flight_time_s"] < 10


def test_pictures_are_written_when_asked_for(folder: Path) -> None:
    assert run(["fly", "hop.yaml", "--out", "out", "--png"]) == 0
    assert [path for path in (folder / "out").glob("*.png") if path.stat().st_size > 1000]


def test_results_of_an_earlier_flight_do_not_stay(folder: Path) -> None:
    out = folder / "runs/hop"
    out.mkdir(parents=True)
    for name in FILES:
        (out / name).write_text("old")
    (out / "notes.txt").write_text("mine")
    assert run(["fly", "hop.yaml"]) == 0
    assert "old" not in (out / "summary.json").read_text()
    assert (out / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["fly", "none.yaml"], "none.yaml: 1 problem\n  cannot be read: No such file or directory"),
        (["fly"], "requires an argument"),
        (["fly", "hop.yaml", "--set", "sped=1"], "did you mean 'speed'?"),
        (["fly", "hop.yaml", "--set", "speed=fast"], "speed: must be a number, found 'fast'"),
        (["fly", "hop.yaml", "--vehicle", "boat"], "vehicle.kind: unknown vehicle 'boat'"),
        (["fly", "hop.yaml", "--speed", "3"], "--speed"),
        (["fly", "hop.yaml", "--out", "hop.yaml"], "hop.yaml: must be a folder, found a file"),
        (
            ["fly", "hop.yaml", "--out", "hop.yaml/deeper"],
            "hop.yaml/deeper: this folder cannot be made: Not a directory",
        ),
        (["init", ""], "must be the name of a mission, such as square; found ''"),
        (["check"], "name a mission file, or give --schema"),
        (["check", "wrong.yaml"], "wrong.yaml: 2 problems\n  line 3: speed: must be greater than 0, found -1"),
        (["replay", "hop.yaml"], "hop.yaml: 1 problem"),
        (["replay", "none.mcap"], "none.mcap: No such file or directory"),
        (["export", "hop.yaml", "no/where.plan"], "no/where.plan: No such file or directory"),
        (["export", "hop.yaml"], "requires an argument"),
        (["launch"], "launch"),
    ],
)
def test_bad_input_is_one_message_on_standard_error_and_exit_2(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    (folder / "wrong.yaml").write_text(HOP.replace("3\n", "-1\n") + "sped: 1\n")
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert "Traceback" not in captured.err


def test_bad_input_exits_2_from_the_shell_too(folder: Path) -> None:
    done = command("fly", "none.yaml", "--json", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr


def test_check_prints_a_mission_that_loads_equal(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "hop.yaml", "--set", "tracker.lookahead=2"]) == 0
    captured = capsys.readouterr()
    (folder / "resolved.yaml").write_text(captured.out)
    assert load(folder / "resolved.yaml") == load(folder / "hop.yaml", ["tracker.lookahead=2"])
    assert "hop.yaml: fine. Route 8.0 m" in captured.err


def test_check_prints_the_schema(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--schema"]) == 0
    Draft202012Validator(json.loads(capsys.readouterr().out)).validate(yaml.safe_load(HOP))


def test_init_writes_a_mission_that_flies_and_never_overwrites(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", "first"]) == 0
    text = (folder / "first.yaml").read_text()
    assert text.count("#") > 15
    assert run(["fly", "first.yaml"]) == 0
    (folder / "first.yaml").write_text("mine")
    assert run(["init", "first.yaml"]) == 2
    assert (folder / "first.yaml").read_text() == "mine"
    assert "first.yaml: exists already and is not overwritten" in capsys.readouterr().err
    assert run(["init"]) == 0
    assert (folder / "mission.yaml").exists()


@pytest.mark.parametrize("room", [0, 4])
def test_a_full_disk_is_told_with_the_folder(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, room: int
) -> None:
    written: list[bytes] = []
    write = ChunkWriter.chunk

    def full(self: ChunkWriter, messages: bytes, index: Any) -> None:
        if len(written) == room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(messages)
        write(self, messages, index)

    monkeypatch.setattr(ChunkWriter, "chunk", full)
    assert run(["fly", "hop.yaml", "--out", "here"]) == 2
    assert capsys.readouterr().err.endswith("here: No space left on device\n")


def test_a_route_that_takes_longer_than_allowed_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "hop.yaml", "--set", "timing.timeout=1"]) == 0
    assert "s, longer than timing.timeout, 1 s" in capsys.readouterr().err
    assert run(["check", "hop.yaml"]) == 0
    assert "timeout" not in capsys.readouterr().err


def test_list_shows_every_part_with_fields_defaults_and_units(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list"]) == 0
    out = capsys.readouterr().out
    for text in [
        "quadrotor: ", "airframe = generic [generic|crazyflie|racer]", "point: ", "carrot: ", "lookahead = ",
        "m, δ", "forest: ", "density = 0.2 [≥ 0]  trees per m²", "maze: ", "city: ", "gap: ", "trap: ",
    ]:  # fmt: skip
        assert text in out


def test_export_writes_a_plan(folder: Path) -> None:
    assert run(["export", "hop.yaml", "hop.plan"]) == 0
    assert json.loads((folder / "hop.plan").read_text())["fileType"] == "Plan"


def test_help_and_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert __version__ in capsys.readouterr().out
    assert run(["--help"]) == 0
    out = capsys.readouterr().out
    assert all(verb in out for verb in ["fly", "check", "init", "list", "replay", "export", "Exit codes"])
    assert run([]) == 0


def test_a_plan_is_named_by_a_mission(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "first.plan").write_text("{}")
    assert run(["fly", "first.plan"]) == 2
    assert "name it in a mission file, as `route: first.plan`" in capsys.readouterr().err


def test_check_calls_nothing_fine_that_has_notes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "odd.yaml").write_text(HOP + "world: {shapes: [{box: {min: [2, -1, 0], max: [2.1, 1, 9]}}]}\n")
    assert run(["check", "odd.yaml", "--set", "start.yaw=90"]) == 0
    said = capsys.readouterr().err
    assert "goes through an obstacle" in said
    assert "start.yaw is 90 rad" in said
    assert "valid, but see the notes" in said
    assert "fine" not in said
