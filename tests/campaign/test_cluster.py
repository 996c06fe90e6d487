"""Tasks on a Ray cluster: what is sent together, what a dead worker costs; on a real one where Ray is installed."""

import json
import socket
import sys
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from chores import chore

from crosstrack.campaign.cluster import BATCH, Cluster, batch
from crosstrack.campaign.complete import complete
from crosstrack.campaign.local import Local
from crosstrack.campaign.task import Done, Task, task
from crosstrack.errors import InputError

DEADLY = "leave"


class RayError(Exception):
    """A worker that died."""


class RayTaskError(RayError):
    """An error of the function itself."""

    def __init__(self, cause: Exception) -> None:
        self.cause = cause


class PretendRay:
    """What is used of Ray, in this process: a batch with a deadly task dies, others take a given time."""

    exceptions = SimpleNamespace(RayError=RayError, RayTaskError=RayTaskError)

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.sent: list[int] = []

    def init(self, **how: Any) -> None:
        pass

    def shutdown(self) -> None:
        pass

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": 3.0}

    def remote(self, **how: Any) -> Any:
        return lambda function: SimpleNamespace(remote=lambda *given: self.call(function, *given))

    def call(self, function: Any, source: str, lines: list[str]) -> Any:
        self.sent.append(len(lines))
        if any(DEADLY in line for line in lines):
            return iter([RayError()])
        try:
            done = [json.loads(line) | {"seconds": self.seconds} for line in function(source, lines)]
        except InputError as error:
            return iter([RayTaskError(error)])
        return iter([[json.dumps(line) for line in done]])

    def wait(self, references: list[Any], timeout: float) -> tuple[list[Any], list[Any]]:
        return references[:1], references[1:]

    def get(self, reference: Any) -> list[str]:
        found: list[str] | RayError = next(reference)
        if isinstance(found, RayError):
            raise found
        return found

    def cancel(self, reference: Any, force: bool) -> None:
        pass


def pretend(monkeypatch: pytest.MonkeyPatch, seconds: float) -> PretendRay:
    ray: Any = PretendRay(seconds)
    monkeypatch.setitem(sys.modules, "ray", ray)
    return ray  # type: ignore[no-any-return]  # it stands in for a module


@pytest.mark.parametrize(("seconds", "together"), [(5.0, 1), (0.5, 4), (0.2, 10)])
def test_batches_are_a_second_or_more(monkeypatch: pytest.MonkeyPatch, seconds: float, together: int) -> None:
    ray = pretend(monkeypatch, seconds)
    tasks = [chore("echo", number=k) for k in range(400)]
    with Cluster("auto") as runner:
        done = complete(tasks, runner)
    assert [one.value for one in done] == [task.payload for task in tasks]
    assert sum(ray.sent) == 400
    assert ray.sent[0] == 1, "how long they take is not known yet"
    assert sorted(ray.sent)[len(ray.sent) // 2] == max(ray.sent) == together
    assert max(ray.sent) * seconds >= min(BATCH, seconds)


def test_work_is_shared_out_where_little_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    ray = pretend(monkeypatch, 0.001)
    with Cluster("auto") as runner:
        complete([chore("echo", number=k) for k in range(66)], runner)
    assert ray.sent[:6] == [1] * 6
    assert ray.sent[6] == 20, "a third of the others, there being three cores"


def test_a_worker_that_dies_costs_only_its_task(monkeypatch: pytest.MonkeyPatch) -> None:
    ray = pretend(monkeypatch, 0.1)
    tasks = [chore("echo", number=k) for k in range(60)]
    tasks.insert(30, chore(DEADLY, code=1))
    with Cluster("auto") as runner:
        done = complete(tasks, runner)
    assert {one.key: one.error for one in done if one.error} == {tasks[30].key: "the worker died (RayError)"}
    assert max(ray.sent) > 1, "it was sent with others"


def test_a_cluster_with_another_crosstrack_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    pretend(monkeypatch, 0.1)
    with Cluster("auto") as runner:
        runner.batch = SimpleNamespace(remote=lambda source, lines: runner.ray.call(batch, "other", lines))
        with pytest.raises(InputError, match="another version of Crosstrack: install the same everywhere"):
            complete([chore("echo")], runner)


def test_without_ray_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(InputError, match=r"pip install 'crosstrack\[cluster\]'"):
        Cluster("127.0.0.1:6379")


def test_an_address_where_no_one_listens_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    pretend(monkeypatch, 0.1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        free = f"127.0.0.1:{server.getsockname()[1]}"
    for address, message in (
        (free, "there is no Ray cluster here"),
        (f"ray://{free}", "there is no Ray cluster here"),
        ("127.0.0.1:999999", "there is no Ray cluster here"),
        ("somewhere", "must be HOST:PORT"),
        ("", "must be HOST:PORT"),
    ):
        with pytest.raises(InputError, match=message), Cluster(address):
            pass


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Start a cluster of this machine's own."""
    pytest.importorskip("ray")
    from ray.cluster_utils import Cluster as Head  # noqa: PLC0415 - there only where Ray is

    head: Any = Head(initialize_head=True, head_node_args={"num_cpus": 2, "include_dashboard": False})
    yield head.address
    head.shutdown()


def by_key(done: list[Done]) -> dict[str, tuple[Any, str | None]]:
    return {one.key: (one.value, one.error) for one in done}


@pytest.mark.slow
def test_a_real_cluster_gives_the_results_of_this_machine(address: str, tasks: list[Task]) -> None:
    with Local(1) as local, Cluster(address) as runner:
        assert by_key(complete(tasks, runner)) == by_key(complete(tasks, local))


@pytest.mark.slow
def test_a_real_worker_that_dies_costs_only_its_task(address: str) -> None:
    numbers: list[Any] = list(range(100))
    tasks = [task("math:sqrt", number) for number in numbers]
    tasks.insert(70, task("os:_exit", numbers[3]))
    with Cluster(address) as runner:
        done = complete(tasks, runner)
    assert [one.value for one in done if one.error is None] == [k**0.5 for k in range(100)]
    assert [one.error for one in done if one.error] == ["the worker died (WorkerCrashedError)"]
