"""Documents made in Python, brought to what a file could hold."""

import math
from typing import Any

import numpy as np

from crosstrack.errors import Problem
from crosstrack.mission.text import MAX_DEPTH, Place, show

LARGEST = 1e9
"""largest size of a number in a mission, in whatever unit"""


def sound(value: Any, problems: list[Problem], place: Place = ()) -> Any:
    """Return a copy in dicts, lists, text, numbers, bool and None; tuples and arrays become lists.

    What a file could not hold is left out and added to `problems`.
    """
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if len(place) > MAX_DEPTH:
        problems.append(Problem(show(place[:3]), f"is nested deeper than {MAX_DEPTH} levels"))
        return None
    if isinstance(value, dict):
        names = [name for name in value if not isinstance(name, str) or not _encodes(name)]
        problems += [Problem(show(place), f"{name!r:.40} is no name") for name in names]
        return {name: sound(inner, problems, (*place, name)) for name, inner in value.items() if name not in names}
    if isinstance(value, list | tuple):
        return [sound(inner, problems, (*place, index)) for index, inner in enumerate(value)]
    if value is None or isinstance(value, bool | float) or (isinstance(value, int) and abs(value) < 10**300):
        return value
    if isinstance(value, str) and _encodes(value):
        return value
    kind = f"{type(value).__name__} that no file can hold" if isinstance(value, int | str) else type(value).__name__
    problems.append(Problem(show(place), f"must be a number, text, true or false, found {kind}"))
    return None


def tamed(value: Any, extremes: dict[Place, float], place: Place = ()) -> Any:
    """Return a copy with NaN for numbers beyond `LARGEST`, which are noted in `extremes`; seeds are free."""
    if isinstance(value, dict):
        return {name: tamed(inner, extremes, (*place, name)) for name, inner in value.items()}
    if isinstance(value, list):
        return [tamed(inner, extremes, (*place, index)) for index, inner in enumerate(value)]
    if isinstance(value, int | float) and LARGEST < abs(value) < math.inf and place[-1:] != ("seed",):
        extremes[place] = value
        return math.nan
    return value


def _encodes(text: str) -> bool:
    """Return whether text can be written to a file: it has no lone surrogates."""
    return not any("\ud800" <= letter <= "\udfff" for letter in text)
