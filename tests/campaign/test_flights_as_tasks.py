"""Flights as tasks: the same numbers wherever they are flown, and those of the flight itself."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import crosstrack as ct
from crosstrack.campaign.compare import compare
from crosstrack.campaign.complete import complete
from crosstrack.campaign.flights import POINTS, SAMPLES, flight_task, thinned
from crosstrack.campaign.local import Local
from crosstrack.campaign.task import Task, attempt
from crosstrack.flight.metrics import OF_THE_MACHINE
from crosstrack.flight.summary import summary


@pytest.fixture(scope="module")
def two() -> Iterator[Local]:
    with Local(2) as workers:
        yield workers


def test_results_are_the_same_bits_here_in_one_worker_and_in_two(tasks: list[Task], two: Local) -> None:
    here = [attempt(task) for task in tasks]
    assert [done.error for done in here] == [None] * len(tasks)
    with Local(1) as one:
        alone = complete(tasks, one)
    beside = complete(tasks, two)
    said = [[json.dumps([done.key, done.value]) for done in list_] for list_ in (here, alone, beside)]
    assert said[0] == said[1] == said[2]
    assert len({json.dumps(done.value["summary"]) for done in beside if done.value}) == len(tasks), "seeds differ"


def test_a_result_tells_what_the_flight_did(tasks: list[Task]) -> None:
    task = tasks[3]
    value = attempt(task).value
    assert value is not None
    flight = ct.fly(ct.from_document(task.payload["document"]))
    expected = summary(flight)
    for name in OF_THE_MACHINE:
        del expected[name]
    assert value["summary"] == expected
    assert value["labels"] == {"mission": "hop", "tracker": "mission", "wind": "1,0,0,light", "seed": 2}
    assert value["route"] == [[0, 0, 5], [6, 0, 5], [6, 6, 5]]
    trace = value["trace"]
    assert trace["tracking"] is None
    assert len(trace["time"]) == min(SAMPLES, len(flight.record.time))
    for samples, true, exact in (
        (trace["position"], flight.record.position, 5e-4),
        (trace["cross_track"], flight.cross_track[:, None], 5e-5),
    ):
        columns = np.reshape(samples, (len(trace["time"]), -1))
        wanted = [np.interp(trace["time"], flight.record.time, column) for column in true.T]
        assert np.abs(columns - np.transpose(wanted)).max() < 2 * exact


def test_a_planned_mission_is_told_with_its_tracking_error() -> None:
    mission = ct.loads(
        "{start: {position: [0, 0, 5]}, route: [[6, 0]], speed: 2, planner: {kind: minimum_snap, guide: 0}}"
    )
    value = attempt(flight_task(mission, {"tracker": "mission"})).value
    assert value is not None
    tracking, time = np.array(value["trace"]["tracking"]), np.array(value["trace"]["time"])
    rms = np.sqrt(np.trapezoid(tracking**2, time) / time[-1])
    assert rms == pytest.approx(value["summary"]["tracking_rms_m"], rel=0.02, abs=1e-4)


def test_thinning_keeps_both_ends_and_spreads_evenly() -> None:
    for count in (1, 2, 399, 400, 401, 5000, POINTS):
        rows = thinned(count, SAMPLES)
        assert len(rows) == min(count, SAMPLES)
        assert (rows[0], rows[-1]) == (0, count - 1)
        assert np.ptp(np.diff(rows), axis=0) <= 1 if count > 1 else True


def test_compare_flies_again_only_what_is_missing(hop: ct.Mission, two: Local, tmp_path: Path) -> None:
    def fly(trackers: list[str], seeds: int) -> tuple[int, list[str]]:
        seen: list[object] = []
        found = compare([hop], trackers, seeds=seeds, runner=two, store=tmp_path / "results.jsonl", watch=seen.append)
        return len(seen), [json.dumps(result) for result in found.results]

    assert fly(["carrot"], 1)[0] == 1
    some, first = fly(["mission", "carrot"], 2)
    none, second = fly(["mission", "carrot"], 2)
    assert (some, none) == (3, 0)
    assert first == second
