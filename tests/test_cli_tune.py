"""`crosstrack tune`, from the command line to the files."""

import errno
import json
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any, Self

import pytest

import crosstrack as ct
from crosstrack.campaign.task import Done, Task, attempt
from crosstrack.cli import comparing, tuning
from crosstrack.cli.app import run
from crosstrack.mission import export_plan, loads

MISSION = """
name: hop
start: {position: [0, 0, 4]}
route: [[6, 3, 4], [12, -3, 4]]
speed: 3
tracker: {kind: carrot, lookahead: 8}
"""
SHORT = ["--parameter", "lookahead=0.5:10", "--budget", "15", "--workers", "1"]


@pytest.fixture
def hop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "missions").mkdir()
    export_plan(loads(MISSION), tmp_path / "missions/way.plan")
    path = tmp_path / "missions/hop.yaml"
    path.write_text(MISSION.replace("[[6, 3, 4], [12, -3, 4]]", "way.plan"), encoding="utf-8")
    return path


def test_the_mission_written_flies_at_the_cost_that_is_told(hop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["tune", str(hop), *SHORT, "--json", "--out", "deep/tuned.yaml"]) == 0
    told: Any = json.loads(capsys.readouterr().out)
    lookahead = told["parameters"]["lookahead"]
    assert (lookahead["before"], lookahead["low"], lookahead["high"]) == (8.0, 0.5, 10.0)
    assert told["tuning"]["after"]["mean"] < told["tuning"]["before"]["mean"]
    assert told["held_out"] is not None
    tuned = ct.load("deep/tuned.yaml")
    assert tuned.document()["tracker"]["lookahead"] == lookahead["after"]
    flown = ct.fly(tuned).metrics.cross_track_rms_captured_m
    assert flown == pytest.approx(told["tuning"]["after"]["mean"], rel=1e-12)
    page = Path(told["page"]).read_text("utf-8")
    assert "carrot before" in page
    assert "carrot after" in page


class Here:
    """Does tasks in this process."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        pass

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        yield from map(attempt, tasks)


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the command fly in this process, which has the compiled code already."""
    monkeypatch.setattr(comparing, "runner_for", lambda workers, cluster: Here())


@pytest.mark.usefixtures("here")
def test_what_was_found_is_printed(hop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--cost", "cross_track_rms_m + 0.1*time_ratio", "--wind", "0,1,0,light", "--seeds", "1"]
    assert run(["tune", str(hop), *SHORT, *arguments]) == 0
    printed = capsys.readouterr()
    assert "Tuning lookahead" in printed.err
    for text in ("cross_track_rms_m + 0.1*time_ratio", "before", "after", "0.5 to 10", "held-out seed 2", "hop.yaml"):
        assert text in printed.out
    tuned = ct.load("runs/tune/hop.yaml")
    assert tuned.wind == ct.load(hop).wind
    assert tuned.tracker != ct.load(hop).tracker


@pytest.mark.usefixtures("here")
def test_a_kind_of_tracker_is_tuned_from_its_defaults(hop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = ["--set", "planner={kind: minimum_snap, guide: 0}", "--tracker", "feed_forward"]
    assert run(["tune", str(hop), *plan, "--budget", "7", "--json"]) == 0
    told: Any = json.loads(capsys.readouterr().out)
    assert told["cost"] == "tracking_rms_m"
    assert list(told["parameters"]) == ["lead"]


def test_bad_input_is_one_message_with_everything_wrong(hop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = ["--parameter", "lookahed=1:2", "--cost", "speed", "--wind", "gale", "--seeds", "2", "--budget", "1"]
    assert run(["tune", str(hop), *wrong]) == 2
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "tune: 4 problems"
    assert run(["tune", str(hop), "--out", "tuned.txt"]) == 2
    assert "must be a file that ends in .yaml" in capsys.readouterr().err
    assert not Path("runs").exists()


def test_what_cannot_be_written_is_said_before_anything_flies(hop: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = hop.read_text()
    assert run(["tune", str(hop), *SHORT, "--out", "missions/../missions/hop.yaml"]) == 2
    assert "hop.yaml: is the mission that is tuned: name another file" in capsys.readouterr().err
    Path("tuned.html").mkdir()
    assert run(["tune", str(hop), *SHORT, "--out", "tuned.yaml"]) == 2
    assert capsys.readouterr().err == "tuned.html: Is a directory\n"
    assert not Path("tuned.yaml").exists()
    assert hop.read_text() == before


@pytest.mark.usefixtures("here")
def test_what_was_found_is_told_where_the_disk_is_full(
    hop: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*given: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tuning, "write", full)
    assert run(["tune", str(hop), "--parameter", "lookahead=0.5:10", "--budget", "7", "--json"]) == 2
    printed = capsys.readouterr()
    assert json.loads(printed.out)["parameters"]["lookahead"]["before"] == 8.0
    assert printed.err.endswith("hop.yaml: No space left on device\n")
