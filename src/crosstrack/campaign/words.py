"""Trackers and winds as words, as a command line has them."""

import re
from collections.abc import Sequence
from typing import Any, cast, get_args, get_type_hints

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.frames import ned_from_enu
from crosstrack.mission.text import parse
from crosstrack.mission.values import LARGEST
from crosstrack.types import Wind

OWN = "mission"
"""the word for what the mission itself says"""
CALM = "calm"
GUSTS: tuple[str, ...] = get_args(get_type_hints(Wind)["gusts"])
SPLIT = re.compile(r",(?![^\[{]*[\]}])")
"""a comma that is not inside brackets"""


def tracker_words(text: str) -> list[str]:
    """Return the words of a list such as `carrot,carrot:lookahead=2,heading_gain=0.8,mission`.

    A piece that is NAME=VALUE belongs to the tracker before it.
    """
    words: list[str] = []
    for piece in (piece.strip() for piece in SPLIT.split(text)):
        if words and "=" in piece and ":" not in piece.partition("=")[0]:
            words[-1] += f",{piece}"
        else:
            words.append(piece)
    return words


def tracker_document(word: str) -> dict[str, Any] | None:
    """Return what a mission says for `NAME` or `NAME:FIELD=VALUE,...`; None for `mission`, its own tracker.

    Raises:
        InputError: it is not written like this.
    """
    name, colon, text = word.partition(":")
    if word == OWN:
        return None
    document: dict[str, Any] = {"kind": name}
    problems: list[Problem] = []
    for piece in SPLIT.split(text) if colon else ():
        field, equals, value = (part.strip() for part in piece.partition("="))
        if not (equals and field):
            problems.append(Problem(word, f"{piece!r} must be FIELD=VALUE, as in carrot:lookahead=2"))
        elif field in document:
            problems.append(Problem(word, f"{field} is given twice"))
        else:
            try:
                document[field] = parse(value, word).value
            except InputError as error:
                problems += [Problem(word, f"{field}: {problem.message}") for problem in error.problems]
    if not name:
        problems.append(Problem(word or "trackers", f"must be the name of a tracker, or {OWN}; found {word!r}"))
    if problems:
        raise InputError("trackers", problems)
    return document


def wind_of(word: str, frame: str) -> Wind | None:
    """Return the wind that `calm`, `E,N,U` or `E,N,U,GUSTS` says; None for `mission`, its own.

    Args:
        word: E, N, U are the velocity of the air, m/s
        frame: of the mission, enu or ned: the wind's too

    Raises:
        InputError: it is not written like this.
    """
    if word == OWN:
        return None
    *numbers, gusts = [piece.strip() for piece in ("0,0,0" if word == CALM else word).split(",")]
    if len(numbers) < 3:
        numbers, gusts = [*numbers, gusts], "none"
    try:
        mean = [float(number) for number in numbers]
    except ValueError:
        mean = []
    if len(mean) != 3 or gusts not in GUSTS or not all(abs(speed) <= LARGEST for speed in mean):
        known = f"with GUSTS one of {', '.join(GUSTS)}"
        message = f"must be {OWN}, {CALM}, E,N,U or E,N,U,GUSTS: the velocity of the air, m/s, {known}"
        raise InputError("wind", [Problem(word or "wind", f"{message}; found {word!r}")])
    east, north, up = ned_from_enu(np.array(mean)).tolist() if frame == "ned" else mean
    return Wind((east, north, up), cast(Any, gusts))


def distinct(words: Sequence[str]) -> list[str]:
    """Return words without repetition, in order."""
    return list(dict.fromkeys(words))
