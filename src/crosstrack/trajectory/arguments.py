"""Arguments that may be anything, as what checks can look at."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crosstrack.types import Array


def is_number(value: Any) -> bool:
    """Return whether a value is one real number; NaN and infinity are."""
    return isinstance(value, int | float | np.integer | np.floating)


def as_numbers(value: ArrayLike) -> Array:
    """Return an argument as an array of numbers; a single NaN, which no check lets pass, where it is none."""
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        return np.array(np.nan)
    return array.astype(float) if array.dtype.kind in "biuf" else np.array(np.nan)
