"""A campaign: all its tasks done, those kept from before not again."""

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from crosstrack.campaign.local import Local
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.store import Store
from crosstrack.campaign.task import Done, Task

Watch = Callable[[Done], None]
"""is shown every result as it comes"""


def complete(
    tasks: Sequence[Task], runner: Runner, store: Store | None = None, watch: Watch | None = None
) -> list[Done]:
    """Do all tasks, and return what came of them in their order.

    Args:
        tasks: of the same key, one is done for all
        runner: what does them
        store: where results are kept; a task that has a value there is not done again, one that failed is
        watch: is shown every new result, after it is stored

    Raises:
        KeyboardInterrupt: Ctrl-C; what finished is in the store.
    """
    found = {key: done for key, done in (store.kept if store else {}).items() if done.error is None}
    missing = {task.key: task for task in tasks if task.key not in found}
    with closing(runner.run(list(missing.values()))) as results:
        for done in results:
            if store:
                store.add(done)
            found[done.key] = done
            if watch:
                watch(done)
    return [found[task.key] for task in tasks]


def finished(
    tasks: Sequence[Task], runner: Runner | None, store: str | Path | None, watch: Watch | None = None
) -> list[Done]:
    """Do all tasks, as `complete` does, and close what does them and what keeps them.

    Args:
        tasks: to do
        runner: what does them; by default worker processes, one for every core
        store: the file to keep results in; None for none
        watch: is shown every new result
    """
    with runner or Local() as workers:
        if store is None:
            return complete(tasks, workers, None, watch)
        with Store(store) as kept:
            return complete(tasks, workers, kept, watch)


def kept(tasks: Sequence[Task], store: Store) -> int:
    """Return how many of the tasks have a value in the store."""
    return sum(task.key in store.kept and store.kept[task.key].error is None for task in tasks)
