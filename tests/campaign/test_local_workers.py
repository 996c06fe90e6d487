"""Worker processes: what they compute comes back exactly, and nothing that they do harms the others."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chores import chore

from crosstrack.campaign.local import Local
from crosstrack.campaign.task import Done, Task
from crosstrack.errors import InputError

TESTS = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def two() -> Iterator[Local]:
    with Local(2) as workers:
        yield workers


def results(workers: Local, tasks: list[Task]) -> dict[str, Done]:
    return {done.key: done for done in workers.run(tasks)}


def wait_for(condition: Callable[[], object]) -> None:
    deadline = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_numbers_come_back_exactly(two: Local) -> None:
    bits = np.random.default_rng(0).integers(0, 2**64, 3000, dtype=np.uint64)
    numbers = [number for number in bits.view(float).tolist() if np.isfinite(number)]
    tasks = [chore("echo", number=number, text='"\n\u2028é') for number in numbers]
    found = results(two, tasks)
    assert [found[task.key].value for task in tasks] == [task.payload for task in tasks]
    assert {done.error for done in found.values()} == {None}


def test_an_error_is_the_result_of_its_task_alone(two: Local) -> None:
    tasks = [chore(name) for name in ("fail", "refuse", "not_a_number", "missing", "echo")]
    found = results(two, tasks)
    errors = [found[task.key].error for task in tasks]
    assert errors[0] == "ValueError: no such luck"
    assert errors[1] == "mission: 1 problem\n  speed: must be fast"
    assert errors[2] is not None
    assert errors[2].startswith("ValueError: Out of range float values")
    assert errors[3] is not None
    assert errors[3].startswith("AttributeError: ")
    assert errors[4] is None


@pytest.mark.parametrize("workers", [1, 2])
def test_a_worker_that_dies_costs_only_its_task(workers: int) -> None:
    tasks = [chore("pid", number=k) for k in range(12)]
    deaths = [
        (chore("leave", code=7), "the worker died: exit code 7"),
        (chore("leave", code=0), "the worker died: exit code 0"),
        (chore("die", signal=int(signal.SIGKILL)), "the worker died: killed by signal 9 (Killed)"),
        (chore("die", signal=int(signal.SIGSEGV)), "the worker died: killed by signal 11 (Segmentation fault)"),
    ]
    mixed = tasks.copy()
    for k, (task, _) in enumerate(deaths):
        mixed.insert(3 * k, task)
    with Local(workers) as hands:
        found = results(hands, mixed)
    assert [found[task.key].error for task, _ in deaths] == [error for _, error in deaths]
    assert all(found[task.key].error is None for task in tasks)
    processes: set[Any] = {found[task.key].value for task in tasks}
    assert len(processes) > 1
    assert not any(alive(process) for process in processes)


def test_killing_a_worker_in_the_middle_of_a_task_loses_only_that(two: Local, tmp_path: Path) -> None:
    note = tmp_path / "pid"

    def kill() -> None:
        wait_for(lambda: note.exists() and note.read_text())
        os.kill(int(note.read_text()), signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    lingering, others = chore("linger", file=str(note)), [chore("echo", number=k) for k in range(20)]
    found = results(two, [*others[:10], lingering, *others[10:]])
    killer.join()
    assert found.pop(lingering.key).error == "the worker died: killed by signal 9 (Killed)"
    assert len(found) == 20
    assert {done.error for done in found.values()} == {None}


def test_workers_stay_from_one_run_to_the_next(two: Local) -> None:
    first, second = (
        {done.value for done in two.run([chore("pid", number=k, turn=turn) for k in range(8)])} for turn in range(2)
    )
    assert first == second
    assert len(first) == 2


def test_what_a_task_prints_is_no_answer_and_it_has_nothing_to_read(capfd: pytest.CaptureFixture[str]) -> None:
    with Local(1) as workers:
        (done,) = workers.run([chore("speak")])
    assert done.value == ""
    out, err = capfd.readouterr()
    assert out == ""
    assert "written" in err


def test_a_run_that_no_one_reads_on_is_given_up(two: Local, tmp_path: Path) -> None:
    note = tmp_path / "pid"
    run = two.run([chore("echo", number=-1), chore("linger", file=str(note))])
    assert next(run).value == {"number": -1}
    wait_for(note.exists)
    run.close()
    assert results(two, [task := chore("echo", number=-2)])[task.key].value == {"number": -2}


def test_a_worker_that_is_about_to_end_is_given_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    with Local(1) as one:
        (first,) = one.run([chore("pid", number=0)])
        process = one.workers[0].process
        assert process is not None
        monkeypatch.setattr(process, "kill", lambda: None)  # a signal that takes its time
        one.stop()
        (second,) = one.run([chore("pid", number=1)])
    assert second.error is None
    assert second.value != first.value


@pytest.mark.parametrize("count", [-1, 0, 1025, 10**9])
def test_a_number_of_workers_that_cannot_be_is_refused(count: int) -> None:
    with pytest.raises(InputError, match=f"must be from 1 to 1024, found {count}"):
        Local(count)


CAMPAIGN = """
import os, sys
from chores import chore
from crosstrack.campaign.complete import complete
from crosstrack.campaign.local import Local
from crosstrack.campaign.store import Store
folder = sys.argv[1]
tasks = [chore("pid", number=k) for k in range(6)] + [chore("linger", file=f"{folder}/{k}") for k in range(2)]
with Local(2) as workers, Store(f"{folder}/results.jsonl") as store:
    try:
        complete(tasks, workers, store)
    except KeyboardInterrupt:
        print("interrupted with", len(store.kept), flush=True)
        raise
"""


@pytest.fixture
def campaign(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """Run a campaign whose last tasks do not end, until they have begun."""
    process = subprocess.Popen(
        [sys.executable, "-c", CAMPAIGN, str(tmp_path)],
        env=os.environ | {"PYTHONPATH": str(TESTS)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    with process:
        wait_for(lambda: all((tmp_path / str(k)).exists() and (tmp_path / str(k)).read_text() for k in range(2)))
        yield process
        process.kill()


def test_ctrl_c_ends_the_workers_and_keeps_what_finished(campaign: subprocess.Popen[str], tmp_path: Path) -> None:
    os.killpg(campaign.pid, signal.SIGINT)  # as a terminal does: to the workers too
    out, err = campaign.communicate(timeout=30)
    assert out == "interrupted with 6\n"
    assert err.rstrip().endswith("KeyboardInterrupt")
    assert err.count("Traceback") == 1
    assert len((tmp_path / "results.jsonl").read_text().splitlines()) == 6
    assert not any(alive(int((tmp_path / str(k)).read_text())) for k in range(2))


def test_workers_end_with_a_parent_that_is_killed(campaign: subprocess.Popen[str], tmp_path: Path) -> None:
    workers = [int((tmp_path / str(k)).read_text()) for k in range(2)]
    assert all(alive(worker) for worker in workers)
    campaign.kill()
    wait_for(lambda: not any(alive(worker) for worker in workers))
