"""Mission files as text: YAML (and so JSON) to plain values, with the line of each."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from crosstrack.errors import InputError, Problem

MAX_BYTES = 4_000_000
"""largest mission or plan file that is read"""
MAX_VALUES = 500_000
"""most values in one mission file, counted with aliases followed"""
MAX_DEPTH = 32
"""deepest nesting"""

Place = tuple[str | int, ...]

INTEGER = re.compile(r"[-+]?[0-9]{1,300}|0x[0-9a-fA-F]{1,200}|0o[0-7]{1,300}")
FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
WORDS: dict[str, bool | None] = {"": None, "~": None}
for _word, _value in (("null", None), ("true", True), ("false", False)):
    WORDS.update({_word: _value, _word.capitalize(): _value, _word.upper(): _value})


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # whichever there is
    """A safe loader that leaves every plain scalar as text, for `scalar` to read."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 - replaces the parent's table


@dataclass(frozen=True)
class Document:
    """What a file says, not yet checked."""

    source: str
    """name of the file, for messages"""
    value: Any
    """dicts, lists, str, int, float, bool and None"""
    lines: Mapping[Place, int] = field(default_factory=dict)
    """1-based line of each value by its place, where a mapping's value has its key's; 0 for one not from the file"""


def show(place: Place) -> str:
    """Write a place as `tracker.lookahead` or `route[2]`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
    return text.removeprefix(".")


def scalar(text: str) -> Any:
    """Read a plain scalar by YAML 1.2's core schema: `1e-3` is a number, `no` and `12:30` are text."""
    if text in WORDS:
        return WORDS[text]
    if INTEGER.fullmatch(text):
        return int(text, 0) if text[:2] in {"0x", "0o"} else int(text)
    if FLOAT.fullmatch(text):
        return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
    return text


class _Walk:
    """Turn YAML nodes into values, noting lines and problems."""

    def __init__(self) -> None:
        self.lines: dict[Place, int] = {}
        self.problems: list[Problem] = []
        self.count = 0

    def value(self, node: yaml.Node, place: Place) -> Any:
        self.count += 1
        self.lines.setdefault(place, node.start_mark.line + 1)
        if self.count > MAX_VALUES:
            raise InputError("", [_too_many()])
        if len(place) > MAX_DEPTH:
            raise InputError("", [Problem(show(place[:3]), f"is nested deeper than {MAX_DEPTH} levels")])
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, place)
        if isinstance(node, yaml.SequenceNode):
            return [self.value(child, (*place, index)) for index, child in enumerate(node.value)]
        if node.tag != "tag:yaml.org,2002:str":
            self.complain(node, place, f"YAML tags are not used here, found {node.tag}")
        quoted = isinstance(node, yaml.ScalarNode) and node.style
        return node.value if quoted else scalar(node.value)

    def mapping(self, node: yaml.MappingNode, place: Place) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, child in node.value:
            if not isinstance(key, yaml.ScalarNode):
                self.complain(key, place, "a key must be a plain name")
                continue
            inner = (*place, key.value)
            if key.value in found:
                self.complain(key, inner, f"given twice, first on line {self.lines[inner]}")
                continue
            self.lines[inner] = key.start_mark.line + 1
            found[key.value] = self.value(child, inner)
        return found

    def complain(self, node: yaml.Node, place: Place, message: str) -> None:
        self.problems.append(Problem(show(place), message, node.start_mark.line + 1))


def parse(text: str, source: str) -> Document:
    """Read YAML text.

    Raises:
        InputError: not YAML, a key given twice, a tag, or larger than the limits of this module.
    """
    if len(text) > MAX_BYTES:
        raise InputError(source, [Problem("", f"is larger than {MAX_BYTES} bytes")])
    walk = _Walk()
    try:
        _measure(text)
        node = yaml.compose(text, Loader=_Loader)
        value = None if node is None else walk.value(node, ())
    except yaml.YAMLError as error:
        raise InputError(source, [_syntax(error)]) from None
    except InputError as error:
        raise InputError(source, list(error.problems)) from None
    if walk.problems:
        raise InputError(source, walk.problems)
    return Document(source, value, walk.lines)


def _measure(text: str) -> None:
    """Refuse text that is too deep or too long, event by event: the composer would overflow the stack.

    Raises:
        InputError: over `MAX_DEPTH` or `MAX_VALUES`.
    """
    depth = count = 0
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        elif isinstance(event, yaml.NodeEvent):
            count += 1
            depth += isinstance(event, yaml.CollectionStartEvent)
        if depth > MAX_DEPTH + 1:
            line = event.start_mark.line + 1 if event.start_mark is not None else None
            raise InputError("", [Problem("", f"is nested deeper than {MAX_DEPTH} levels", line)])
        if count > 2 * MAX_VALUES:
            raise InputError("", [_too_many()])


def _too_many() -> Problem:
    return Problem("", f"holds more than {MAX_VALUES} values")


def _syntax(error: yaml.YAMLError) -> Problem:
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        problem = str(error.problem).replace("character '\\t'", "a tab")
        return Problem("", f"not YAML: {problem}", error.problem_mark.line + 1)
    return Problem("", f"not YAML: {str(error).splitlines()[0]}")


def read_text(path: Path) -> str:
    """Read a text file of at most `MAX_BYTES`.

    Raises:
        InputError: missing, unreadable, too large or not UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            raise InputError(str(path), [Problem("", f"is larger than {MAX_BYTES} bytes")])
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(str(path), [Problem("", f"is not UTF-8 text: byte {error.start}")]) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(str(path), [Problem("", f"cannot be read: {reason}")]) from None
