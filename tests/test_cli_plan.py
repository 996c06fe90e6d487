"""`crosstrack plan`, and flights of what it wrote."""

import json
from pathlib import Path

import numpy as np
import pytest

from crosstrack.cli.app import run
from crosstrack.flight.metrics import OF_THE_MACHINE
from crosstrack.trajectory.files.formats import from_bytes

HOP = "start: {position: [0, 0, 5]}\nroute: [[6, 0, 5], [6, 5, 6]]\nspeed: 3\n"
FILES = ("trajectory.json", "trajectory.csv", "certificate.json", "plan.html")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in an empty folder with a mission, with and without a planner."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hop.yaml").write_text(HOP)
    (tmp_path / "snap.yaml").write_text(HOP + "planner: {kind: minimum_snap, guide: 0}\n")
    return tmp_path


def without_clock(summary: str) -> dict[str, object]:
    return {name: value for name, value in json.loads(summary).items() if name not in OF_THE_MACHINE}


def test_plan_writes_trajectory_certificate_and_page(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", "snap.yaml"]) == 0
    printed = capsys.readouterr().out
    out = folder / "runs/snap"
    assert all((out / name).stat().st_size for name in FILES)
    exact = from_bytes("a.json", (out / "trajectory.json").read_bytes())
    others = from_bytes("a.csv", (out / "trajectory.csv").read_bytes())
    np.testing.assert_array_equal(exact.coefficients, others.coefficients)
    certificate = json.loads((out / "certificate.json").read_text())
    assert certificate["holds"] is True
    assert certificate["duration_s"] == exact.duration
    peak = certificate["quantities"]["speed"]
    speeds = np.linalg.norm(exact(np.linspace(0, exact.duration, 5000), 1), axis=1)
    assert speeds.max() <= peak["at_most"] == pytest.approx(speeds.max(), rel=1e-5)
    for text in ["duration ", "largest speed ", "at most 3.000", "largest jerk", "Page: runs/snap/plan.html"]:
        assert text in printed


def test_plan_prints_the_certificate_alone(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", "hop.yaml", "--set", "planner.kind=minimum_jerk", "--out", "here", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((folder / "here/certificate.json").read_text())
    deviation = next(found for found in printed["findings"] if found["quantity"] == "largest deviation from the route")
    assert deviation["value"] <= deviation["limit"] == 0.3


@pytest.mark.parametrize("name", FILES[:2])
def test_a_flight_from_the_file_is_the_flight_of_the_plan(
    folder: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    assert run(["plan", "snap.yaml"]) == 0
    capsys.readouterr()
    assert run(["fly", "snap.yaml", "--out", "planned", "--json"]) == 0
    planned = without_clock(capsys.readouterr().out)
    for mission in ("snap.yaml", "hop.yaml"):
        assert run(["fly", mission, "--from", f"runs/snap/{name}", "--out", "given", "--json"]) == 0
        assert without_clock(capsys.readouterr().out) == planned
    (folder / f"runs/snap/{name}").unlink()
    assert run(["replay", "given/flight.mcap", "--json"]) == 0
    assert without_clock(capsys.readouterr().out) == planned
    assert "tracking_rms_m" in planned


def test_plan_certifies_the_trajectories_of_others(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", "snap.yaml", "--out", "mine", "--set", "speed=5"]) == 0
    capsys.readouterr()
    assert run(["plan", "hop.yaml", "--from", "mine/trajectory.csv"]) == 2
    captured = capsys.readouterr()
    assert "EXCEEDED" in captured.out
    assert "note: the trajectory's largest speed is 4.69 m/s, above 3 m/s, after " in captured.err
    assert json.loads((folder / "runs/hop/certificate.json").read_text())["holds"] is False
    assert "limit exceeded" in (folder / "runs/hop/plan.html").read_text()
    assert run(["plan", "hop.yaml", "--from", "mine/trajectory.csv", "--set", "speed=5"]) == 0
    assert run(["fly", "hop.yaml", "--from", "mine/trajectory.csv"]) == 0
    assert "note: the trajectory's largest speed" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plan", "hop.yaml"], "hop.yaml: 1 problem\n  planner: is required to plan a trajectory: add planner: {kind:"),
        (["plan", "none.yaml"], "none.yaml: 1 problem\n  cannot be read"),
        (["plan", "hop.yaml", "--from", "none.json"], "none.json: no such file"),
        (
            ["plan", "hop.yaml", "--from", "hop.yaml"],
            "hop.yaml: 1 problem\n  the name of a trajectory must end in .json",
        ),
        (["fly", "hop.yaml", "--from", "bad.json"], "bad.json: 5 problems\n  format: is required"),
        (["plan", "snap.yaml", "--out", "hop.yaml"], "hop.yaml: must be a folder, found a file"),
        (["plan", "snap.yaml", "--set", "vehicle.kind=point"], "this kind of vehicle cannot stop"),
    ],
)
def test_bad_input_is_one_message_and_exit_2(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    (folder / "bad.json").write_text('{"version": 1}')
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert message in captured.err
    assert "Traceback" not in captured.err


def test_the_planners_are_listed_with_their_fields(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list"]) == 0
    out = capsys.readouterr().out
    for text in [
        "planners",
        "minimum_snap: ",
        "times = trapezoid [constant|",
        "yaw = fixed [fixed|velocity]",
        "corridor [> 0]  m, the whole trajectory stays within this",
        "guide [auto or ≥ 0]  weight",
        "file: ",
        "feed_forward: ",
    ]:
        assert text in out
