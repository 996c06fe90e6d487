"""How flights of the avoidance benchmark are judged and counted."""

import csv
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from crosstrack.campaign.avoidance.bench import Benchmark, judged, tasks
from crosstrack.campaign.avoidance.score import scores, succeeded, wilson
from crosstrack.campaign.ranking import Loss
from crosstrack.campaign.task import Done
from crosstrack.errors import InputError


def result(
    contestant: str = "planned",
    family: str = "gap",
    seed: int = 1,
    *,
    outcome: str = "arrived",
    seconds: float = 8.0,
    optimum: float | None = 20.0,
    clearance: float = 0.24,
    begun: bool = True,
) -> dict[str, Any]:
    """Return a flight: the time of its optimum is 5 s at the 4 m/s of `planned`."""
    summary = {
        "outcome": outcome,
        "flight_time_s": seconds,
        "min_clearance_m": clearance,
        "flown_length_m": 21.0,
        "mean_speed_mps": 21.0 / seconds,
        "planning_time_s": 0.1 * seed,
        "replans": 0,
        "safety_interventions": 0,
        "decision_time_s": 0.001,
        "decision_time_p99_s": 0.003,
    }
    return {
        "labels": {"family": family, "seed": seed, "contestant": contestant},
        "outcome": outcome,
        "optimum": None if optimum is None else {"length": optimum, "points": [[0.0, 0.0], [20.0, 0.0]]},
        "summary": summary if begun else None,
    }


@given(st.integers(1, 400), st.floats(0, 1))
def test_intervals_are_those_of_wilson(count: int, share: float) -> None:
    good = round(share * count)
    expected = binomtest(good, count).proportion_ci(0.95, method="wilson")
    assert wilson(good, count) == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_an_interval_holds_its_share() -> None:
    for count in range(1, 300):
        assert wilson(count, count)[1] == 1.0
        assert wilson(0, count)[0] == 0.0


def test_of_nothing_nothing_is_known() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("flight", "good"),
    [
        (result(), True),
        (result(seconds=14.99), True),
        (result(seconds=15.01), False),
        (result("unknown", seconds=19.9), True),
        (result("unknown", seconds=20.1), False),
        (result(outcome="collided"), False),
        (result(outcome="stuck"), False),
        (result(outcome="unreachable", begun=False), False),
        (result(outcome="unreachable", optimum=None, begun=False), True),
        (result(outcome="unreachable", optimum=None), True),
        (result(outcome="stuck", optimum=None), False),
        (result(outcome="arrived", optimum=None), False),
    ],
)
def test_success_is_to_arrive_in_time_or_to_say_that_there_is_no_way(flight: dict[str, Any], good: bool) -> None:
    assert succeeded(flight) is good


def test_scores_count_every_flight_once() -> None:
    flights = [
        result(seed=1),
        result(seed=2, clearance=0.21, seconds=10.0),
        result(seed=3, seconds=16.0),
        result(seed=4, outcome="collided", clearance=0.1),
        result(seed=5, outcome="timed_out"),
        result(seed=1, contestant="field"),
        result(seed=1, family="closed", outcome="unreachable", optimum=None, begun=False),
    ]
    rows = scores(flights, [Loss({"family": "gap", "seed": 6, "contestant": "planned"}, "died")])
    assert [(row.family, row.contestant) for row in rows] == [
        ("gap", "planned"),
        ("gap", "field"),
        ("closed", "planned"),
    ]
    first, _, closed = rows
    assert (first.flights, first.succeeded, first.collided, first.late, first.lost) == (6, 2, 1, 1, 1)
    assert first.interval == wilson(2, 6)
    assert first.clearance is not None
    assert first.clearance.least == 0.1
    assert first.length is not None
    assert first.length.median == pytest.approx(1.05)
    assert first.time is not None
    assert (first.time.least, first.time.median, first.time.greatest) == (1.6, 2.0, 3.2)
    assert first.planning is not None
    assert first.planning.median == pytest.approx(0.3)
    assert (closed.succeeded, closed.flights, closed.time, closed.clearance) == (1, 1, None, None)


def test_a_benchmark_is_written_whole(tmp_path: Path) -> None:
    flights = (result(), result(seed=2, outcome="collided"), result("field", "maze", seconds=40.0))
    found = Benchmark(flights, (Loss({"family": "maze", "seed": 1, "contestant": "planned"}, "the worker died"),))
    said = found.document()
    assert said["flights"] == 4
    assert [row["family"] for row in said["totals"]] == ["all", "all"]
    assert [row["flights"] for row in said["totals"]] == [3, 1]
    assert [failure["seed"] for failure in said["failures"]] == [2, 1]
    found.write_csv(tmp_path / "results.csv")
    with (tmp_path / "results.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["succeeded"] for row in rows] == ["True", "False", "False", ""]
    assert rows[0]["optimum_m"] == "20.0"
    assert float(rows[2]["optimum_time_ratio"]) == pytest.approx(6.0)
    assert rows[3]["error"] == "the worker died"


def test_tasks_are_every_contestant_in_every_arena_once() -> None:
    asked = tasks(["forest", "maze"], ["planned", "field", "planned"], 3, 10)
    labels = [tuple(task.payload.values()) for task in asked]
    assert len(set(labels)) == len(labels) == 5 * 3 * 2
    assert labels[:2] == [("forest-0.1", 10, "planned"), ("forest-0.1", 10, "field")]
    assert {family for family, _, _ in labels} == {f"forest-{density}" for density in (0.1, 0.2, 0.3, 0.4)} | {"maze"}
    assert len({task.key for task in asked}) == len(asked)
    values = [Done(task.key, {"n": k}, None, 0.0) for k, task in enumerate(asked[:-1])]
    found = judged(asked, [*values, Done(asked[-1].key, None, "it broke", 0.0)])
    assert [one["n"] for one in found.results] == list(range(29))
    assert found.losses[0].labels["family"] == "maze"


def test_everything_wrong_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        tasks(["wood"], ["plan"], 0, -1)
    text = str(caught.value)
    assert "4 problems" in text
    for word in ("wood", "forest-0.1", "plan: there is no such contestant", "planned", "maps", "seed"):
        assert word in text
