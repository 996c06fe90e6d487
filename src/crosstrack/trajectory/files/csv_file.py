"""Trajectories as CSV, in the layout of the `uav_trajectories` tools, which Crazyflies fly.

A row for every piece: its duration, then the coefficients of x, y, z and yaw, ascending in local time up to the
seventh power. Numbers have as many digits as give the same bits back.
"""

import csv
from collections.abc import Sequence

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.trajectory.files.sound import MOST_PIECES, TOLD, curve_of, in_space
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Array

TERMS = 8
"""coefficients for each axis"""
COLUMNS = ("Duration", *(f"{axis}^{power}" for axis in ("x", "y", "z", "yaw") for power in range(TERMS)))
TURNING = 1 + 3 * TERMS
"""the first column of the yaw"""
LONGEST_LINE = 8192
"""characters, ten times what numbers need"""
ROWS = f"must hold 1 to {MOST_PIECES} rows below the header, one for each piece"


def to_csv(curve: PiecewisePolynomial) -> str:
    """Write a trajectory as CSV; the yaw is zero.

    Raises:
        InputError: a degree above 7, which the layout does not have, or a curve that is not in space.
    """
    pieces, terms, dimensions = curve.coefficients.shape
    found = in_space(curve)
    if terms > TERMS:
        found.append(Problem("degree", f"must be at most {TERMS - 1}, found {terms - 1}"))
    if found:
        raise InputError("to_csv", found)
    table = np.zeros((pieces, 4, TERMS))
    table[:, :dimensions, :terms] = curve.coefficients.transpose(0, 2, 1)
    rows = np.column_stack([curve.durations, table.reshape(pieces, -1)]).tolist()
    return "\n".join([",".join(COLUMNS), *(",".join(map(repr, row)) for row in rows), ""])


def from_csv(name: str, text: str) -> PiecewisePolynomial:
    """Read a trajectory from CSV; the yaw must be zero.

    Raises:
        InputError: everything that is wrong with it, each with its line and column.
    """
    lines = text.splitlines()
    long = [number for number, line in enumerate(lines, 1) if len(line) > LONGEST_LINE]
    if long:
        raise InputError(name, [Problem("row", f"must hold {LONGEST_LINE} characters at most", long[0])])
    if (count := sum(bool(line.strip()) for line in lines) - 1) > MOST_PIECES:
        raise InputError(name, [Problem("", f"{ROWS}, found {count}")])
    try:
        rows = [(number, trimmed(row)) for number, row in enumerate(csv.reader(lines), 1)]
    except csv.Error as error:
        raise InputError(name, [Problem("", f"not CSV: {error}")]) from None
    rows = [(number, row) for number, row in rows if row]
    if not rows or [cell.lower() for cell in rows[0][1]] != [column.lower() for column in COLUMNS]:
        wanted = f"must name the {len(COLUMNS)} columns {', '.join(COLUMNS[:3])}, ... {COLUMNS[-1]}"
        raise InputError(name, [Problem("header", wanted, rows[0][0] if rows else None)])
    if len(rows) < 2:
        raise InputError(name, [Problem("", f"{ROWS}, found 0")])
    table = numbers(name, rows[1:])
    coefficients = table[:, 1:TURNING].reshape(-1, 3, TERMS).transpose(0, 2, 1)

    def locate(piece: int, what: str) -> tuple[str, int]:
        return ("Duration" if what == "duration" else what), rows[1 + piece][0]

    return curve_of(name, table[:, 0].copy(), np.ascontiguousarray(coefficients), locate)


def trimmed(row: list[str]) -> list[str]:
    """Return the cells of a row without the empty one that a comma at its end makes."""
    cells = [cell.strip() for cell in row]
    return cells[:-1] if cells and not cells[-1] else cells


def numbers(name: str, rows: Sequence[tuple[int, list[str]]]) -> Array:
    """Return the cells below the header as numbers (rows, columns).

    Raises:
        InputError: cells that are none, a row that is too short or too long, a yaw that turns.
    """
    table, problems = np.zeros((len(rows), len(COLUMNS))), list[Problem]()
    for index, (line, row) in enumerate(rows):
        if len(row) != len(COLUMNS):
            problems.append(Problem("row", f"must hold {len(COLUMNS)} numbers, found {len(row)}", line))
            continue
        for column, cell in enumerate(row):
            try:
                table[index, column] = float(cell)
            except ValueError:
                problems.append(Problem(COLUMNS[column], f"must be a number, found {cell[:40]!r}", line))
        if table[index, TURNING:].any():
            problems.append(Problem("yaw", "a yaw that turns is not flown: its coefficients must be 0", line))
        if len(problems) >= TOLD:
            break
    if problems:
        raise InputError(name, problems[:TOLD])
    return table
