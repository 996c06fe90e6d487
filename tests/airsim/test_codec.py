"""Values against the bytes of another packer, and what is refused."""

import struct
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.airsim import arrays, codec
from crosstrack.airsim.codec import BadCast

REALS = st.floats(width=32, allow_nan=False)


def single(value: object) -> bytes:
    packed: bytes = msgpack.packb(value, use_single_float=True)
    return packed


@given(st.tuples(REALS, REALS, REALS))
def test_a_vector_travels_as_a_map_of_singles(xyz: tuple[float, float, float]) -> None:
    packed = arrays.VECTOR.pack(np.array(xyz))
    assert packed == single(dict(zip(("x_val", "y_val", "z_val"), xyz, strict=True)))
    np.testing.assert_array_equal(arrays.VECTOR.unpack(msgpack.unpackb(packed)), xyz)


def test_a_quaternion_is_xyzw_here_and_wxyz_there() -> None:
    packed = arrays.QUATERNION.pack([1, 2, 3, 4])
    assert packed == single({"w_val": 4.0, "x_val": 1.0, "y_val": 2.0, "z_val": 3.0})
    assert arrays.QUATERNION.unpack(msgpack.unpackb(packed)).tolist() == [1, 2, 3, 4]
    assert arrays.QUATERNION.unpack({"x_val": 0.5}).tolist() == [0.5, 0, 0, 1]


@given(st.lists(st.tuples(REALS, REALS, REALS), max_size=40))
def test_points_travel_as_a_list_of_vectors(points: list[tuple[float, float, float]]) -> None:
    packed = arrays.VECTORS.pack(points)
    assert packed == single([{"x_val": x, "y_val": y, "z_val": z} for x, y, z in points])
    np.testing.assert_array_equal(arrays.VECTORS.unpack(msgpack.unpackb(packed)), np.reshape(points, (-1, 3)))


@pytest.mark.parametrize("count", [0, 1, 15, 16, 65535, 65536])
def test_long_lists_of_numbers(count: int) -> None:
    numbers = np.random.default_rng(count).normal(size=count).astype(np.float32)
    packed = arrays.SINGLES.pack(numbers)
    assert packed == single(numbers.tolist())
    np.testing.assert_array_equal(arrays.SINGLES.unpack(msgpack.unpackb(packed)), numbers)
    for low, high in ((-(1 << 31), 1 << 31), (0, 128), (0, 256), (0, 257), (-1, 3)):
        whole = np.random.default_rng(count).integers(low, high, count)
        assert arrays.INTS.pack(whole) == msgpack.packb(whole.tolist())
        np.testing.assert_array_equal(arrays.INTS.unpack(whole.tolist()), whole)


def test_a_matrix_travels_as_lists_of_singles() -> None:
    matrix = np.arange(16.0).reshape(4, 4)
    packed = arrays.PROJECTION.pack(matrix)
    assert packed == single(matrix.tolist())
    np.testing.assert_array_equal(arrays.PROJECTION.unpack(msgpack.unpackb(packed)), matrix)


@given(st.floats())
def test_numbers_are_rounded_to_singles_as_c_does(value: float) -> None:
    with np.errstate(over="ignore"):
        expected = np.float32(value)
    np.testing.assert_equal(codec.SINGLE.unpack(value), float(expected))
    assert codec.SINGLE.pack(value) == b"\xca" + struct.pack(">I", int(expected.view(np.uint32)))
    assert codec.DOUBLE.pack(value) == msgpack.packb(value)
    np.testing.assert_equal(arrays.VECTOR.unpack({"y_val": value})[1], float(expected))


def test_what_is_too_large_for_a_single_is_infinite() -> None:
    assert msgpack.unpackb(arrays.VECTOR.pack([1e300, -1e300, 3e38])) == {
        "x_val": np.inf,
        "y_val": -np.inf,
        "z_val": float(np.float32(3e38)),
    }
    assert msgpack.unpackb(arrays.SINGLES.pack([1e300, 1.0])) == [np.inf, 1.0]
    assert msgpack.unpackb(arrays.VECTORS.pack([[1e300, 0, 0]]))[0]["x_val"] == np.inf


