"""The rule that a vehicle does one move at a time: a new one cancels the one under way, which answers at once."""

from collections.abc import Callable

from crosstrack.airsim.server.moves.polling import Move

NEVER = 2**63 - 1
"""ns, when nothing is to wake"""


class Task:
    """A move under way, and its answer.

    Args:
        move: a generator of the times to sleep
        done: called once, with the answer and None, or with None and what the move raised
    """

    def __init__(self, move: Move, done: Callable[[bool | None, Exception | None], None]) -> None:
        self.move, self.done = move, done
        self.wake = NEVER
        self.over = False

    def resume(self, now: int, on: bool | None = True) -> None:
        """Let it go on at a time (ns), or stop; None to begin."""
        try:
            # A generator that has not begun takes nothing but None.
            pause = self.move.send(on)  # type: ignore[arg-type]
        except StopIteration as end:
            self._finish(end.value, None)
        except Exception as error:  # whatever stops a move is the answer to who asked for it
            self._finish(None, error)
        else:
            self.wake = now + round(pause * 1e9)

    def _finish(self, value: bool | None, error: Exception | None) -> None:
        self.over, self.wake = True, NEVER
        self.done(value, error)


class Slot:
    """The one move of a vehicle."""

    def __init__(self) -> None:
        self.task: Task | None = None

    @property
    def wake(self) -> int:
        """ns, when the move wants to go on"""
        return NEVER if self.task is None else self.task.wake

    def begin(self, move: Move, now: int, done: Callable[[bool | None, Exception | None], None]) -> None:
        """Start a move at a time (ns), after cancelling the one under way."""
        self.cancel(now)
        task = self.task = Task(move, done)
        task.resume(now, None)
        self._drop(task)

    def cancel(self, now: int) -> None:
        """Stop the move under way, if there is one: it is woken and told."""
        task = self.task
        while task is not None and not task.over:
            task.resume(now, False)
        self._drop(task)

    def wake_up(self, now: int) -> None:
        """Let the move go on where it wants to by now (ns)."""
        task = self.task
        if task is not None and task.wake <= now:
            task.resume(now)
            self._drop(task)

    def _drop(self, task: Task | None) -> None:
        if task is not None and task.over and self.task is task:
            self.task = None
