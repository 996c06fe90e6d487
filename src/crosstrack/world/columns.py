"""Points as columns of numbers, in text and in binary."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import InputError
from crosstrack.types import Array
from crosstrack.world.files import refuse

AXES = ("x", "y", "z")


def check_axes(name: str, place: str, columns: list[str]) -> None:
    """Refuse a file without exactly one column for each axis."""
    wrong = [axis for axis in AXES if columns.count(axis) != 1]
    if wrong:
        found = ", ".join(columns) or "none"
        raise refuse(
            name,
            place,
            f"one each of x, y and z is needed; {', '.join(wrong)} is not there once among: {found}",
        )


def count(name: str, place: str, word: str) -> int:
    """Return the whole number, not negative, that a word of a header gives."""
    if not (word.isascii() and word.isdigit() and len(word) <= 18):
        raise refuse(name, place, f"{word!r} is not a whole number of at most 18 digits")
    return int(word)


def from_text(name: str, data: bytes, rows: int, columns: list[str], line: int) -> Array:
    """Return x, y, z (rows, 3) from lines of numbers.

    Args:
        name: of the file
        data: the lines
        rows: how many the header promises
        columns: names of the numbers of a line
        line: 1-based line of the file at which they start
    """
    lines = data.splitlines()
    if len(lines) < rows:
        raise refuse(name, f"line {line + len(lines)}", f"the file ends after {len(lines)} of {rows} points")
    table = [row.split() for row in lines[:rows]]
    short = next((i for i, row in enumerate(table) if len(row) < len(columns)), None)
    if short is not None:
        message = f"{len(table[short])} numbers where {len(columns)} are due: {', '.join(columns)}"
        raise refuse(name, f"line {line + short}", message)
    where = [columns.index(axis) for axis in AXES]
    try:
        return np.array([[row[i] for i in where] for row in table], dtype=np.bytes_).astype(float).reshape(-1, 3)
    except ValueError as error:
        raise _wrong_number(name, [[row[i] for i in where] for row in table], line) from error


def _wrong_number(name: str, table: list[list[bytes]], line: int) -> InputError:
    """Return the error about the first word of a table that is no number."""
    for row, words in enumerate(table):
        for word in words:
            try:
                np.array([word]).astype(float)
            except ValueError:
                return refuse(name, f"line {line + row}", f"must be a number, found {word.decode('latin-1')[:60]!r}")
    return refuse(name, f"from line {line}", "must be numbers")


def from_records(name: str, place: str, data: bytes, rows: int, record: "np.dtype[np.void]") -> Array:
    """Return x, y, z (rows, 3) from binary records with fields of these names."""
    needed = rows * record.itemsize
    if len(data) < needed:
        raise refuse(name, place, f"{rows} points of {record.itemsize} bytes need {needed}; {len(data)} are left")
    table = np.frombuffer(data, dtype=record, count=rows)
    return np.stack([floats(table[axis]) for axis in AXES], axis=1)


def floats(numbers: NDArray[np.generic]) -> Array:
    """Return numbers of any type as floats; of floats that are not numbers, none raises a warning."""
    with np.errstate(invalid="ignore"):
        return numbers.astype(float)
