"""Results on disk: whole again after any interruption, and done again only where they must be."""

from collections.abc import Generator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pytest
from chores import chore

from crosstrack.campaign.complete import complete, kept
from crosstrack.campaign.store import LONGEST, Store
from crosstrack.campaign.task import Done, Task, attempt, task
from crosstrack.errors import InputError

SOME = [Done(f"key{k}", {"x": [0.1 * k, None], "é": "\n"}, None, 0.1) for k in range(3)]


class Here:
    """A runner in this process, backwards; it notes what it was given."""

    def __init__(self, most: int = 100) -> None:
        self.given: list[Task] = []
        self.most = most

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        self.given = list(tasks)
        for count, one in enumerate(reversed(tasks)):
            if count == self.most:
                raise KeyboardInterrupt
            yield attempt(one)


def roots(count: int) -> list[Task]:
    """Return tasks of which the second fails."""
    return [chore("root", number=-1 if k == 1 else k) for k in range(count)]


def test_what_is_stored_is_read_back(tmp_path: Path) -> None:
    with Store(tmp_path / "results.jsonl") as store:
        for done in SOME:
            store.add(done)
    with Store(tmp_path / "results.jsonl") as store:
        assert store.kept == {done.key: done for done in SOME}


def test_a_file_cut_anywhere_keeps_its_whole_lines_and_is_written_on(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    with Store(path) as store:
        for done in SOME:
            store.add(done)
    content = path.read_bytes()
    for cut in [*range(len(content) // 3 + 2), *range(len(content) - 3, len(content) + 1)]:
        path.write_bytes(content[:cut])  # every offset of one line, and near the ends of the others
        with Store(path) as store:
            assert list(store.kept.values()) == SOME[: content[:cut].count(b"\n")]
            store.add(SOME[2])
        with Store(path) as store:
            assert store.kept[SOME[2].key] == SOME[2]


@pytest.mark.parametrize(
    "content",
    [
        "hello\n",
        "hello",
        "{}\n",
        '{"key": [], "value": 1, "error": null, "seconds": 1.0}\n',
        '{"key": "k", "value": 1, "error": 2, "seconds": 1.0}\n',
        '{"key": "k", "value": 1, "error": null, "seconds": "long"}\n',
        "[" * 9999 + "\n",
        '{"key": "' + LONGEST * "x",
    ],
    ids=["text", "text without an end", "empty", "key", "error", "seconds", "deep", "long"],
)
def test_a_file_of_something_else_is_refused_and_left_alone(tmp_path: Path, content: str) -> None:
    path = tmp_path / "results.jsonl"
    path.write_text(content)
    with pytest.raises(InputError, match="line 1: is no result of a campaign"):
        Store(path)
    assert path.read_text() == content


def test_one_campaign_at_a_time_writes_to_a_file(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    with Store(path) as first:
        first.add(SOME[0])
        with pytest.raises(InputError, match="another campaign is writing here"):
            Store(path)
        first.add(SOME[1])
    with Store(path) as second:
        assert list(second.kept.values()) == SOME[:2]


def test_results_are_in_the_order_of_the_tasks() -> None:
    tasks = roots(9)
    done = complete([*tasks, tasks[0]], Here())
    assert [one.key for one in done] == [one.key for one in [*tasks, tasks[0]]]
    assert [one.value for one in done if one.error is None] == [0, *(k**0.5 for k in range(2, 9)), 0]


def test_an_interrupted_campaign_goes_on_where_it_stopped_and_tries_errors_again(tmp_path: Path) -> None:
    path, tasks, first, second = tmp_path / "results.jsonl", roots(6), Here(most=5), Here()
    with Store(path) as store, pytest.raises(KeyboardInterrupt):
        complete(tasks, first, store)
    with path.open("a") as file:
        file.write('{"key": "torn')
    with Store(path) as store:
        assert kept(tasks, store) == 4
        seen: list[Any] = []
        done = complete(tasks, second, store, seen.append)
    assert second.given == tasks[:2]
    assert len(seen) == 2
    assert [one.error is None for one in done] == [True, False, True, True, True, True]


def test_another_payload_or_function_has_another_key() -> None:
    keys = {task(name, payload).key for name in ("a:b", "a:c") for payload in ({}, {"x": 1}, {"x": 1.5}, {"x": [1]})}
    assert len(keys) == 8
    assert task("a:b", {"x": 1, "y": 2}).key == task("a:b", {"y": 2, "x": 1}).key
