"""`crosstrack evaluate`: what it prints where, what it leaves behind, and how it exits."""

import csv
import json
from pathlib import Path

import pytest

from crosstrack.campaign.store import Store
from crosstrack.cli.app import run


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_evaluate_flies_writes_and_goes_on(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["evaluate", "avoid-ppo", "--density", "0", "--beside", "random", "--maps", "1", "--jobs", "1"]
    words += ["--out", "here"]
    assert run([*words, "--json"]) == 0
    out, err = capsys.readouterr()
    said = json.loads(out)
    assert "Flights of the evaluation: 2." in err
    assert [(row["world"], row["contestant"], row["flights"]) for row in said["scores"]] == [
        ("forest-0", "policy", 1),
        ("forest-0", "random", 1),
    ]
    assert said["policy"] == "avoid-ppo"
    assert [row["arrived"] for row in said["scores"]] == [1, 0]
    assert said == json.loads((folder / "here/results.json").read_text())
    with (folder / "here/results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["contestant"] for row in rows] == ["policy", "random"]
    assert float(rows[0]["flown_length_m"]) >= 39.5
    assert run(words) == 0
    out, err = capsys.readouterr()
    assert "Flights of the evaluation: 2, 2 of them kept from before." in err
    assert "1 of 1" in out
    assert out.endswith("Flights: here/evaluation.png\n")
    assert (folder / "here/evaluation.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        (["nothing"], ["nothing: no such policy ships"]),
        (["there.npz"], ["there.npz: no such file"]),
        (["avoid-ppo", "--density", "x"], ["density: must be numbers such as 0.1,0.2, found 'x'"]),
        (["avoid-ppo", "--density", "-1"], ["density: must be from 0 to 1 trees per m², found -1"]),
        (["avoid-ppo", "--family", "maze", "--density", "0.1"], ["density: is of the family forest"]),
        (["avoid-ppo", "--beside", "carrot"], ["beside: carrot: there is no such contestant; known: safe, field"]),
        (["follow-ppo", "--family", "maze"], ["family: is of worlds with obstacles"]),
        (
            ["nothing", "--maps", "0", "--seed", "-1", "--jobs", "0", "--family", "wood", "--beside", "fish"],
            ["evaluate: 6 problems", "maps: must be from 1", "seed: must be from 0", "jobs: must be from 1 to 1024"],
        ),
    ],
)
def test_bad_input_is_said_without_flying(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], messages: list[str]
) -> None:
    assert run(["evaluate", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    for message in messages:
        assert message in err
    assert not (folder / "runs").exists()


def test_two_at_once_do_not_share_a_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "here").mkdir()
    with Store(folder / "here/results.jsonl"):
        assert run(["evaluate", "avoid-ppo", "--maps", "1", "--beside", "none", "--out", "here"]) == 2
    assert "another campaign is writing here" in capsys.readouterr().err
