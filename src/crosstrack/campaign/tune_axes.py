"""Which parameters of a tracker are tuned, and between what values."""

import math
import sys
from collections.abc import Sequence
from typing import Annotated, Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt

from crosstrack.campaign.tune_search import Axis
from crosstrack.errors import InputError, Problem
from crosstrack.mission.document import hints
from crosstrack.mission.parts import suggest
from crosstrack.mission.values import LARGEST

FACTOR = 5.0
"""a parameter is searched from its value over this to its value times this"""
FLAG = "--parameter"


def axes_of(tracker: Any, wanted: Sequence[str] = ()) -> list[Axis]:
    """Return the parameters to tune.

    Args:
        tracker: whose fields they are; their values are the present ones
        wanted: `NAME` or `NAME=LOW:HIGH`; without any, all that are positive, by annotation and at present

    Raises:
        InputError: everything that is wrong with what is wanted, or nothing can be tuned.
    """
    known = ranges(tracker)
    if not wanted:
        usual = [name for name, (low, _) in known.items() if low >= 0 and getattr(tracker, name) > 0]
        if not usual:
            message = f"no parameter of {type(tracker).__name__} is positive; known: {', '.join(known) or 'none'}"
            raise InputError(FLAG, [Problem("", message)])
        return [axis(tracker, name, known[name], None) for name in usual]
    problems: list[Problem] = []
    found: dict[str, Axis] = {}
    for text in wanted:
        try:
            made = asked(tracker, text, known)
        except InputError as error:
            problems += error.problems
            continue
        problems += [Problem(made.name, "is given twice")] if made.name in found else []
        found[made.name] = made
    if problems:
        raise InputError(FLAG, problems)
    return list(found.values())


def asked(tracker: Any, text: str, known: dict[str, tuple[float, float]]) -> Axis:
    """Return the parameter that `NAME` or `NAME=LOW:HIGH` asks for."""
    name, equals, given = text.partition("=")
    name = name.strip().removeprefix("tracker.")
    if name not in known:
        raise InputError(FLAG, [Problem(name or text, f"cannot be tuned; {suggest(name, list(known))}")])
    if not equals:
        return axis(tracker, name, known[name], None)
    low, colon, high = given.partition(":")
    try:
        span = float(low), float(high)
    except ValueError:
        colon = ""
    if not colon or not all(map(math.isfinite, span)):
        raise InputError(FLAG, [Problem(name, f"must be {name}=LOW:HIGH with two numbers, found {given!r}")])
    return axis(tracker, name, known[name], span)


def axis(tracker: Any, name: str, allowed: tuple[float, float], span: tuple[float, float] | None) -> Axis:
    """Return one parameter with the range it is searched in, by default around its value."""
    value, (least, most) = float(getattr(tracker, name)), allowed
    if span is None:
        if value <= 0:
            message = f"is {value:g} at present, and only what is positive has a range of its own: give {name}=LOW:HIGH"
            raise InputError(FLAG, [Problem(name, message)])
        return Axis(name, max(value / FACTOR, least), min(value * FACTOR, most), value)
    low, high = span
    if low >= high:
        raise InputError(FLAG, [Problem(name, f"must have LOW below HIGH, found {low:g}:{high:g}")])
    if low < least or high > most:
        raise InputError(FLAG, [Problem(name, f"must be {between(least, most)}, found {low:g}:{high:g}")])
    return Axis(name, low, high, value)


def ranges(part: Any) -> dict[str, tuple[float, float]]:
    """Return the numbers among the fields of a part, each with the least and the largest value allowed."""
    kind: Any = type(part)
    return {name: bounds(hint) for name, hint in hints(kind).items() if base_of(hint) is float}


def base_of(hint: Any) -> Any:
    """Return the type under annotations."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def bounds(hint: Any) -> tuple[float, float]:
    """Return the least and the largest number that the annotations of a type allow in a mission."""
    low, high = -LARGEST, LARGEST
    for mark in get_args(hint)[1:]:
        match mark:
            case Ge(limit):
                low = max(low, number(limit))
            case Gt(limit):
                low = max(low, math.nextafter(number(limit), math.inf))
            case Le(limit):
                high = min(high, number(limit))
            case Lt(limit):
                high = min(high, math.nextafter(number(limit), -math.inf))
    return low, high


def number(limit: Any) -> float:
    """Return the limit of an annotation, which may be of whatever can be compared; of a number it is one."""
    return float(limit)


def between(low: float, high: float) -> str:
    """Say what a range allows."""
    above = "above 0" if 0 < low < sys.float_info.min else f"from {low:.6g} on"
    return f"{above}, up to {high:.6g}"
