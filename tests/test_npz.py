"""Arrays of npz files; damage is in the tests of what is read from them, clouds and policies."""

import io
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as some

from crosstrack import npz
from crosstrack.errors import InputError

KINDS = some.integer_dtypes(endianness="?") | some.unsigned_integer_dtypes(endianness="?")
NUMBERS = some.arrays(
    KINDS | some.floating_dtypes(endianness="?", sizes=(16, 32, 64)), some.array_shapes(min_dims=0, min_side=0)
)
NAMES = st.text("abcz.09_ /", min_size=1, max_size=8).filter(lambda name: name not in {"file", "allow_pickle"})


def packed(arrays: dict[str, Any], squeeze: bool = False) -> bytes:
    out = io.BytesIO()
    (np.savez_compressed if squeeze else np.savez)(out, **arrays)
    return out.getvalue()


@settings(max_examples=100)
@given(st.dictionaries(NAMES, NUMBERS, max_size=4), st.booleans(), st.booleans())
def test_arrays_come_back_with_the_same_bits(arrays: dict[str, Any], squeeze: bool, columns: bool) -> None:
    if columns:
        arrays = {name: np.asfortranarray(array) for name, array in arrays.items()}
    found = npz.arrays("file", packed(arrays, squeeze), 1 << 20)
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        assert (found[name].dtype, found[name].shape) == (array.dtype, array.shape)
        assert found[name].tobytes() == array.tobytes()
        assert not found[name].flags.writeable


def test_only_what_is_wanted_is_read() -> None:
    data = packed({"a": np.arange(3), "b": np.array([{}], dtype=object), "c": np.zeros(10_000)})
    found = npz.arrays("file", data, 1000, ["a"])
    assert {name: array.tolist() for name, array in found.items()} == {"a": [0, 1, 2]}
    with pytest.raises(InputError, match="b: must hold numbers"):
        npz.arrays("file", data, 1000, ["b"])
    with pytest.raises(InputError, match="at most 1000 are read"):
        npz.arrays("file", data, 1000)
    with pytest.raises(InputError, match=r"no array 'd'; found a\.npy, b\.npy, c\.npy"):
        npz.arrays("file", data, 1000, ["a", "d"])


def test_too_many_arrays_are_not_read() -> None:
    data = packed({f"a{k}": np.zeros(1) for k in range(npz.MOST_MEMBERS + 1)})
    with pytest.raises(InputError, match=f"{npz.MOST_MEMBERS + 1} arrays; at most {npz.MOST_MEMBERS}"):
        npz.arrays("file", data, 1 << 30)


def test_names_that_would_not_show_are_refused() -> None:
    with pytest.raises(InputError, match=r"x1b.*is no array"):
        npz.arrays("file", packed({"\x1b[2J": np.zeros(1)}), 1000)
