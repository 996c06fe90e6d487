"""What a policy is, as a JSON document."""

import json
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Ge, Le, Len
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from crosstrack.errors import InputError, Problem

VERSION = 1
LONGEST = 1 << 20
"""characters of a card"""
MOST_LAYERS = 64
STRICT = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)
Count = Annotated[int, Ge(1), Le(1 << 24)]
Word = Annotated[str, Len(1, 80)]
Kind = Literal["mlp", "dueling", "cnn", "recurrent"]
"""of a network"""
MEANT = {
    "missing": "is required",
    "unexpected_keyword_argument": "unknown",
    "union_tag_not_found": "its kind is required: discrete or continuous",
    "union_tag_invalid": "its kind must be discrete or continuous",
}


@dataclass(frozen=True)
class Observation:
    """What a policy sees: float32 numbers, `size` of them."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    size: Count
    slices: tuple[tuple[Word, Count], ...]
    """names of its entries and how many there are of each, in order"""
    picture: tuple[Count, Count] | None = None
    """(height, width) px of the picture that comes first, row by row; None where there is none"""


@dataclass(frozen=True)
class Discrete:
    """An action that is one of `count`."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    count: Count
    kind: Literal["discrete"] = "discrete"


@dataclass(frozen=True)
class Continuous:
    """An action of `size` numbers in [-1, 1]."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    size: Count
    kind: Literal["continuous"] = "continuous"


@dataclass(frozen=True)
class Layer:
    """One layer of a network; its arrays are named after it.

    `dense`: `weight` (outputs, inputs), `bias` (outputs,). `convolution`: `weight` (channels, channels before, height,
    width), `bias` (channels,). `lstm`: `input` (4 units, inputs), `hidden` (4 units, units), `bias` (4 units,), in the
    order input gate, forget gate, cell, output gate.
    """

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.]{1,80}$")]
    """as in `trunk.0`, whose weights are the array `trunk.0.weight`"""
    kind: Literal["dense", "convolution", "lstm"]
    activation: Literal["none", "relu", "tanh"] = "none"
    """of what comes out; an LSTM has its own"""
    stride: Annotated[int, Ge(1), Le(1 << 12)] = 1
    """px, of a convolution"""
    stream: Literal["trunk", "value", "advantage"] = "trunk"
    """where it lies; value and advantage part behind the trunk"""


@dataclass(frozen=True)
class Card:
    """What a policy was trained for, how, and how well it does."""

    __pydantic_config__: ClassVar[ConfigDict] = STRICT

    task: Word
    options: dict[str, Any]
    """of the task"""
    observation: Observation
    action: Annotated[Discrete | Continuous, Field(discriminator="kind")]
    algorithm: Word
    network: Kind
    architecture: tuple[Layer, ...]
    """1 to 64 layers, in order: of the trunk, then of the two streams of a dueling network"""
    training: dict[str, Any]
    """how it came about: steps, seed, seconds, command, ..."""
    measured: dict[str, Any]
    """how well it did, and on what"""

    @property
    def outputs(self) -> int:
        """Return how many numbers the network gives."""
        return self.action.count if isinstance(self.action, Discrete) else self.action.size

    def document(self) -> dict[str, Any]:
        """Return this as plain values, its version first."""
        return {"version": VERSION, **asdict(self)}

    def to_json(self) -> str:
        """Write this as JSON; reading gives an equal card if `options`, `training` and `measured` are plain values.

        Raises:
            InputError: it holds values that JSON has not, such as NaN, or that `from_json` refuses.
        """
        try:
            text = json.dumps(self.document(), indent=1, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise InputError("card", [Problem("", str(error))]) from None
        from_json("card", text)
        return text


@cache
def adapter() -> TypeAdapter[Card]:
    """Return what reads cards."""
    return TypeAdapter(Card)


def from_json(name: str, text: str) -> Card:
    """Read a card.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    document = parse(name, text)
    version = document.pop("version", None)
    if type(version) is not int or version != VERSION:
        message = f"must be {VERSION}, the only one that is known; found {json.dumps(version):.40}"
        raise InputError(name, [Problem("version", message)])
    try:
        card = adapter().validate_json(json.dumps(document))
    except ValidationError as error:
        found = [problem(detail, document) for detail in error.errors(include_url=False)]
        raise InputError(name, found[:20]) from None
    if found := disagreements(card):
        raise InputError(name, found)
    return card


def parse(name: str, text: str) -> dict[str, Any]:
    """Return the mapping that JSON holds, with names that differ and numbers that are finite."""
    if len(text) > LONGEST:
        raise InputError(name, [Problem("", f"its card has {len(text)} characters; at most {LONGEST} are read")])
    try:
        value = json.loads(text, object_pairs_hook=unique, parse_constant=refuse, parse_float=finite)
    except (ValueError, RecursionError) as error:
        raise InputError(name, [Problem("", f"its card is not JSON that can be read: {error!s:.200}")]) from None
    if not isinstance(value, dict):
        raise InputError(name, [Problem("", "its card must be a mapping of names to values")])
    return value


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a mapping of pairs whose names differ."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is given twice")
    return found


def finite(word: str) -> float:
    """Return the number that a word says, which JSON lets be too large for a float."""
    value = float(word)
    return value if abs(value) < float("inf") else refuse(word)


def refuse(word: str) -> float:
    """Refuse what is no finite number."""
    raise ValueError(f"{word:.40} is not a finite number")


def problem(detail: Any, document: Any) -> Problem:
    """Return what pydantic says as a problem; its place as it is in the document, without the tags of unions."""
    place, value = "", document
    for key in detail["loc"]:
        if isinstance(value, list) and isinstance(key, int):
            place, value = f"{place}[{key}]", value[key] if key < len(value) else None
        elif isinstance(value, dict) and (key in value or key == detail["loc"][-1]):
            place, value = f"{place}.{key}" if place else str(key), value.get(key)
    told = detail["msg"]
    message = MEANT.get(detail["type"], f"{told[0].lower()}{told[1:]}")
    known = detail["type"] in {"missing", "unexpected_keyword_argument"}
    return Problem(place[:80], message if known else f"{message}, found {json.dumps(detail['input']):.60}")


def disagreements(card: Card) -> list[Problem]:
    """Return where the numbers of a card do not add up."""
    seen, found, layers = card.observation, list[Problem](), len(card.architecture)
    if not 1 <= layers <= MOST_LAYERS:
        found.append(Problem("architecture", f"must be 1 to {MOST_LAYERS} layers, found {layers}"))
    total = sum(count for _, count in seen.slices)
    if total != seen.size:
        found.append(Problem("observation.slices", f"must add up to the size, {seen.size}; found {total}"))
    if seen.picture and seen.picture[0] * seen.picture[1] > seen.size:
        message = f"must have at most {seen.size} pixels, the size; found {seen.picture[0]} x {seen.picture[1]}"
        found.append(Problem("observation.picture", message))
    return found
