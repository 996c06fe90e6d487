"""A training as it goes on, drawn in the terminal."""

import time
from types import TracebackType
from typing import Any

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

HEIGHT, WIDTH = 8, 60
"""of the curve, in characters"""
BLOCKS = " ▁▂▃▄▅▆▇█"
EVERY = 0.5
"""s, between two pictures"""


class Curve:
    """Shows success by decisions, and how long it will take; lines where there is no terminal."""

    def __init__(self, console: Console, asked: Any) -> None:
        self.console, self.asked = console, asked
        self.live = Live(console=console, auto_refresh=False) if console.is_terminal else None
        self.told, self.shown = 0, 0.0
        self.begun: tuple[float, int] | None = None

    def __enter__(self) -> "Curve":
        if self.live:
            self.live.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.live:
            self.live.__exit__(kind, error, trace)

    def show(self, progress: Any) -> None:
        """Show how far a training has come."""
        now = time.monotonic()
        if self.begun is None:
            self.begun = now, progress.steps
        if self.live and now - self.shown > EVERY:
            self.shown = now
            self.live.update(self.drawn(progress, now), refresh=True)
        for row in progress.history[self.told :] if not self.live else ():
            speed = f"{row['speed']:.2f} m/s" if row["speed"] is not None else "none arrived"
            self.console.print(
                f"{row['steps']:>12,} decisions, {row['seconds']:.0f} s: success {row['success']:.1%}, "
                f"collided {row['collided']:.1%}, {speed}"
            )
        self.told = len(progress.history)

    def drawn(self, progress: Any, now: float) -> Group:
        """Return the picture."""
        assert self.begun is not None
        flown, passed = progress.steps - self.begun[1], now - self.begun[0]
        rate = flown / passed if passed > 0 else 0.0
        left = max(0, self.asked.steps - progress.steps) / rate if rate > 0 else 0.0
        recent = progress.recent
        table = Table.grid(padding=(0, 2))
        table.add_row("decisions", f"{progress.steps:,} of {self.asked.steps:,}", f"{rate:,.0f} a second")
        table.add_row("time", f"{progress.seconds / 60:.1f} min", f"{left / 60:.1f} min left")
        if recent:
            table.add_row("training", f"success {recent['success']:.1%}", f"reward {recent['reward']:.1f}")
        rows = [one["success"] for one in progress.history]
        if rows:
            table.add_row("held out", f"success {rows[-1]:.1%}", f"best {max(rows):.1%}")
        return Group(table, ProgressBar(self.asked.steps, progress.steps, width=WIDTH + 5), plotted(rows))


def plotted(values: list[float]) -> Text:
    """Return shares by time as columns of blocks, 100 % at the top."""
    if not values:
        return Text("")
    columns = [values[int(k * len(values) / WIDTH)] for k in range(WIDTH)] if len(values) > WIDTH else values
    lines = []
    for row in range(HEIGHT, 0, -1):
        cells = "".join(BLOCKS[round(8 * min(1.0, max(0.0, value * HEIGHT - (row - 1))))] for value in columns)
        label = {HEIGHT: "100%", 1: "  0%"}.get(row, "    ")
        lines.append(f"{label} {cells}")
    return Text("\n".join(lines))