def test_integers_stand_for_numbers_and_not_conversely() -> None:
    assert codec.SINGLE.unpack(3) == 3.0
    assert codec.DOUBLE.unpack(1 << 60) == float(1 << 60)
    assert arrays.VECTOR.unpack({"x_val": 1, "y_val": 2, "z_val": 3}).tolist() == [1, 2, 3]
    assert arrays.SINGLES.unpack([1, 2.5]).tolist() == [1, 2.5]
    assert arrays.SINGLES.unpack([1 << 63]).tolist() == [2.0**63]


WRONG: list[tuple[codec.Codec, Any]] = [
    (codec.FLAG, 1),
    (codec.FLAG, None),
    (codec.INT32, 1.0),
    (codec.INT32, True),
    (codec.INT32, 1 << 31),
    (codec.INT32, "1"),
    (codec.UINT8, 256),
    (codec.UINT8, -1),
    (codec.UINT32, -1),
    (codec.UINT64, -1),
    (codec.SINGLE, True),
    (codec.SINGLE, "1"),
    (codec.SINGLE, None),
    (codec.DOUBLE, False),
    (codec.DOUBLE, [1.0]),
    (codec.TEXT, 1),
    (codec.TEXT, ["a"]),
    (codec.BINARY, 1),
    (codec.TEXTS, "text"),
    (codec.TEXTS, ["a", 1]),
    (arrays.VECTOR, [1.0, 2.0, 3.0]),
    (arrays.VECTOR, {"x_val": "1"}),
    (arrays.VECTOR, {"x_val": True}),
    (arrays.VECTORS, {"x_val": 1.0}),
    (arrays.VECTORS, [1.0]),
    (arrays.SINGLES, 1.0),
    (arrays.SINGLES, [1.0, True]),
    (arrays.SINGLES, [[1.0]]),
    (arrays.INTS, [1.0]),
    (arrays.INTS, [1 << 31]),
    (arrays.UINTS, [-1]),
    (arrays.PROJECTION, [[1.0]]),
    (arrays.PROJECTION, [[1.0] * 4] * 3),
]


@pytest.mark.parametrize(("kind", "wire"), WRONG, ids=lambda value: f"{type(value).__name__} {value!r:.20}")
def test_values_of_another_type_are_refused(kind: codec.Codec, wire: object) -> None:
    with pytest.raises(BadCast):
        kind.unpack(wire)


@given(st.binary(max_size=300))
def test_bytes_are_binary_and_survive_as_text(data: bytes) -> None:
    assert codec.BINARY.pack(data) == msgpack.packb(data, use_bin_type=True)
    assert codec.BINARY.unpack(data) == data
    as_raw = msgpack.packb(data, use_bin_type=False)
    text = codec.TEXT.unpack(msgpack.unpackb(as_raw, unicode_errors="surrogateescape"))
    assert codec.TEXT.pack(text) == msgpack.packb(text, unicode_errors="surrogateescape")
    assert codec.BINARY.unpack(text) == data
    assert codec.TEXT.unpack(data) == text


@given(st.integers(-(1 << 31), (1 << 31) - 1))
def test_integers_take_as_few_bytes_as_they_need(number: int) -> None:
    assert codec.INT32.pack(number) == msgpack.packb(number)
    assert codec.INT32.pack(np.int64(number)) == msgpack.packb(number)


def test_what_cannot_travel_is_refused() -> None:
    with pytest.raises(OverflowError):
        codec.UINT8.pack(256)
    with pytest.raises(TypeError):
        codec.INT32.pack(1.5)  # type: ignore[arg-type]  # what a caller without a type checker does
    with pytest.raises(TypeError):
        codec.TEXT.pack(b"x")  # type: ignore[arg-type]  # the same
    with pytest.raises(ValueError, match="2 numbers where 3 belong"):
        arrays.VECTOR.pack([1, 2])
    with pytest.raises(ValueError, match=r"\(1, 2\) where \(n, 3\) belongs"):
        arrays.VECTORS.pack([[1, 2]])
