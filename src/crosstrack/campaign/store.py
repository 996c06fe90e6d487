"""Results on disk: a line of JSON for each, safe as soon as it is there."""

import json
import os
from contextlib import ExitStack
from dataclasses import asdict, fields
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from crosstrack.campaign.task import Done
from crosstrack.errors import InputError, Problem
from crosstrack.locks import lock

FIELDS = {field.name for field in fields(Done)}
BEGINS = b'{"key": "'
"""every line"""
LONGEST = 16_000_000
"""bytes of a line; a flight takes some 50 thousand"""


class Store:
    """A file of results that an interrupted campaign goes on from; use it as a context manager.

    Args:
        path: the file; it is made where it is missing

    Raises:
        InputError: it holds something else, or another campaign writes to it.
        OSError: it cannot be read or written.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.kept: dict[str, Done] = {}
        """what is on disk, by the key of its task; the last one counts"""
        self.file: BinaryIO = self.path.open("ab")
        with ExitStack() as unless_ours:
            unless_ours.callback(self.file.close)
            claim(self.file, self.path)
            self.file.truncate(self.load())
            unless_ours.pop_all()

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.file.close()

    def load(self) -> int:
        """Read what is there, and return the bytes of whole lines: one that was cut off is dropped."""
        whole = 0
        with self.path.open("rb") as file:
            for number, line in enumerate(iter(lambda: file.readline(LONGEST), b""), start=1):
                if len(line) < LONGEST and not line.endswith(b"\n") and line.startswith(BEGINS[: len(line)]):
                    break
                done = parsed(line)
                if done is None:
                    message = "is no result of a campaign: take it out, move the file away, or name another folder"
                    raise InputError(str(self.path), [Problem("", message, number)])
                self.kept[done.key] = done
                whole += len(line)
        return whole

    def add(self, done: Done) -> None:
        """Write a result, through to the disk."""
        self.file.write((json.dumps(asdict(done), allow_nan=False) + "\n").encode())
        self.file.flush()
        os.fsync(self.file.fileno())
        self.kept[done.key] = done


def parsed(line: bytes) -> Done | None:
    """Return the result that a line holds, None where it holds something else."""
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not (line.endswith(b"\n") and isinstance(value, dict) and value.keys() == FIELDS):
        return None
    kinds = isinstance(value["key"], str), isinstance(value["error"], str | None), isinstance(value["seconds"], float)
    return Done(**value) if all(kinds) else None


def claim(file: BinaryIO, path: Path) -> None:
    """Keep other campaigns off a file until it is closed; a process that is killed closes it too.

    Raises:
        InputError: another one has it.
    """
    try:
        lock(file, wait=False)
    except BlockingIOError:
        message = "another campaign is writing here: wait for it, or name another folder"
        raise InputError(str(path), [Problem("", message)]) from None
