"""Files of policies: the same bits back, and every kind of damage refused with one clear error."""

import io
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from policies import CARD, CARDS, observations, policy, weights

from crosstrack.errors import InputError
from crosstrack.policy.card import Card, Continuous, Discrete, Layer
from crosstrack.policy.file import MOST_BYTES, from_bytes, load, save, shipped, to_bytes
from crosstrack.policy.policy import Policy


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(CARDS)), st.integers(0, 2**32 - 1))
def test_policies_are_read_as_they_were_written(kind: str, seed: int) -> None:
    written = policy(kind, seed)
    data = to_bytes(written)
    read = from_bytes("best.npz", data)
    assert read.card == written.card
    assert read.arrays.keys() == written.arrays.keys()
    for name, array in read.arrays.items():
        assert array.dtype == np.float32
        np.testing.assert_array_equal(array, written.arrays[name])
    seen = observations(written.card, 3)
    first, second = written.values(seen, written.start(3)), read.values(seen, read.start(3))
    np.testing.assert_array_equal(first[0], second[0])
    assert to_bytes(read) == data


def test_a_file_is_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "best.npz"
    save(policy("mlp"), path)
    save(policy("recurrent"), str(path))
    assert load(path).card.network == "recurrent"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(InputError):
        save(Policy(replace(CARD, measured={"speed": float("nan")}), weights(CARD)), path)
    assert load(str(path)).card.network == "recurrent"
    assert list(tmp_path.iterdir()) == [path]


def test_a_write_that_fails_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "best.npz" / "full").mkdir(parents=True)
    with pytest.raises(OSError, match=r"best\.npz"):
        save(policy("mlp"), tmp_path / "best.npz")
    assert list(tmp_path.iterdir()) == [tmp_path / "best.npz"]


def test_numpy_reads_a_policy_without_unpickling(tmp_path: Path) -> None:
    save(policy("mlp"), tmp_path / "best.npz")
    with np.load(tmp_path / "best.npz", allow_pickle=False) as file:
        assert bytes(file["card"]).decode() == CARD.to_json()
        assert file["a.weight"].shape == (6, 5)


def test_flying_needs_no_learning_library(tmp_path: Path) -> None:
    save(policy("mlp"), tmp_path / "best.npz")
    script = f"""
import sys, numpy
from crosstrack.policy import file
made = file.load({str(tmp_path / "best.npz")!r})
made.decide(numpy.zeros(5, numpy.float32), made.start())
print({{"torch", "gymnasium", "stable_baselines3", "onnx", "numba", "scipy"}} & set(sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_names_alone_mean_policies_that_ship_with_the_package() -> None:
    for name in shipped():
        data = (resources.files("crosstrack.policy") / "trained" / f"{name}.npz").read_bytes()
        assert load(name).card == from_bytes(name, data).card
    with pytest.raises(InputError, match="no such policy ships") as caught:
        load("pqo")
    assert all(name in str(caught.value) for name in shipped())


@pytest.mark.parametrize("path", ["none.npz", ".npz", "best.onnx", "folder/ppo", "", "..", "../trained/ppo"])
def test_what_is_not_there_is_refused(path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match="no such"):
        load(path)


def test_a_folder_is_no_policy(tmp_path: Path) -> None:
    (tmp_path / "best.npz").mkdir()
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / "best.npz")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "best.npz").open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(InputError, match=f"{MOST_BYTES + 1} bytes; at most {MOST_BYTES}"):
        load(tmp_path / "best.npz")
    with pytest.raises(InputError, match=f"{MOST_BYTES + 1} bytes; at most {MOST_BYTES}"):
        from_bytes("best.npz", bytes(MOST_BYTES + 1))


def packed(arrays: Mapping[str, Any], pickled: bool = False) -> bytes:
    out = io.BytesIO()
    np.savez(out, allow_pickle=pickled, **arrays)
    return out.getvalue()


def held() -> dict[str, Any]:
    """Return the arrays of a sound file, the card among them."""
    with np.load(io.BytesIO(to_bytes(policy("mlp")))) as file:
        return dict(file)


def changed(**arrays: Any) -> bytes:
    """Return a file with some arrays put in place of others, or left out where they are None."""
    all_of_them = held() | {name.replace("__", "."): array for name, array in arrays.items()}
    return packed({name: array for name, array in all_of_them.items() if array is not None})


def raw(name: str, data: bytes) -> bytes:
    """Return a sound file in which the file of one array is another."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(to_bytes(policy("mlp")))) as old, zipfile.ZipFile(out, "w") as new:
        for member in old.namelist():
            new.writestr(member, data if member == f"{name}.npy" else old.read(member))
    return out.getvalue()


