"""What does the tasks of a campaign."""

import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Protocol, Self

from crosstrack.campaign.task import Done, Task


class Runner(Protocol):
    """Something that does tasks side by side; its workers stay warm from one `run` to the next."""

    def __enter__(self) -> Self:
        """Return itself; workers start when there is work."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let the workers go."""

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        """Yield what comes of every task as it finishes, in any order.

        Raises:
            KeyboardInterrupt: Ctrl-C; all that finished before it has been yielded.
        """


@contextmanager
def on_interrupt(stop: Callable[[], None]) -> Iterator[None]:
    """Call `stop` on Ctrl-C instead of raising KeyboardInterrupt anywhere, so that nothing that finished is lost.

    Where there is another handler, or outside the main thread, nothing is changed.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, lambda number, frame: stop())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
