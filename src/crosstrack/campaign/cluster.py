"""Workers on a Ray cluster."""

import json
import math
import socket
from collections import deque
from collections.abc import Generator, Sequence
from dataclasses import asdict
from importlib import import_module
from statistics import median
from types import TracebackType
from typing import Any, Self

from crosstrack.campaign.runner import on_interrupt
from crosstrack.campaign.task import Done, Task, attempt, state
from crosstrack.errors import InputError, Problem

BATCH = 2.0
"""s of work, sent at once: far more than the milliseconds that sending takes"""
AHEAD = 2
"""batches for every core, so that none waits for its next"""
RECENT = 20
"""tasks whose times tell how long the next ones take"""
AUTO = "auto"
"""the address of whatever cluster this machine belongs to"""
PATIENCE = 10.0
"""s, until no one counts as listening"""
POLL = 0.2
"""s, between two looks at whether to stop"""


class Cluster:
    """Run tasks on a Ray cluster, in batches of a second or more; use it as a context manager.

    A worker that dies costs the one task it had: the others of its batch are sent again, alone.

    Args:
        address: of the cluster, as `ray start` tells it, such as 10.0.0.1:6379; or ray://HOST:PORT

    Raises:
        InputError: the package ray is missing, or there is no cluster at this address.
    """

    def __init__(self, address: str) -> None:
        try:
            self.ray: Any = import_module("ray")
        except ModuleNotFoundError:
            message = "needs the package ray: pip install 'crosstrack[cluster]'"
            raise InputError("cluster", [Problem(address, message)]) from None
        self.address = address
        self.stopped = False
        self.recent: deque[float] = deque(maxlen=RECENT)

    def __enter__(self) -> Self:
        """Connect to the cluster."""
        knock(self.address)
        try:
            self.ray.init(address=self.address, logging_level="ERROR", log_to_driver=False)
        except (ConnectionError, ValueError, RuntimeError, TimeoutError) as error:
            raise absent(self.address, " ".join(str(error).split())[:200]) from None
        self.cores = int(self.ray.cluster_resources().get("CPU", 0))
        self.batch = self.ray.remote(num_cpus=1, max_retries=0)(batch)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the cluster."""
        self.ray.shutdown()

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        """Yield what comes of every task as it finishes, see `Runner.run`.

        Raises:
            InputError: the cluster runs another Crosstrack.
        """
        self.stopped = False
        waiting, running = deque(tasks), dict[Any, list[Task]]()
        with on_interrupt(self.stop):
            try:
                while (waiting or running) and not self.stopped:
                    while waiting and len(running) < AHEAD * max(self.cores, 1):
                        self.send([waiting.popleft() for _ in range(self.size(len(waiting)))], running)
                    ready, _ = self.ray.wait(list(running), timeout=POLL)
                    for reference in ready:
                        yield from self.received(reference, running)
            finally:
                for reference in running:
                    self.ray.cancel(reference, force=True)
        if self.stopped:
            raise KeyboardInterrupt

    def stop(self) -> None:
        """Hand out no more tasks, and give up those that run."""
        self.stopped = True

    def size(self, waiting: int) -> int:
        """Return how many of the waiting tasks to send at once: by the time of recent ones, and some for every core."""
        if not self.recent:
            return 1
        worth = math.ceil(BATCH / max(median(self.recent), 1e-6))
        return max(1, min(worth, waiting, math.ceil(waiting / max(self.cores, 1))))

    def send(self, tasks: list[Task], running: dict[Any, list[Task]]) -> None:
        """Have tasks done one after another by one worker."""
        running[self.batch.remote(state(), [json.dumps(asdict(task)) for task in tasks])] = tasks

    def received(self, reference: Any, running: dict[Any, list[Task]]) -> Generator[Done, None, None]:
        """Yield what came of a batch; of one whose worker died, send all again, each alone."""
        tasks = running.pop(reference)
        try:
            answers = self.ray.get(reference)
        except self.ray.exceptions.RayTaskError as error:
            raise InputError("cluster", [Problem(self.address, f"cannot work: {error.cause or error}")]) from None
        except self.ray.exceptions.RayError as error:
            if len(tasks) > 1:
                for task in tasks:
                    self.send([task], running)
            else:
                yield Done(tasks[0].key, None, f"the worker died ({type(error).__name__})", 0.0)
            return
        for answer in answers:
            done = Done(**json.loads(answer))
            self.recent.append(done.seconds)
            yield done


def knock(address: str) -> None:
    """Ask whether anyone listens at an address, which Ray itself finds out in minutes.

    Raises:
        InputError: no one does, or this is no address.
    """
    host, colon, port = address.removeprefix("ray://").rpartition(":")
    if address == AUTO:
        return
    if not (host and colon and port.isdecimal()):
        message = f"must be HOST:PORT, ray://HOST:PORT, or {AUTO} for a cluster of this machine"
        raise InputError("cluster", [Problem(address, message)])
    try:
        socket.create_connection((host, int(port)), PATIENCE).close()
    except (OSError, OverflowError) as error:
        raise absent(address, str(error)) from None


def absent(address: str, reason: str) -> InputError:
    """Return the error of an address without a cluster."""
    return InputError("cluster", [Problem(address, f"there is no Ray cluster here: {reason}")])


def batch(source: str, tasks: list[str]) -> list[str]:
    """Do tasks in a worker of the cluster.

    Args:
        source: the state of the package that sends them
        tasks: as JSON

    Raises:
        InputError: this worker has another state of the package: its results would not be the same.
    """
    if source != state():
        raise InputError("worker", [Problem("", "it has another version of Crosstrack: install the same everywhere")])
    return [json.dumps(asdict(attempt(Task(**json.loads(task))))) for task in tasks]
