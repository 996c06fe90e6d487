"""`crosstrack bench avoid`: what it prints where, what it leaves behind, and how it exits."""

import csv
import json
from pathlib import Path

import pytest

from crosstrack.campaign.avoidance.score import Score, score
from crosstrack.campaign.store import Store
from crosstrack.cli.app import run
from crosstrack.cli.benching import table


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_bench_flies_writes_and_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "avoid", "--families", "gap,closed", "--planners", "planned", "--workers", "1", "--out", "here"]
    assert run([*words, "--json"]) == 0
    out, err = capsys.readouterr()
    said = json.loads(out)
    assert "Flights of the benchmark: 2." in err
    assert [(row["family"], row["contestant"], row["succeeded"]) for row in said["scores"]] == [
        ("gap", "planned", 1),
        ("closed", "planned", 1),
    ]
    assert said["failures"] == said["lost"] == []
    with (folder / "here/results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["outcome"] for row in rows] == ["arrived", "unreachable"]
    assert float(rows[0]["min_clearance_m"]) >= 0.2
    assert float(rows[0]["flown_length_m"]) >= 0.99 * float(rows[0]["optimum_m"])
    assert run(words) == 0
    out, err = capsys.readouterr()
    assert "Flights of the benchmark: 2, 2 of them kept from before." in err
    assert "1 of 1" in out
    assert out.endswith("Page: here/benchmark.html\n")
    assert (folder / "here/shares.png").stat().st_size > 1000
    assert "2 flights; none failed." in (folder / "here/benchmark.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--families", "wood"], "families: wood: there is no such family; known: forest-0.1"),
        (["--planners", "best"], "planners: best: there is no such contestant; known: planned"),
        (["--maps", "0"], "maps: must be from 1 to 10000, found 0"),
        (["--seed", "-1"], "seed: must be from 0 to 2147483647, found -1"),
        (["--families", "wood", "--maps", "0"], "bench avoid: 2 problems"),
        (["--workers", "0"], "workers: 1 problem"),
    ],
)
def test_bad_input_is_said_without_flying(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert run(["bench", "avoid", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert not (folder / "runs").exists()


def test_two_at_once_do_not_share_a_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "here").mkdir()
    with Store(folder / "here/results.jsonl"):
        assert run(["bench", "avoid", "--families", "gap", "--out", "here"]) == 2
    assert "another campaign is writing here" in capsys.readouterr().err


def test_columns_in_which_there_is_nothing_are_left_out() -> None:
    lost: Score = score("maze", "planned", [], 2)
    shown = table([lost])
    assert [column.header for column in shown.columns] == [
        "family",
        "contestant",
        "succeeded",
        "95 % interval",
        "otherwise",
    ]
    assert [next(iter(column.cells)) for column in shown.columns][2:] == ["0 of 2", "0 to 66 %", "2 lost"]
