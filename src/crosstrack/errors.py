"""One root for every error of the library; each carries its evidence."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass


class CrosstrackError(Exception):
    """Root of the errors a caller may want to catch."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong with an input."""

    place: str
    """where, as `tracker.lookahead` or `route[2]`"""
    message: str
    """the value found and what is allowed"""
    line: int | None = None
    """1-based line of the file, where known"""

    def __str__(self) -> str:
        where = f"line {self.line}: " if self.line is not None else ""
        return f"{where}{self.place}: {self.message}" if self.place else f"{where}{self.message}"


class InputError(CrosstrackError):
    """An input that cannot be used, with everything that is wrong with it.

    Args:
        source: the file, flag or array at fault
        problems: all that is wrong, never empty
    """

    def __init__(self, source: str, problems: list[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        count = f"{len(problems)} problems" if len(problems) > 1 else "1 problem"
        super().__init__("\n".join([f"{source}: {count}", *(f"  {problem}" for problem in problems)]))


class Infeasible(CrosstrackError):  # noqa: N818 - the field's word for it
    """A sound question that has no answer, with what stands in the way.

    Args:
        source: what was asked
        problems: which constraints contradict one another, where, and by how much; never empty
    """

    def __init__(self, source: str, problems: list[Problem]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__("\n".join([f"{source}: infeasible", *(f"  {problem}" for problem in problems)]))


class Unreachable(Infeasible):
    """There is no way to a goal: obstacles enclose it, or leave no gap wide enough."""


@contextmanager
def reported_by(source: str) -> Iterator[None]:
    """Name the function that was called, not one that it calls, as the source of errors; also as a decorator."""
    try:
        yield
    except (InputError, Infeasible) as error:
        if error.source == source:
            raise
        raise type(error)(source, list(error.problems)) from None


class LinkLost(CrosstrackError):  # noqa: N818 - the field's word for it
    """The vehicle no longer answers."""
