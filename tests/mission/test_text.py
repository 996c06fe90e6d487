"""YAML as plain values with lines."""

import math
from pathlib import Path

import pytest
import yaml

from crosstrack.errors import InputError
from crosstrack.mission import text
from crosstrack.mission.text import parse, read_text, scalar, show


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("1e-3", 0.001), ("1.", 1.0), (".5", 0.5), ("-2", -2), ("+3", 3), ("010", 10), ("0x1F", 31), ("0o17", 15),
        ("-.inf", -math.inf), ("true", True), ("FALSE", False), ("~", None), ("", None), ("null", None),
        ("no", "no"), ("yes", "yes"), ("on", "on"), ("12:30", "12:30"), ("1_000", "1_000"), ("1e", "1e"),
        ("NaN", "NaN"), ("2020-01-02", "2020-01-02"),
    ],
)  # fmt: skip
def test_plain_scalars_mean_what_yaml_1_2_says(written: str, meant: object) -> None:
    found = scalar(written)
    assert found == meant
    assert type(found) is type(meant)
    assert parse(f"key: {written}", "test").value == {"key": meant}


def test_quotes_make_text() -> None:
    assert parse("{a: '1', b: \"true\", c: 1}", "test").value == {"a": "1", "b": "true", "c": 1}


def test_lines_are_those_of_the_file() -> None:
    document = parse("speed: 5\n\nroute:\n  - [1, 2]\n  - [3,\n     4]\n", "test")
    assert document.lines[("speed",)] == 1
    assert document.lines[("route",)] == 3
    assert document.lines[("route", 1)] == 5
    assert document.lines[("route", 1, 1)] == 6


def test_json_reads_as_yaml() -> None:
    assert parse('{"route": [[1.5, -2e3], []], "a\\u00e4": null}', "test").value == {
        "route": [[1.5, -2000.0], []],
        "aä": None,
    }


def test_anchors_are_followed() -> None:
    assert parse("a: &low [0, 0]\nb: *low\n", "test").value == {"a": [0, 0], "b": [0, 0]}


BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n" for k in range(8)
)


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("a: 1\na: 2\n", "line 2: a: given twice, first on line 1"),
        ("a: {b: 1, b: 2}", "a.b: given twice"),
        ("a: [1, 2", "line 2: not YAML"),
        ("a: !!python/object:os.system x", "YAML tags are not used here"),
        ("a: !!binary aGk=", "YAML tags are not used here"),
        ("[1, 2]: 3", "a key must be a plain name"),
        ("a: 1\n---\nb: 2\n", "not YAML"),
        ("a: \x07", "not YAML"),
        ("[" * 40 + "]" * 40, "nested deeper than 32 levels"),
        ("[" * 100_000, "line 1: is nested deeper than 32 levels"),
        ("- " * 100_000, "line 1: is nested deeper than 32 levels"),
        ("{a: " * 100_000, "line 1: is nested deeper than 32 levels"),
        ("[" + "1," * 1_050_000, "more than 500000 values"),
        ("a: &a [*a]", "nested deeper"),
        (BOMB, "more than 500000 values"),
        ("a: " + " " * text.MAX_BYTES, "larger than 4000000 bytes"),
    ],
)
def test_what_is_wrong_is_said(written: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse(written, "test")


def test_two_doubled_keys_are_both_reported() -> None:
    with pytest.raises(InputError) as caught:
        parse("a: 1\na: 2\nb: 3\nb: 4\n", "test")
    assert [problem.line for problem in caught.value.problems] == [2, 4]


def test_without_the_compiled_parser_the_values_are_the_same() -> None:
    class Slow(yaml.SafeLoader):
        yaml_implicit_resolvers = {}  # noqa: RUF012 - as in the module

    written = "a: [1, {b: no}]\nc: 'x'\n"
    node = yaml.compose(written, Loader=Slow)
    assert node is not None
    assert text._Walk().value(node, ()) == parse(written, "test").value


def test_places_read_as_paths() -> None:
    assert show(("world", "shapes", 2, "box", "min", 0)) == "world.shapes[2].box.min[0]"
    assert show(()) == ""


def test_files_that_cannot_be_read_are_input_errors(tmp_path: Path) -> None:
    (tmp_path / "latin.yaml").write_bytes(b"name: caf\xe9")
    (tmp_path / "big.yaml").write_bytes(b" " * (text.MAX_BYTES + 1))
    for path, message in [
        (tmp_path / "none.yaml", "No such file"),
        (tmp_path, "Is a directory"),
        (tmp_path / "latin.yaml", "not UTF-8 text: byte 9"),
        (tmp_path / "big.yaml", "larger than"),
        (Path("a\0b"), "null byte"),
    ]:
        with pytest.raises(InputError, match=message):
            read_text(path)


def test_a_byte_order_mark_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_bytes(b"\xef\xbb\xbfa: 1")
    assert read_text(tmp_path / "m.yaml") == "a: 1"
