"""A worker process: reads tasks as JSON lines on standard input and answers in JSON lines on standard output."""

import json
import os
import signal
import threading
from dataclasses import asdict
from queue import SimpleQueue
from typing import IO

from crosstrack.campaign.task import Task, attempt


def main() -> None:
    """Do task after task until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends its workers
    requests, answers = moved()
    tasks: SimpleQueue[Task] = SimpleQueue()
    threading.Thread(target=listen, args=(requests, tasks), daemon=True).start()
    while True:
        done = attempt(tasks.get())
        answers.write(json.dumps(asdict(done)) + "\n")
        answers.flush()


def moved() -> tuple[IO[str], IO[str]]:
    """Return the channels to the parent, moved away from where tasks read and print.

    What a task prints goes to standard error, and it has nothing to read.
    """
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return requests, answers


def listen(requests: IO[str], tasks: "SimpleQueue[Task]") -> None:
    """Pass tasks on; when the parent is gone, or wants no more, end at once, also in the middle of a task."""
    for line in requests:
        tasks.put(Task(**json.loads(line)))
    os._exit(0)


if __name__ == "__main__":
    main()
