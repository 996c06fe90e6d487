"""One piece of work of a campaign, and what came of it."""

import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from crosstrack import __version__
from crosstrack.errors import CrosstrackError


@dataclass(frozen=True)
class Task:
    """A function to call, and what with."""

    key: str
    """stands for the task wholly: another function, payload or state of this package has another key"""
    function: str
    """as `module:function`; it takes the payload and returns what JSON can hold"""
    payload: Mapping[str, Any]
    """what JSON can hold"""


@dataclass(frozen=True)
class Done:
    """What came of a task: a value or an error."""

    key: str
    """of the task"""
    value: Any | None
    """what its function returned; None where that failed"""
    error: str | None
    """why there is no value; None where there is one"""
    seconds: float
    """s of the machine that it took"""


def task(function: str, payload: Mapping[str, Any]) -> Task:
    """Return a task with its key.

    Args:
        function: as `module:function`
        payload: what JSON can hold

    Raises:
        TypeError, ValueError: the payload holds what JSON cannot.
    """
    said = json.dumps([function, payload, __version__, state()], sort_keys=True, allow_nan=False)
    return Task(hashlib.sha256(said.encode()).hexdigest()[:32], function, payload)


@cache
def state(name: str = "crosstrack") -> str:
    """Return a digest of the source of a package, or of a module alone: what it computes may change with it."""
    file = Path(str(import_module(name).__file__))
    package = file.parent
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")) if file.stem == "__init__" else [file]:
        digest.update(f"{path.relative_to(package).as_posix()}\n".encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def function_of(name: str) -> Callable[[Any], Any]:
    """Import and return the function of a task."""
    module, _, attribute = name.partition(":")
    found: Callable[[Any], Any] = getattr(import_module(module), attribute)
    return found


def attempt(task: Task) -> Done:
    """Do a task in this process; an exception becomes its error.

    The value is what a reader of its JSON gets, so that it is the same wherever the task is done.
    """
    began = time.perf_counter()
    value, error = None, None
    try:
        value = json.loads(json.dumps(function_of(task.function)(task.payload), allow_nan=False))
    except CrosstrackError as failure:
        error = str(failure)
    except Exception as failure:  # noqa: BLE001, RUF100 - whatever it is, it is the result of this task alone
        error = f"{type(failure).__name__}: {failure}"
    return Done(task.key, value, error, time.perf_counter() - began)
