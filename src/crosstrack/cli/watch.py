"""What is said, and listened to, while a flight is flown."""

import os
import signal
import sys
import time
from types import FrameType
from typing import Any

from crosstrack.cli.codes import INTERRUPTED
from crosstrack.flight.effort import Effort
from crosstrack.flight.observer import Sample
from crosstrack.flight.plan import Plan
from crosstrack.types import Outcome

LINE_EVERY = 5.0
"""s of the machine, between two lines where there is no terminal"""
FRAME_EVERY = 0.1
"""s of the machine, between two frames of the bar"""


def say(text: str) -> None:
    """Print a line on standard error."""
    print(text, file=sys.stderr, flush=True)


class Progress:
    """Show how far a flight has come: a bar in a terminal, a line now and then elsewhere."""

    def __init__(self, plan: Plan) -> None:
        self.length = plan.course.path.length
        self.bar: Any = None
        self.due = 0.0

    def begin(self, plan: Plan) -> None:
        """Announce the flight."""
        say(f"Flying {plan.name}: course {self.length:.1f} m, planned for {plan.course.speed.duration:.1f} s.")
        self.due = time.monotonic() + LINE_EVERY
        if sys.stderr.isatty():
            self.bar = _bar()
            self.task = self.bar.add_task("", total=self.length)
            self.bar.start()
            self.due = 0.0

    def sample(self, row: Sample) -> None:
        """Show the progress when it is due."""
        now = time.monotonic()
        if now < self.due:
            return
        self.due = now + (FRAME_EVERY if self.bar else LINE_EVERY)
        if self.bar:
            self.bar.update(self.task, completed=row.progress, description=f"{row.time:7.1f} s")
        else:
            say(f"{row.time:.1f} s flown, {row.progress:.1f} of {self.length:.1f} m")

    def end(self, outcome: Outcome, effort: Effort) -> None:
        """Take the bar down and say how it ended."""
        if self.bar:
            self.bar.stop()
        say(f"{outcome.value} ({effort.flying:.1f} s to compute)")


def _bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} of {task.total:.0f} m"),
    )
    return Bar(*columns, console=Console(stderr=True), transient=True)


class Interrupt:
    """End the flight between two samples on the first Ctrl-C; a second one breaks off at once, later or not.

    Acting only between samples keeps the log whole.
    """

    def __init__(self) -> None:
        self.asked = False

    def __enter__(self) -> "Interrupt":
        self.previous = signal.signal(signal.SIGINT, self.note)
        return self

    def __exit__(self, *reason: object) -> None:
        if not self.asked:
            signal.signal(signal.SIGINT, self.previous)

    def note(self, number: int, frame: FrameType | None) -> None:
        """Remember the first signal, and exit at the second.

        No exception is raised out of the blue: Python exits with another code where one passes through `exec`.
        """
        if self.asked:
            say("interrupted")
            os._exit(INTERRUPTED)
        self.asked = True

    def begin(self, plan: Plan) -> None:
        """Nothing to do."""

    def sample(self, row: Sample) -> None:
        """End the flight where that was asked for."""
        if self.asked:
            raise KeyboardInterrupt

    def end(self, outcome: Outcome, effort: Effort) -> None:
        """Nothing to do."""
