"""Trajectories written and read: exact, strict, and never more than one clear error."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.trajectory.files.csv_file import COLUMNS, to_csv
from crosstrack.trajectory.files.formats import from_bytes
from crosstrack.trajectory.files.json_file import HEAD, KEYS, to_json
from crosstrack.trajectory.files.sound import MOST_BYTES, MOST_PIECES, TOLD
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial

CURVE = minimum(np.array([[0, 0, 10], [4, 1, 9], [5, 6, 11], [0.1, 0.2, 0.3]]), [0, 1.7, 3.1, 9.3], 4)
WRITERS: dict[str, Callable[[PiecewisePolynomial], str]] = {".json": to_json, ".csv": to_csv}


def told(name: str, text: str) -> list[str]:
    """Return the problems of a file."""
    with pytest.raises(InputError) as caught:
        from_bytes(name, text.encode())
    assert caught.value.source == name
    return [str(problem) for problem in caught.value.problems]


def changed(**values: Any) -> str:
    """Return the JSON of a good trajectory with some values changed; None leaves one out."""
    document = json.loads(to_json(CURVE)) | values
    return json.dumps({name: value for name, value in document.items() if value is not None})


def cells(row: int, column: int, value: str) -> str:
    """Return the CSV of a good trajectory with one cell changed; row 0 is the header."""
    rows = [line.split(",") for line in to_csv(CURVE).splitlines()]
    rows[row][column] = value
    return "\n".join(map(",".join, rows))


@pytest.mark.parametrize("ending", WRITERS)
@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32),
    pieces=st.integers(1, 5),
    degree=st.integers(1, 7),
    scale=st.sampled_from([1e-3, 1.0, 1e5]),
)
def test_a_round_trip_gives_the_same_bits(ending: str, seed: int, pieces: int, degree: int, scale: float) -> None:
    random = np.random.default_rng(seed)
    durations = 10 ** random.uniform(-3, 1, pieces)
    coefficients = scale * random.normal(size=(pieces, degree + 1, 3))
    coefficients /= durations[:, None, None] ** np.arange(degree + 1)[:, None]
    for i in range(1, pieces):  # each piece begins where the one before ends
        powers = durations[i - 1] ** np.arange(degree + 1)
        coefficients[i, 0] = powers @ coefficients[i - 1]
    curve = PiecewisePolynomial(durations, coefficients)
    again = from_bytes(f"a{ending}", WRITERS[ending](curve).encode())
    assert again.durations.tobytes() == durations.tobytes()
    padded = np.zeros((pieces, again.degree + 1, 3))
    padded[:, : degree + 1] = coefficients
    assert again.coefficients.tobytes() == padded.tobytes()


def test_json_says_what_it_is() -> None:
    document = json.loads(to_json(CURVE))
    assert tuple(document) == KEYS
    assert document["frame"] == "enu"
    assert document["version"] == 1
    np.testing.assert_array_equal(document["coefficients"], CURVE.coefficients)
    assert to_json(CURVE).count("\n") < 30


def test_csv_is_laid_out_as_uav_trajectories_lays_it_out() -> None:
    table = np.loadtxt(to_csv(CURVE).splitlines(), delimiter=",", skiprows=1)  # as its readers do
    assert table.shape == (3, 33)
    np.testing.assert_array_equal(table[:, 0], CURVE.durations)
    t = 0.9
    for axis in range(3):
        ascending = table[0, 1 + 8 * axis : 9 + 8 * axis]
        assert np.polynomial.polynomial.polyval(t, ascending) == pytest.approx(CURVE(t)[axis], rel=1e-12)
    assert (table[:, 25:] == 0).all()


def test_csv_of_others_is_read() -> None:
    numbers = ["1.5", "0", "2", *["0"] * 30]
    text = "﻿" + ", ".join(COLUMNS).lower() + ",\r\n" + ",".join(numbers) + ",\r\n\r\n"
    curve = from_bytes("Figure8.CSV", text.encode())
    assert curve.duration == 1.5
    np.testing.assert_array_equal(curve(1.0), [2, 0, 0])


def test_csv_has_no_degree_above_7() -> None:
    curve = PiecewisePolynomial(np.array([1.0]), np.ones((1, 9, 3)))
    with pytest.raises(InputError, match="must be at most 7, found 8"):
        to_csv(curve)
    assert from_bytes("a.json", to_json(curve).encode()).degree == 8


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("", ["not JSON that can be read"]),
        ("[1]", ["must be a mapping with format, version"]),
        ("[" * 100_000, ["not JSON that can be read"]),
        ("1" * 10_000, ["not JSON that can be read"]),
        ('{"format": 1, "format": 2}', ["not JSON that can be read: a name is given twice"]),
        (changed(version=2), ["version: must be 1, found 2"]),
        (changed(version=True), ["version: must be 1, found True"]),
        (changed(frame="ned", color="red"), ["color: unknown; known: format", "frame: must be \"enu\", found 'ned'"]),
        (changed(units=None, durations=None), ["units: is required", "durations: is required"]),
        (changed(durations=[]), ["durations: must be a list of 1 to 100000 numbers, found []"]),
        (changed(durations=3), ["durations: must be a list of 1 to 100000 numbers, found 3"]),
        (changed(durations=[1, 2]), ["coefficients: must be a list of 2 pieces, as durations is"]),
        (changed(durations=[1, "2", None]), ["durations[1]: must be a number, found '2'", "durations[2]: "]),
        (changed(durations=[1, True, 3]), ["durations[1]: must be a number, found True"]),
        (changed(durations=[1, -2, 3]), ["durations[1]: must be between 1e-06 and 1e+06 s, found -2"]),
        (changed(durations=[1, 0, 1e300]), ["durations[1]: must be between", "durations[2]: must be between"]),
        (changed(durations=[float("nan"), 2, 3]), ["durations[0]: must be between 1e-06 and 1e+06 s, found nan"]),
        (changed(coefficients=[1, 2, 3]), ["coefficients[0]: must be a list of 2 to 10 rows [x, y, z]"]),
        (changed(coefficients=[[[0, 0, 0]]] * 3), ["coefficients[0]: must be a list of 2 to 10 rows"]),
        (
            changed(coefficients=[[[0, 0, 0], [0, 0]], [[0, 0, "1"]] * 2, 3]),
            [
                "coefficients[0][1]: must be 3 numbers [x, y, z], found [0, 0]",
                "coefficients[1][0]: must be 3 numbers [x, y, z], found [0, 0, '1']",
                "coefficients[1][1]: must be 3 numbers",
                "coefficients[2]: must be a list of 2 rows, as coefficients[0] is, found 3",
            ],
        ),
        (
            changed(durations=[1.0], coefficients=[[[0, 0, 0], [0, 0, 10**400]]]),
            ["coefficients[0][1]: must be 3 numbers"],
        ),
        (
            changed(durations=[1.0], coefficients=[[[0, 0, 0], [0, float("inf"), 0]]]),
            ["coefficients[0]: must be finite numbers"],
        ),
        (
            changed(durations=[1e3], coefficients=[[[0, 0, 0], [0, 0, 2e6]]]),
            ["coefficients[0]: must stay within 1e+09 m of the origin on every axis, may reach 2e+09"],
        ),
        (
            changed(durations=[1, 1], coefficients=[[[0, 0, 0], [1, 0, 0]], [[1, 0, 0.5], [1, 0, 0]]]),
            ["coefficients[1]: begins 0.5 m from where the piece before ends; at most 0.001 m"],
        ),
    ],
)
def test_wrong_json_is_told_with_its_places(text: str, messages: list[str]) -> None:
    found = told("a.json", text)
    assert len(found) == len(messages)
    for problem, message in zip(found, messages, strict=True):
        assert problem.startswith(message)


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("", ["header: must name the 33 columns Duration, x^0, x^1, ... yaw^7"]),
        (cells(0, 3, "x3"), ["line 1: header: must name the 33 columns"]),
        (cells(0, 0, "Duration").splitlines()[0], ["must hold 1 to 100000 rows below the header"]),
        (cells(2, 5, "one"), ["line 3: x^4: must be a number, found 'one'"]),
        (cells(2, 5, ""), ["line 3: x^4: must be a number, found ''"]),
        (cells(2, 5, "1,2"), ["line 3: row: must hold 33 numbers, found 34"]),
        (cells(1, 0, "-1"), ["line 2: Duration: must be between 1e-06 and 1e+06 s, found -1"]),
        (cells(1, 1, "inf"), ["line 2: coefficients: must be finite numbers"]),
        (cells(3, 32, "0.1"), ["line 4: yaw: a yaw that turns is not flown: its coefficients must be 0"]),
        (cells(3, 1, "77"), ["line 4: coefficients: begins 72 m from where the piece before ends"]),
        ("1," * 100_000, ["line 1: row: must hold 8192 characters at most"]),
        ('"' + ("a" * 8000 + "\n") * 20, ["not CSV: field larger than field limit"]),
    ],
)
def test_wrong_csv_is_told_with_its_lines(text: str, messages: list[str]) -> None:
    found = told("a.csv", text)
    assert len(found) == len(messages)
    for problem, message in zip(found, messages, strict=True):
        assert problem.startswith(message)


def test_other_endings_sizes_and_encodings_are_refused() -> None:
    assert told("a.txt", "") == ["the name of a trajectory must end in .json or .csv"]
    with pytest.raises(InputError, match="not UTF-8 text: byte 0"):
        from_bytes("a.json", b"\xff")
    with pytest.raises(InputError, match=f"at most {MOST_BYTES} are read"):
        from_bytes("a.csv", b" " * (MOST_BYTES + 1))
    rows = "\n".join([",".join(COLUMNS), *["0," * 32 + "0"] * (MOST_PIECES + 1)])
    assert told("a.csv", rows)[0].startswith("must hold 1 to 100000 rows")


def test_what_is_told_of_one_file_is_bounded() -> None:
    rows = "\n".join([",".join(COLUMNS), *["x"] * 1000])
    assert len(told("a.csv", rows)) == TOLD
    assert len(told("a.json", changed(durations=[1] * 50, coefficients=[[0] * 4] * 50))) == TOLD


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(KEYS) | st.text(max_size=3), inner),
    max_leaves=12,
)


@settings(max_examples=150)
@given(
    values=st.dictionaries(st.sampled_from(["durations", "coefficients", "version"]), junk),
    data=st.binary(max_size=40),
    at=st.integers(0, 2000),
)
def test_junk_is_one_error_or_a_sound_curve(values: dict[str, Any], data: bytes, at: int) -> None:
    good_csv = to_csv(CURVE).encode()
    files = {
        "a.json": json.dumps({**HEAD, "durations": [1.0], "coefficients": [[[0, 0, 0], [1, 0, 0]]], **values}).encode(),
        "b.json": data,
        "b.csv": good_csv[:at] + data + good_csv[at:],
    }
    for name, contents in files.items():
        try:
            curve = from_bytes(name, contents)
        except InputError:
            continue
        assert np.isfinite(curve(np.linspace(0, curve.duration, 20))).all()
        assert (curve.durations > 0).all()
