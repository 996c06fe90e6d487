"""Tasks for workers: some do as they are told, some do not."""

import math
import os
import signal
import sys
import time
from pathlib import Path
from typing import Any

from crosstrack.campaign.task import Task, task
from crosstrack.errors import InputError, Problem


def chore(name: str, **payload: Any) -> Task:
    """Return the task of calling a function of this module."""
    return task(f"chores:{name}", payload)


def echo(payload: Any) -> Any:
    return payload


def root(payload: Any) -> float:
    return math.sqrt(payload["number"])


def pid(payload: Any) -> int:
    time.sleep(0.05)
    return os.getpid()


def fail(payload: Any) -> None:
    raise ValueError("no such luck")


def refuse(payload: Any) -> None:
    raise InputError("mission", [Problem("speed", "must be fast")])


def not_a_number(payload: Any) -> float:
    return float("nan")


def leave(payload: Any) -> None:
    os._exit(payload["code"])


def die(payload: Any) -> None:
    os.kill(os.getpid(), signal.Signals(payload["signal"]))
    time.sleep(60)


def speak(payload: Any) -> str:
    print("spoken")
    os.write(1, b"written\n")
    return sys.stdin.read()


def linger(payload: Any) -> None:
    """Tell the process in a file, and stay."""
    Path(payload["file"]).write_text(str(os.getpid()))
    time.sleep(60)
