"""Trajectories as JSON: exact, and with their frame and units said."""

import json
from typing import Any

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.files.sound import MOST_DEGREE, MOST_PIECES, TOLD, curve_of, in_space
from crosstrack.trajectory.polynomial import PiecewisePolynomial

HEAD = {
    "format": "crosstrack trajectory",
    "version": 1,
    "frame": "enu",
    "units": {"durations": "s", "coefficients": "m/s^power of local time, ascending, rows of x, y, z"},
}
KEYS = (*HEAD, "durations", "coefficients")


def to_json(curve: PiecewisePolynomial) -> str:
    """Write a trajectory as JSON, a line for every piece; reading gives the same bits.

    Raises:
        InputError: the curve is not in space.
    """
    if found := in_space(curve):
        raise InputError("to_json", found)
    head = json.dumps(HEAD, indent=2).removesuffix("\n}")
    durations = json.dumps(curve.durations.tolist())
    pieces = ",\n    ".join(map(json.dumps, curve.coefficients.tolist()))
    return f'{head},\n  "durations": {durations},\n  "coefficients": [\n    {pieces}\n  ]\n}}\n'


def from_json(name: str, text: str) -> PiecewisePolynomial:
    """Read a trajectory from JSON.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    try:
        value = json.loads(text, object_pairs_hook=unique)
    except (ValueError, RecursionError) as error:
        raise InputError(name, [Problem("", f"not JSON that can be read: {error!s:.200}")]) from None
    problems = head_problems(value)
    if not problems:
        problems = shape_problems(value["durations"], value["coefficients"])
    if problems:
        raise InputError(name, problems[:TOLD])
    durations, coefficients = np.array(value["durations"], float), np.array(value["coefficients"], float)
    return curve_of(name, durations, coefficients, locate)


def locate(piece: int, what: str) -> tuple[str, None]:
    """Return the place of a piece's duration or coefficients."""
    return f"{'durations' if what == 'duration' else 'coefficients'}[{piece}]", None


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a mapping of pairs whose names differ."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is given twice")
    return found


def head_problems(value: Any) -> list[Problem]:
    """Return what is wrong with the names, and with the values that are always the same."""
    if not isinstance(value, dict):
        return [Problem("", f"must be a mapping with {', '.join(KEYS)}")]
    return [
        *(Problem(key, "is required") for key in KEYS if key not in value),
        *(Problem(f"{key:.40}", f"unknown; known: {', '.join(KEYS)}") for key in value if key not in KEYS),
        *(
            Problem(key, f"must be {json.dumps(wanted)}, found {brief(value[key])}")
            for key, wanted in HEAD.items()
            if key in value and (value[key] != wanted or value[key] is True)
        ),
    ]


def shape_problems(durations: Any, coefficients: Any) -> list[Problem]:
    """Return where durations and coefficients are not numbers (pieces,) and (pieces, powers, 3)."""
    if not isinstance(durations, list) or not 1 <= len(durations) <= MOST_PIECES:
        return [Problem("durations", f"must be a list of 1 to {MOST_PIECES} numbers, found {brief(durations)}")]
    if not isinstance(coefficients, list) or len(coefficients) != len(durations):
        message = f"must be a list of {len(durations)} pieces, as durations is, found {brief(coefficients)}"
        return [Problem("coefficients", message)]
    found = [
        Problem(f"durations[{i}]", f"must be a number, found {brief(duration)}")
        for i, duration in enumerate(durations)
        if not is_number(duration)
    ]
    terms = len(coefficients[0]) if isinstance(coefficients[0], list) else 0
    if not 2 <= terms <= MOST_DEGREE + 1:
        rows = f"2 to {MOST_DEGREE + 1} rows [x, y, z], one for each power"
        return [*found, Problem("coefficients[0]", f"must be a list of {rows}, found {brief(coefficients[0])}")]
    for i, piece in enumerate(coefficients):
        found += piece_problems(i, piece, terms)
        if len(found) >= TOLD:
            break
    return found


def piece_problems(number: int, piece: Any, terms: int) -> list[Problem]:
    """Return where the coefficients of one piece are not numbers (terms, 3)."""
    place = f"coefficients[{number}]"
    if not isinstance(piece, list) or len(piece) != terms:
        return [Problem(place, f"must be a list of {terms} rows, as coefficients[0] is, found {brief(piece)}")]
    return [
        Problem(f"{place}[{power}]", f"must be 3 numbers [x, y, z], found {brief(row)}")
        for power, row in enumerate(piece)
        if not (isinstance(row, list) and len(row) == 3 and all(map(is_number, row)))
    ]


def is_number(value: Any) -> bool:
    """Return whether a value can be a float; true and false cannot."""
    return isinstance(value, float) or (type(value) is int and abs(value) < 10**300)


def brief(value: Any) -> str:
    """Return a value as a message shows it."""
    if isinstance(value, list) and len(value) > 3:
        return f"a list of {len(value)}"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