def header(shape: str, kind: str = "<f4", length: int = 0) -> bytes:
    """Return the file of an array whose header claims a shape, with some bytes behind it."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + bytes(length)


def bomb() -> bytes:
    """Return a small file that unpacks to more than is allowed."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.weight.npy", bytes(MOST_BYTES + 1))
    return out.getvalue()


def twice() -> bytes:
    out = io.BytesIO(to_bytes(policy("mlp")))
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(out, "a") as archive:
        archive.writestr("a.bias.npy", header("(6,)", length=24))
    return out.getvalue()


def squeezed() -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("card.npy", header("(6,)", length=24))
    return out.getvalue()


DAMAGED: dict[str, tuple[Callable[[], bytes], list[str]]] = {
    "empty": (lambda: b"", ["not an npz file"]),
    "truncated": (lambda: to_bytes(policy("mlp"))[:-100], ["not an npz file"]),
    "half": (lambda: to_bytes(policy("mlp"))[: len(to_bytes(policy("mlp"))) // 2], ["not an npz file"]),
    "pickle": (lambda: packed(held() | {"a.bias": np.array([{}] * 6)}, pickled=True), ["a.bias", "|O"]),
    "double": (lambda: changed(a__bias=np.zeros(6)), ["a.bias", "must be float32", "float64"]),
    "big-endian": (lambda: changed(a__bias=np.zeros(6, ">f4")), ["a.bias", "must be float32", ">f4"]),
    "text": (lambda: changed(a__bias=np.array(["x"])), ["a.bias", "must hold numbers"]),
    "record": (lambda: changed(a__bias=np.zeros(6, [("x", "f4")])), ["a.bias", "must hold numbers"]),
    "huge": (lambda: raw("a.bias", header(f"({10**15},)")), ["a.bias", str(4 * 10**15), "holds 0"]),
    "beyond": (lambda: raw("a.bias", header(f"(0, {10**17}, {10**17})")), ["a.bias", "shape"]),
    "code": (lambda: raw("a.bias", header("(__import__('os').abort(),)")), ["a.bias", "must hold numbers"]),
    "no header": (lambda: raw("a.bias", b"\x93NUMPY"), ["a.bias", "not an array"]),
    "bomb": (bomb, [f"at most {MOST_BYTES}"]),
    "twice": (twice, ["two arrays of one name"]),
    "squeezed": (squeezed, ["not packed as numpy does it"]),
    "missing": (lambda: changed(a__bias=None), ["a.bias: is missing"]),
    "stray": (lambda: changed(c__bias=np.zeros(3, np.float32)), ["c.bias: belongs to no layer"]),
    "not a number": (lambda: changed(a__bias=np.full(6, np.nan, np.float32)), ["a.bias: must be finite, found nan"]),
    "infinite": (lambda: changed(a__bias=np.full(6, -np.inf, np.float32)), ["a.bias: must be finite, found -inf"]),
    "flat": (lambda: changed(a__weight=np.zeros(30, np.float32)), ["a.weight", "(6, 5)", "(30,)"]),
    "transposed": (lambda: changed(a__weight=np.zeros((5, 6), np.float32)), ["a.weight", "(6, 5)", "(5, 6)"]),
    "deep bias": (lambda: changed(a__bias=np.zeros((6, 1), np.float32)), ["a.bias", "(outputs,)", "(6, 1)"]),
    "nothing": (lambda: changed(a__bias=np.zeros(0, np.float32)), ["a.bias", "(outputs,)", "(0,)"]),
    "no card": (lambda: changed(card=None), ["card: this array is needed"]),
    "card as floats": (lambda: changed(card=np.zeros(5)), ["card: this array is needed"]),
    "card not text": (lambda: changed(card=np.array([255], np.uint8)), ["card: is not UTF-8", "byte 0"]),
    "card no JSON": (lambda: changed(card=np.frombuffer(b"{", np.uint8)), ["not JSON"]),
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_file_gives_one_clear_error(name: str, tmp_path: Path) -> None:
    make, words = DAMAGED[name]
    path = tmp_path / "best.npz"
    path.write_bytes(make())
    with pytest.raises(InputError) as caught:
        load(path)
    assert caught.value.source == str(path)
    assert len(caught.value.problems) == 1, str(caught.value)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_all_that_is_wrong_with_the_arrays_is_told_at_once() -> None:
    data = changed(
        a__bias=None, b__weight=np.full((3, 6), np.nan, np.float32), b__bias=np.zeros(3), d=np.zeros(1, np.float32)
    )
    with pytest.raises(InputError) as caught:
        from_bytes("best.npz", data)
    assert {problem.place for problem in caught.value.problems} == {"a.bias", "b.weight", "b.bias", "d"}


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 255))
def test_a_byte_that_is_off_does_no_harm(place: int, change: int) -> None:
    data = bytearray(to_bytes(policy("mlp")))
    data[place % len(data)] ^= change
    try:
        read = from_bytes("best.npz", bytes(data))
    except InputError:
        return
    for name, array in policy("mlp").arrays.items():  # it was in a date or another field that says nothing
        np.testing.assert_array_equal(read.arrays[name], array)


LAYERS: dict[str, tuple[Card, list[str]]] = {
    "no output for the action": (replace(CARD, action=Continuous(4)), ["b.bias", "(4,)", "(3,)"]),
    "a convolution without a picture": (
        replace(CARDS["cnn"], observation=replace(CARDS["cnn"].observation, picture=None)),
        ["architecture[0]", "needs a picture"],
    ),
    "a picture smaller than the convolution": (
        replace(CARDS["cnn"], observation=replace(CARDS["cnn"].observation, picture=(2, 9))),
        ["c.weight", "no larger than what enters, 2 x 9"],
    ),
    "convolutions behind layers": (
        replace(CARDS["cnn"], architecture=(*CARD.architecture, *CARDS["cnn"].architecture[:2])),
        ["convolutions come before"],
    ),
    "one stream of two": (replace(CARDS["dueling"], architecture=CARDS["dueling"].architecture[:3]), ["go together"]),
    "streams for continuous actions": (replace(CARDS["dueling"], action=Continuous(7)), ["discrete"]),
    "a trunk behind streams": (
        replace(CARDS["dueling"], architecture=CARDS["dueling"].architecture[::-1]),
        ["the trunk comes before"],
    ),
    "an LSTM at the end": (
        replace(CARDS["recurrent"], architecture=CARDS["recurrent"].architecture[:2]),
        ["last layer must be dense"],
    ),
    "an LSTM in a stream": (
        replace(
            CARDS["dueling"],
            architecture=(*CARDS["dueling"].architecture[:3], Layer("x", "lstm", stream="advantage")),
        ),
        ["belongs in the trunk"],
    ),
    "two layers of one name": (
        replace(CARD, architecture=(*CARD.architecture, CARD.architecture[1])),
        ["two layers have the array 'b.bias'"],
    ),
}


@pytest.mark.parametrize("name", LAYERS)
def test_architectures_that_cannot_be_are_refused(name: str) -> None:
    card, words = LAYERS[name]
    kind = next(kind for kind in ("dueling", "recurrent", "cnn", "mlp") if card.network == kind)
    with pytest.raises(InputError) as caught:
        Policy(card, policy(kind).arrays)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_an_lstm_whose_arrays_do_not_fit_is_refused() -> None:
    made = policy("recurrent")
    for name, shape in {"l.0.bias": (15,), "l.0.hidden": (16, 3), "l.0.input": (16, 6), "l.1.input": (16, 5)}.items():
        with pytest.raises(InputError) as caught:
            Policy(made.card, {**made.arrays, name: np.zeros(shape, np.float32)})
        assert [problem.place for problem in caught.value.problems] == [name]


def test_a_convolution_whose_arrays_do_not_fit_is_refused() -> None:
    made = policy("cnn")
    for shape in [(3, 2, 3, 2), (4, 1, 3, 2), (3, 1, 6), (3, 1, 0, 2), (3, 1, 12, 2)]:
        with pytest.raises(InputError) as caught:
            Policy(made.card, {**made.arrays, "c.weight": np.zeros(shape, np.float32)})
        assert [problem.place for problem in caught.value.problems] == ["c.weight"]


def test_a_policy_of_choices_needs_as_many_outputs() -> None:
    with pytest.raises(InputError, match=r"y\.bias"):
        Policy(replace(CARDS["dueling"], action=Discrete(8)), policy("dueling").arrays)
