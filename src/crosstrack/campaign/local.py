"""Workers on this machine: processes that are sent tasks as lines of JSON."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import asdict
from queue import SimpleQueue
from types import TracebackType
from typing import IO, Self

from crosstrack.campaign.runner import on_interrupt
from crosstrack.campaign.task import Done, Task
from crosstrack.errors import InputError, Problem

COMMAND = (sys.executable, "-P", "-m", "crosstrack.campaign.worker")
SINGLE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
"""set to 1 in workers: there is one for every core already"""
MOST = 1024
"""workers at once"""


class Local:
    """Run tasks in worker processes of this machine.

    A worker that dies costs the one task it had, and another takes its place.

    Args:
        workers: how many at once, from 1 to 1024; by default one for every core that this process may use

    Raises:
        InputError: fewer or more workers.
    """

    def __init__(self, workers: int | None = None) -> None:
        if workers is not None and not 1 <= workers <= MOST:
            raise InputError("workers", [Problem("", f"must be from 1 to {MOST}, found {workers}")])
        self.workers = [Worker() for _ in range(workers or cores())]
        self.idle: SimpleQueue[Worker] = SimpleQueue()
        for worker in self.workers:
            self.idle.put(worker)
        self.stopped = False

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the workers."""
        self.stop()
        for worker in self.workers:
            worker.bury()

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        """Yield what comes of every task as it finishes, see `Runner.run`."""
        self.stopped = False
        left = len(tasks)
        with on_interrupt(self.stop), ThreadPoolExecutor(len(self.workers)) as threads:
            try:
                for future in as_completed([threads.submit(self.do, task) for task in tasks]):
                    left -= 1
                    if (done := future.result()) is not None:
                        yield done
            finally:
                if left:  # no one waits for the others
                    self.stop()
        if self.stopped:
            raise KeyboardInterrupt

    def do(self, task: Task) -> Done | None:
        """Have a worker do a task; None where everything was stopped first."""
        worker, began = self.idle.get(), time.perf_counter()
        try:
            if self.stopped:
                return None
            worker.start()
            if self.stopped:  # perhaps before this one had started
                return None
            done = worker.do(task)
        finally:
            self.idle.put(worker)
        if done is None and not self.stopped:
            return Done(task.key, None, f"the worker died: {worker.last_words}", time.perf_counter() - began)
        return done

    def stop(self) -> None:
        """Hand out no more tasks, and end the workers with what they are doing."""
        self.stopped = True
        for worker in self.workers:
            worker.kill()


class Worker:
    """One worker process, started when it is needed."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[str] | None = None
        self.killed = False
        """whether the process was told to end, which it may not have done yet"""
        self.last_words = ""
        """how the process before this one ended"""

    def start(self) -> None:
        """Start the process, unless it runs."""
        if self.process is not None and (self.killed or self.process.poll() is not None):
            self.bury()
        if self.process is None:
            self.killed = False
            self.process = subprocess.Popen(
                COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8", env=environment()
            )

    def do(self, task: Task) -> Done | None:
        """Send a task and wait for the answer; None where the process died instead."""
        assert self.process is not None
        requests, answers = pipes(self.process)
        try:
            requests.write(json.dumps(asdict(task)) + "\n")
            requests.flush()
            line = answers.readline()
        except BrokenPipeError:
            line = ""
        if line.endswith("\n"):
            return Done(**json.loads(line))
        self.bury()
        return None

    def kill(self) -> None:
        """End the process at once, if it runs."""
        process = self.process
        if process is not None:
            self.killed = True
            process.kill()

    def bury(self) -> None:
        """Wait for the process to end, and note how it did."""
        process, self.process = self.process, None
        if process is None:
            return
        requests, answers = pipes(process)
        with suppress(BrokenPipeError):  # what it was not sent, it needs no more
            requests.close()
        answers.close()
        self.last_words = ending(process.wait())


def pipes(process: "subprocess.Popen[str]") -> tuple[IO[str], IO[str]]:
    """Return standard input and output of a worker."""
    assert process.stdin is not None
    assert process.stdout is not None
    return process.stdin, process.stdout


def ending(code: int) -> str:
    """Say how a process ended, from its return code."""
    if code >= 0:
        return f"exit code {code}"
    return f"killed by signal {-code} ({signal.strsignal(-code) or 'unknown'})"


def environment() -> dict[str, str]:
    """Return the environment of workers: they find the modules that this process finds."""
    found = os.pathsep.join(path or os.getcwd() for path in sys.path)
    return os.environ | dict.fromkeys(SINGLE, "1") | {"PYTHONPATH": found}


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
