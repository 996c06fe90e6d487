"""Codecs of arrays: vectors and quaternions as maps of singles, long lists of numbers without a loop over them."""

import operator
import struct
from array import array
from collections.abc import Sequence
from ctypes import c_float
from typing import Any

import msgpack
import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosstrack.airsim.codec import BYTE_MARK, SINGLE_MARK, BadCast, array_header, listed, mapped
from crosstrack.types import Array

NUMBERS = {float, int}
"""types that stand for a number; bool is none of them"""


class Components:
    """An array of a few numbers that travels as a map of singles, in an order of its own.

    Args:
        keys: keys in the order of the wire
        order: where the number of each key is in the array
        default: what a missing key stands for, in the order of the array
    """

    def __init__(self, keys: Sequence[str], order: Sequence[int], default: Sequence[float]) -> None:
        self.keys, self.order, self.default = keys, order, default
        heads = [bytes((0xA0 | len(key),)) + key.encode() + SINGLE_MARK for key in keys]
        heads[0] = bytes((0x80 | len(keys),)) + heads[0]
        self.form = struct.Struct(">" + "".join(f"{len(head)}sf" for head in heads))
        self.parts: list[Any] = [part for head in heads for part in (head, 0.0)]
        ends = np.cumsum([len(head) + 4 for head in heads])
        self.row = np.dtype(
            {
                "names": list(keys),
                "formats": [">f4"] * len(keys),
                "offsets": [int(end) - 4 for end in ends],
                "itemsize": self.form.size,
            }
        )
        self.by_index = [keys[list(order).index(k)] for k in range(len(keys))]
        self.pick = operator.itemgetter(*self.by_index)
        self.cells = c_float * len(keys)

    def pack(self, value: ArrayLike) -> bytes:
        """Return the map of the numbers."""
        numbers = np.asarray(value, float).tolist()
        if len(numbers) != len(self.keys):
            raise ValueError(f"{len(numbers)} numbers where {len(self.keys)} belong")
        parts = self.parts.copy()
        parts[1::2] = [numbers[k] for k in self.order]
        try:
            return self.form.pack(*parts)
        except OverflowError:
            parts[1::2] = [c_float(numbers[k]).value for k in self.order]
            return self.form.pack(*parts)

    def unpack(self, wire: object) -> Array:
        """Return the numbers of a map as an array."""
        return np.array(self.numbers(wire))

    def numbers(self, wire: object) -> list[float]:
        """Return the numbers of a map in the order of the array."""
        given = mapped(wire)
        try:
            numbers = self.pick(given)
        except KeyError:
            numbers = tuple(map(given.get, self.by_index, self.default))
        if not NUMBERS.issuperset(map(type, numbers)):
            raise BadCast(f"{wire!r:.80} holds what is no number")
        rounded: list[float] = self.cells(*numbers)[:]
        return rounded


class Rows:
    """An array (n, components) that travels as a list of maps."""

    def __init__(self, components: Components) -> None:
        self.components = components
        self.template = components.pack(np.zeros(len(components.keys)))

    def pack(self, value: ArrayLike) -> bytes:
        """Return the list of the rows."""
        width = len(self.components.keys)
        given = np.asarray(value, float)
        rows = given.reshape(-1, width) if given.size == 0 else given
        if rows.ndim != 2 or rows.shape[1] != width:
            raise ValueError(f"an array of shape {given.shape} where (n, {width}) belongs")
        out = np.frombuffer(bytearray(self.template * len(rows)), self.components.row)
        with np.errstate(over="ignore"):
            for key, column in zip(self.components.keys, self.components.order, strict=True):
                out[key] = rows[:, column]
        return array_header(len(rows)) + out.tobytes()

    def unpack(self, wire: object) -> Array:
        """Return the rows of a list of maps."""
        rows = [self.components.numbers(each) for each in listed(wire)]
        return np.array(rows).reshape(-1, len(self.components.keys))


class Singles:
    """A flat array that travels as a list of singles."""

    row = np.dtype([("mark", "u1"), ("number", ">f4")])

    def pack(self, value: ArrayLike) -> bytes:
        """Return the list of the numbers."""
        with np.errstate(over="ignore"):
            numbers = np.asarray(value, np.float32).ravel()
        out = np.empty(len(numbers), self.row)
        out["mark"], out["number"] = SINGLE_MARK[0], numbers
        return array_header(len(numbers)) + out.tobytes()

    def unpack(self, wire: object) -> NDArray[np.float32]:
        """Return the numbers of a list, or an array that was decoded as one already."""
        if isinstance(wire, np.ndarray):
            return np.asarray(wire, np.float32)
        given = listed(wire)
        if not NUMBERS.issuperset(map(type, given)):
            raise BadCast("a list of numbers holds something else")
        with np.errstate(over="ignore"):
            return np.array(given, float).astype(np.float32)


class Wholes:
    """A flat array of integers that travels as a list of integers."""

    def __init__(self, kind: type[np.integer[Any]]) -> None:
        self.kind = kind

    def pack(self, value: ArrayLike) -> bytes:
        """Return the list of the integers."""
        numbers = np.asarray(value, self.kind).ravel()
        if ((numbers < 0) | (numbers > 255)).any():
            packed: bytes = msgpack.packb(numbers.tolist())
            return packed
        marked, shown = np.full((len(numbers), 2), BYTE_MARK, np.uint8), np.ones((len(numbers), 2), bool)
        marked[:, 1], shown[:, 0] = numbers, numbers > 127
        return array_header(len(numbers)) + marked[shown].tobytes()

    def unpack(self, wire: object) -> NDArray[Any]:
        """Return the integers of a list, or of an array that was decoded as one already."""
        if isinstance(wire, np.ndarray):
            if wire.dtype.kind == "i" and (self.kind is np.int32 or (wire >= 0).all()):
                return wire.astype(self.kind)
            raise BadCast("a list of integers holds something else")
        given = listed(wire)
        try:
            if {*map(type, given)} <= {int}:
                return np.frombuffer(array(np.dtype(self.kind).char, given), self.kind)
        except OverflowError:
            pass
        raise BadCast("a list of integers holds something else")


class Matrix:
    """A square array that travels as a list of its rows."""

    def __init__(self, size: int) -> None:
        self.size = size

    def pack(self, value: ArrayLike) -> bytes:
        """Return the list of the rows."""
        rows = np.asarray(value).reshape(self.size, self.size)
        return array_header(self.size) + b"".join(SINGLES.pack(row) for row in rows)

    def unpack(self, wire: object) -> NDArray[np.float32]:
        """Return the rows of a list."""
        rows = [SINGLES.unpack(row) for row in listed(wire)]
        if len(rows) == self.size and all(len(row) == self.size for row in rows):
            return np.array(rows)
        raise BadCast(f"no matrix of {self.size} rows and columns")


SINGLES, INTS, UINTS = Singles(), Wholes(np.int32), Wholes(np.uint32)
PLANE = Components(["x_val", "y_val"], [0, 1], [0, 0])
VECTOR = Components(["x_val", "y_val", "z_val"], [0, 1, 2], [0, 0, 0])
QUATERNION = Components(["w_val", "x_val", "y_val", "z_val"], [3, 0, 1, 2], [0, 0, 0, 1])
"""an array xyzw, on the wire wxyz"""
VECTORS = Rows(VECTOR)
PROJECTION = Matrix(4)
