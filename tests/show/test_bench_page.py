"""The page of the avoidance benchmark: a table, the shares, and picture and mission of every failure."""

import base64
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crosstrack import mission as missions
from crosstrack.campaign.avoidance.bench import Benchmark
from crosstrack.campaign.avoidance.contestants import CONTESTANTS, document
from crosstrack.campaign.avoidance.families import FAMILIES
from crosstrack.campaign.ranking import Loss
from crosstrack.show.bench_page import benchmark_page
from crosstrack.show.bench_picture import flight_picture
from crosstrack.show.style import ALARM, PALETTE
from crosstrack.types import Outcome


def flight(
    family: str, contestant: str, outcome: Outcome, *, begun: bool = True, steered: bool = False
) -> dict[str, Any]:
    """Return a flight half of the straight way, or all of it where it arrives."""
    arena = FAMILIES[family](family, 1)
    far = 1.0 if outcome is Outcome.ARRIVED else 0.5
    start, goal = np.array(arena.start), np.array(arena.goal)
    position = start + np.linspace(0, far, 50)[:, None] * (goal - start)
    summary = {
        "outcome": outcome.name.lower(),
        "flight_time_s": 9.0,
        "flown_length_m": 20.0,
        "min_clearance_m": 0.21,
        "mean_speed_mps": 2.0,
        "planning_time_s": 0.2,
        "replans": 3,
        "safety_interventions": 1,
        "decision_time_s": 0.001,
        "decision_time_p99_s": 0.002,
    }
    return {
        "labels": {"family": family, "seed": 1, "contestant": contestant},
        "document": document(arena, CONTESTANTS[contestant], 20.0),
        "optimum": {"length": 20.0, "points": [list(arena.start[:2]), list(arena.goal[:2])]},
        "outcome": outcome.name.lower(),
        "summary": summary if begun else None,
        "trace": {"time": [0.0] * 50, "position": position.tolist(), "steered": [steered] * 50} if begun else None,
        "courses": [position.tolist()] * 3 if begun else [],
    }


def pixels(picture: Path | bytes, color: str) -> int:
    """Return how many pixels of a picture have a colour."""
    with Image.open(io.BytesIO(picture) if isinstance(picture, bytes) else picture) as image:
        values = np.asarray(image.convert("RGB"))
    return int((values == list(bytes.fromhex(color[1:]))).all(axis=-1).sum())


def test_the_page_shows_every_failure_and_no_success(tmp_path: Path) -> None:
    flights = (
        flight("gap", "planned", Outcome.ARRIVED),
        flight("gap", "field", Outcome.STUCK),
        flight("maze", "unknown", Outcome.COLLIDED, steered=True),
        flight("maze", "planned", Outcome.UNREACHABLE, begun=False),
    )
    lost = Loss({"family": "trap", "seed": 1, "contestant": "field"}, "the <worker> died")
    page = benchmark_page(Benchmark(flights, (lost,)), tmp_path).read_text()
    assert "5 flights; 4 failed." in page
    assert "the &lt;worker&gt; died" in page
    failures = {path.stem for path in (tmp_path / "failures").glob("*.png")}
    assert failures == {"gap-1-field", "maze-1-unknown", "maze-1-planned"}
    assert set(re.findall(r'alt="(\S+) from above"', page)) == failures
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    rows = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr>(<td>.*?)</tr>", page)]
    assert [row[:3] for row in rows] == [
        ["maze", "planned", "0 of 1"],
        ["maze", "unknown", "0 of 1"],
        ["trap", "field", "0 of 1"],
        ["gap", "planned", "1 of 1"],
        ["gap", "field", "0 of 1"],
        ["all", "planned", "1 of 2"],
        ["all", "unknown", "0 of 1"],
        ["all", "field", "0 of 2"],
    ]
    assert [row[4] for row in rows[:5]] == ["1 not arrived", "1 collided", "1 lost", "", "1 not arrived"]
    shares, *pictures = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", page)
    flown = [pixels(base64.b64decode(address), PALETTE[0]) > 500 for address in pictures]
    assert flown == [True, False, False]  # the second was steered all the way, the third never begun
    assert pixels(base64.b64decode(shares), PALETTE[2]) > 20  # three contestants


def test_the_mission_of_a_failure_can_be_flown_again(tmp_path: Path) -> None:
    benchmark_page(Benchmark((flight("maze", "field", Outcome.STUCK),)), tmp_path)
    mission = missions.load(tmp_path / "failures/maze-1-field.yaml")
    assert mission.name == "maze-1-field"
    assert len(mission.obstacles.shapes) > 10


def test_failures_of_a_run_before_are_gone(tmp_path: Path) -> None:
    benchmark_page(Benchmark((flight("gap", "field", Outcome.STUCK),)), tmp_path)
    page = benchmark_page(Benchmark((flight("gap", "field", Outcome.ARRIVED),)), tmp_path).read_text()
    assert not list((tmp_path / "failures").iterdir())
    assert "Failures" not in page
    assert "1 flight; none failed." in page


def test_of_no_flights_there_is_a_page_too(tmp_path: Path) -> None:
    assert "No flight came back." in benchmark_page(Benchmark(()), tmp_path).read_text()


@pytest.mark.parametrize("steered", [False, True])
def test_the_picture_shows_where_it_was_flown_and_where_it_ended(tmp_path: Path, steered: bool) -> None:
    flight_picture(flight("beside", "field", Outcome.STUCK, steered=steered), tmp_path / "one.png")
    assert pixels(tmp_path / "one.png", PALETTE[1 if steered else 0]) > 500
    assert pixels(tmp_path / "one.png", ALARM) > 100
    flight_picture(flight("beside", "field", Outcome.ARRIVED, steered=steered), tmp_path / "two.png")
    assert pixels(tmp_path / "two.png", ALARM) == 0
