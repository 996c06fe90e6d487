"""Codecs: from values to the bytes of AirSim's wire types, and from what msgpack decodes to values.

A C++ `float` travels as a single, a `double` as a double, a string as text and a list of bytes as binary; a packer of
Python floats has one width for all, so values are packed here.
"""

import operator
import struct
from collections.abc import Iterable
from ctypes import c_float
from dataclasses import fields
from functools import cache
from typing import Any, Protocol, SupportsIndex, get_type_hints

import msgpack

from crosstrack.errors import CrosstrackError

SINGLE_MARK, DOUBLE_MARK = b"\xca", b"\xcb"
BYTE_MARK = 0xCC
"""before an integer from 128 to 255"""


class BadCast(CrosstrackError):  # noqa: N818 - the protocol's word for it
    """A value from the wire is not of the type that belongs there."""


class Codec(Protocol):
    """How values of one type travel."""

    def pack(self, value: Any) -> bytes:
        """Return a value as msgpack."""

    def unpack(self, wire: object) -> Any:
        """Return the value that msgpack decoded, checked.

        Raises:
            BadCast: it is of another type, or out of range.
        """


def single(wire: object) -> float:
    """Round a number from the wire to single precision."""
    if type(wire) is float or type(wire) is int:
        return c_float(wire).value
    raise BadCast(f"{wire!r:.80} is no number")


def array_header(count: int) -> bytes:
    """Return what announces an array."""
    if count < 16:
        return bytes((0x90 | count,))
    return struct.pack(">BH", 0xDC, count) if count < 1 << 16 else struct.pack(">BI", 0xDD, count)


def listed(wire: object) -> list[Any]:
    """Return a list from the wire, checked."""
    if type(wire) is list:
        return wire
    raise BadCast(f"{wire!r:.80} is no list")


def mapped(wire: object) -> dict[str, Any]:
    """Return a map from the wire, checked."""
    if type(wire) is dict:
        return wire
    raise BadCast(f"{wire!r:.80} is no map")


class Nothing:
    """What a call without a result answers."""

    def pack(self, value: None) -> bytes:
        """Return nil."""
        return b"\xc0"

    def unpack(self, wire: object) -> None:
        """Take whatever was answered."""


class Flag:
    """A bool, which no integer can stand for."""

    def pack(self, value: bool) -> bytes:
        """Return true or false."""
        return b"\xc3" if value else b"\xc2"

    def unpack(self, wire: object) -> bool:
        """Return the bool."""
        if wire is True or wire is False:
            return wire
        raise BadCast(f"{wire!r:.80} is no bool")


class Whole:
    """An integer of a range, in as few bytes as it needs."""

    def __init__(self, low: int, high: int) -> None:
        self.low, self.high = low, high

    def pack(self, value: SupportsIndex) -> bytes:
        """Return the integer."""
        number = operator.index(value)
        if not self.low <= number <= self.high:
            raise OverflowError(f"{number} is not within {self.low} and {self.high}")
        packed: bytes = msgpack.packb(number)
        return packed

    def unpack(self, wire: object) -> int:
        """Return the integer, within its range."""
        if type(wire) is int and self.low <= wire <= self.high:
            return wire
        raise BadCast(f"{wire!r:.80} is no integer within {self.low} and {self.high}")


class Single:
    """A number in single precision."""

    def pack(self, value: float) -> bytes:
        """Return the number, infinite where it is too large."""
        return SINGLE_MARK + struct.pack(">f", c_float(value).value)

    def unpack(self, wire: object) -> float:
        """Return the number, rounded to what a single holds."""
        return single(wire)


class Double:
    """A number in double precision."""

    def pack(self, value: float) -> bytes:
        """Return the number."""
        return DOUBLE_MARK + struct.pack(">d", value)

    def unpack(self, wire: object) -> float:
        """Return the number."""
        if type(wire) is float or type(wire) is int:
            return float(wire)
        raise BadCast(f"{wire!r:.80} is no number")


class Text:
    """Text; bytes that are no UTF-8 survive as lone surrogates."""

    def pack(self, value: str) -> bytes:
        """Return the text."""
        if not isinstance(value, str):
            raise TypeError(f"{value!r:.80} is no text")
        packed: bytes = msgpack.packb(value, unicode_errors="surrogateescape")
        return packed

    def unpack(self, wire: object) -> str:
        """Return the text."""
        if type(wire) is str:
            return wire
        if type(wire) is bytes:
            return wire.decode(errors="surrogateescape")
        raise BadCast(f"{wire!r:.80} is no text")


class Binary:
    """Bytes."""

    def pack(self, value: bytes) -> bytes:
        """Return the bytes."""
        packed: bytes = msgpack.packb(bytes(memoryview(value)))
        return packed

    def unpack(self, wire: object) -> bytes:
        """Return the bytes."""
        if type(wire) is bytes:
            return wire
        if type(wire) is str:
            return wire.encode(errors="surrogateescape")
        raise BadCast(f"{wire!r:.80} is no bytes")


class Listed:
    """A tuple that travels as a list of values of one type."""

    def __init__(self, codec: Codec) -> None:
        self.codec = codec

    def pack(self, value: Iterable[Any]) -> bytes:
        """Return the list of the values."""
        packed = [self.codec.pack(each) for each in value]
        return array_header(len(packed)) + b"".join(packed)

    def unpack(self, wire: object) -> tuple[Any, ...]:
        """Return the values of a list."""
        return tuple(self.codec.unpack(each) for each in listed(wire))


class Record:
    """A frozen dataclass that travels as a map, its fields in their order; each is annotated with its codec.

    A key that is missing on the wire leaves the default, and one that is not known is passed over.
    """

    def __init__(self, kind: type[Any]) -> None:
        hints = get_type_hints(kind, include_extras=True)
        self.kind = kind
        self.fields = [(field.name, codec_of(hints[field.name])) for field in fields(kind)]
        self.keys = [TEXT.pack(name) for name, _ in self.fields]
        self.header = bytes((0x80 | len(self.fields),))

    def pack(self, value: Any) -> bytes:
        """Return the map of the fields."""
        parts = [self.header]
        for key, (name, codec) in zip(self.keys, self.fields, strict=True):
            parts += (key, codec.pack(getattr(value, name)))
        return b"".join(parts)

    def unpack(self, wire: object) -> Any:
        """Return the dataclass of a map."""
        given = mapped(wire)
        return self.kind(**{name: codec.unpack(given[name]) for name, codec in self.fields if name in given})


@cache
def record(kind: type[Any]) -> Record:
    """Return the codec of a dataclass."""
    return Record(kind)


def codec_of(hint: Any) -> Codec:
    """Return the codec that an annotation names, or that of the dataclass that it is."""
    codec: Codec = hint.__metadata__[0] if hasattr(hint, "__metadata__") else record(hint)
    return codec


NOTHING, FLAG, SINGLE, DOUBLE, TEXT, BINARY = Nothing(), Flag(), Single(), Double(), Text(), Binary()
INT32, UINT8, UINT16 = Whole(-(1 << 31), (1 << 31) - 1), Whole(0, (1 << 8) - 1), Whole(0, (1 << 16) - 1)
UINT32, UINT64 = Whole(0, (1 << 32) - 1), Whole(0, (1 << 64) - 1)
TEXTS = Listed(TEXT)
