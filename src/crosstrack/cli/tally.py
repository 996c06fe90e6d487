"""How many flights of many are done, on standard error."""

import sys
import time
from types import TracebackType
from typing import Any, Self

from crosstrack.cli.watch import LINE_EVERY, say


class Tally:
    """Show how many are done: a bar in a terminal, a line now and then elsewhere."""

    def __init__(self, total: int, done: int = 0) -> None:
        self.total, self.before = total, done
        self.bar: Any = None
        self.due = time.monotonic() + LINE_EVERY

    def __enter__(self) -> Self:
        """Put the bar up, in a terminal."""
        if sys.stderr.isatty():
            self.bar = _bar()
            self.row = self.bar.add_task("", total=self.total, completed=self.before)
            self.bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the bar down."""
        if self.bar:
            self.bar.stop()

    def show(self, done: int, beside: str, line: str) -> None:
        """Show how many are done: with a text beside the bar, or as a line when one is due."""
        now = time.monotonic()
        if self.bar:
            self.bar.update(self.row, completed=done, description=beside)
        elif now >= self.due:
            self.due = now + LINE_EVERY
            say(line)


def _bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Bar(*columns, console=Console(stderr=True), transient=True)
