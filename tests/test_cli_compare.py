"""`crosstrack compare`: what it prints where, what it leaves behind, and how it exits."""

import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from crosstrack.campaign.ranking import Row, Spread
from crosstrack.campaign.store import Store
from crosstrack.cli import comparing
from crosstrack.cli.app import run
from crosstrack.cli.comparing import table

HOP = "start: {position: [0, 0, 5]}\nroute: [[4, 0, 5], [4, 4, 5]]\nspeed: 3\nvehicle: {kind: point}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder with two short missions."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hop.yaml").write_text(HOP)
    (tmp_path / "skip.yaml").write_text(HOP.replace("4, 4, 5", "4, -4, 6"))
    return tmp_path


def test_compare_ranks_writes_and_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["compare", "hop.yaml", "skip.yaml", "--trackers", "carrot,carrot:lookahead=2", "--workers", "1"]
    assert run([*words, "--wind", "calm", "--out", "here", "--json"]) == 0
    out, err = capsys.readouterr()
    said = json.loads(out)
    assert [set(said["missions"]), len(said["ranking"])] == [{"hop", "skip"}, 2]
    assert [row["arrived"] for row in said["ranking"]] == [2, 2]
    assert "Flights to compare: 4. " in err
    assert run([*words, "--wind", "calm", "--wind", "-1,0,0", "--out", "here"]) == 0
    out, err = capsys.readouterr()
    assert "Flights to compare: 8, 4 of them kept from before. " in err
    titles = [line.strip() for line in out.splitlines() if line.startswith(("hop", "skip", "all", "Page"))]
    assert titles == ["hop", "skip", "all missions", "Page: here/comparison.html"]
    assert "carrot:lookahead=2" in out
    with (folder / "here/results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    stored = [json.loads(line)["value"] for line in (folder / "here/results.jsonl").read_text().splitlines()]
    assert len(rows) == len(stored) == 8
    by_labels = {tuple(map(str, value["labels"].values())): value["summary"] for value in stored}
    for row in rows:
        summary = by_labels[row["mission"], row["tracker"], row["wind"], row["seed"]]
        assert float(row["cross_track_rms_m"]) == summary["cross_track_rms_m"]
        assert row["outcome"] == summary["outcome"]
        assert row["min_clearance_m"] == ""
    page = (folder / "here/comparison.html").read_text()
    assert "carrot:lookahead=2" in page


def test_a_flight_that_dies_is_told_and_the_others_are_ranked(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mission of more memory than workers may have kills its worker."""
    hostile = folder / "sitecustomize.py"
    hostile.write_text(
        "import sys\n"
        "if any('campaign.worker' in word for word in sys.orig_argv):\n"
        "    import os, crosstrack.flight.loop as loop\n"
        "    fly = loop.fly\n"
        "    loop.fly = lambda plan: os.abort() if plan.tracker.lookahead == 2 else fly(plan)\n"
    )
    monkeypatch.syspath_prepend(str(folder))
    code = run(["compare", "hop.yaml", "--trackers", "carrot,carrot:lookahead=2", "--workers", "1", "--json"])
    out, err = capsys.readouterr()
    assert code == 6
    said = json.loads(out)
    assert [(row["tracker"], row["arrived"], row["lost"]) for row in said["ranking"]] == [
        ("carrot", 1, 0), ("carrot:lookahead=2", 0, 1),
    ]  # fmt: skip
    assert (
        "lost: mission hop, tracker carrot:lookahead=2, wind mission, seed 1: the worker died: killed by signal 6"
        in err
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["compare"], "missions: at least one is needed"),
        (["compare", "hop.yaml", "--trackers", "carot"], "did you mean 'carrot'?"),
        (["compare", "hop.yaml", "--wind", "-2,0"], "-2,0: must be mission, calm, E,N,U"),
        (["compare", "hop.yaml", "--seeds", "0"], "seeds: must be at least 1"),
        (["compare", "hop.yaml", "--workers", "0"], "workers: 1 problem"),
        (["compare", "hop.yaml", "--workers", "1000000"], "must be from 1 to 1024, found 1000000"),
        (["compare", "none.yaml", "--trackers", "carrot:x", "--wind", "gale"], "compare: 3 problems"),
        (["compare", "hop.yaml", "hop.yaml"], "hop: is the name of 2 missions"),
        (["compare", "none.yaml"], "none.yaml: 1 problem"),
        (["compare", "none.yaml", "nor.yaml"], "nor.yaml: cannot be read"),
        (["compare", "hop.yaml", "--set", "sped=3"], "there is no 'sped' here"),
        (["compare", "hop.yaml", "--trackers", "carrot", "--cluster", "x", "--workers", "2"], "leave one out"),
    ],
)
def test_bad_input_is_said_without_flying(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert run(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert not (folder / "runs").exists()


def test_two_at_once_do_not_share_a_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "here").mkdir()
    with Store(folder / "here/results.jsonl"):
        assert run(["compare", "hop.yaml", "--trackers", "carrot", "--out", "here"]) == 2
    assert "here/results.jsonl: 1 problem\n  another campaign is writing here" in capsys.readouterr().err


def test_ctrl_c_keeps_the_flights_and_says_how_to_go_on(folder: Path) -> None:
    command = [sys.executable, "-m", "crosstrack", "compare", "hop.yaml", "--trackers", "carrot", "--workers", "1"]
    process = subprocess.Popen([*command, "--seeds", "2000"], stderr=subprocess.PIPE, text=True, start_new_session=True)
    results = folder / "runs/compare/results.jsonl"
    with process:
        deadline = time.monotonic() + 60
        while not (results.exists() and results.stat().st_size):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    kept = len(results.read_text().splitlines())
    assert f"{kept} of 2000 flights are kept in runs/compare; the same command flies the others.\n" in err
    assert "Traceback" not in err


def test_what_is_empty_is_no_column_and_names_are_no_markup() -> None:
    row = Row("lqr:q=[red]", 2, 2, 0, 0, Spread(0.1, 0.1, 0.1), 0.3, None, Spread(1.0, 0.9, 1.1))
    shown = table([row], "a [bold] name")
    assert [column.header for column in shown.columns] == [
        "", "tracker", "arrived", "cross-track RMS, m", "largest, m", "time ratio",
    ]  # fmt: skip
    assert comparing.between(Spread(0.2, 0.1, float("inf"))) == "0.200 (0.100 to never)"


@pytest.mark.parametrize("encoding", ["utf-8", "ascii", "latin-1"])
def test_tables_are_printed_in_any_encoding(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding))
    comparing.show([table([Row("carrot", 1, 1, 0, 0, Spread(0.1, 0.1, 0.1), 0.3, None, None)], "é \u2708")])
    sys.stdout.flush()
    text = written.getvalue().decode(encoding)
    assert "carrot" in text
    assert text.startswith({"utf-8": "é \u2708", "ascii": "? ?", "latin-1": "é ?"}[encoding])


def test_a_closed_standard_output_is_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    comparing.show([table([Row("carrot", 1, 1, 0, 0, None, None, None, None)], "hop")])
