"""The command with several vehicles."""

import json
from pathlib import Path

import pytest
from PIL import Image, ImageColor

from crosstrack.cli.app import run
from crosstrack.show.style import PALETTE

FLEET = """
vehicles:
  - {name: left, start: {position: [0, 0, 5]}, route: [[6, 0, 5]]}
  - {name: right, start: {position: [0, 3, 5]}, route: [[6, 3, 5]]}
speed: 3
"""


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    path = tmp_path / "pair.yaml"
    path.write_text(FLEET)
    return path


def test_each_has_its_log_and_all_have_one_summary_and_report(
    fleet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(["fly", str(fleet), "--out", str(out), "--png"]) == 0
    assert "2 of 2 arrived." in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} == {
        "left.mcap", "right.mcap", "summary.json", "report.html", "together.png",
    }  # fmt: skip
    with Image.open(out / "together.png") as picture:
        colours = {colour for _, colour in picture.convert("RGB").getcolors(1 << 24) or ()}
    assert {ImageColor.getrgb(colour) for colour in PALETTE[:2]} <= colours
    summary = json.loads((out / "summary.json").read_text())
    assert [vehicle["name"] for vehicle in summary["vehicles"]] == ["left", "right"]
    assert summary["arrived"] is True
    assert summary["min_separation_m"] == pytest.approx(3.0, abs=0.05)

    assert run(["replay", str(out / "right.mcap"), "--out", str(tmp_path / "again"), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["min_separation_m"] == summary["vehicles"][1]["min_separation_m"]


def test_a_collision_of_two_is_the_exit_code(fleet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fleet.write_text(FLEET.replace("[0, 3, 5]", "[6, 0, 5]").replace("[[6, 3, 5]]", "[[0, 0, 5]]"))
    assert run(["fly", str(fleet), "--out", str(tmp_path / "out"), "--json"]) == 4
    found = json.loads(capsys.readouterr().out)
    assert (found["collided"], found["arrived"]) == (True, False)
    assert found["min_separation_m"] < 0.4


def test_what_is_for_one_vehicle_says_so(fleet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", str(fleet)]) == 0
    assert "fine. The longest route 6.0 m" in capsys.readouterr().err
    assert run(["plan", str(fleet), "--set", "planner.kind=minimum_snap", "--out", str(tmp_path)]) == 2
    assert "vehicles: are several" in capsys.readouterr().err
