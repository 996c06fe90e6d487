"""Messages with long lists of numbers, such as pictures of depth and clouds of points, without an object for each."""

from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.codec import BYTE_MARK, SINGLE_MARK
from crosstrack.airsim.messages import BadStream, decode, limits

LONG = 256
"""numbers from which on a list is an array"""
DEEP = 8
"""lists and maps within one another, in which long lists are looked for"""
MAPS = {*range(0x80, 0x90), 0xDE, 0xDF}
LISTS = {*range(0x90, 0xA0), 0xDC, 0xDD}
"""first bytes"""
HEADS = {0xDC: 3, 0xDD: 5}
"""bytes before the values of lists that are not short"""
Numbers = NDArray[np.float32] | NDArray[np.int32]
SINGLES = np.dtype([("mark", "u1"), ("number", ">f4")])


def decode_bulk(message: bytes) -> Any:
    """Return what a message holds; long lists of singles, or of integers of one byte, are arrays (n,).

    Raises:
        BadStream: it cannot be decoded, has keys that are no text, or too many lists and maps.
    """
    if len(message) < LONG:
        return decode(message)
    try:
        return Reader(message).value(DEEP)
    except (ValueError, OverflowError, msgpack.UnpackException) as error:
        raise BadStream(f"a message that cannot be decoded: {error}") from None


def singles(data: memoryview, count: int) -> Numbers | None:
    """Return the singles (count,) that bytes begin with, None where they are not."""
    if count * SINGLES.itemsize > len(data):
        return None
    found = np.frombuffer(data, SINGLES, count)
    return found["number"].astype(np.float32) if (found["mark"] == SINGLE_MARK[0]).all() else None


def integers(data: memoryview, count: int) -> Numbers | None:
    """Return the integers (count,) that bytes begin with, None where they are others, or need more than one byte.

    From 128 on they have a mark before them. It can be a value too: of marks in a row, every other one is.
    """
    values = np.frombuffer(data[: 2 * count], np.uint8)
    places, marks = np.arange(len(values), dtype=np.int32), values == BYTE_MARK
    before = np.maximum.accumulate(np.where(marks, np.int32(-1), places))
    announces = marks & ((places - before) & 1 == 1)
    ends = np.flatnonzero(~announces)[:count]
    announced = announces[np.maximum(ends - 1, 0)] & (ends > 0)
    found = values[ends]
    if len(ends) < count or ((found >= 0x80) & (found < 0xE0) & ~announced).any():
        return None
    return np.where(announced, found, found.view(np.int8)).astype(np.int32)


class Reader:
    """A walk through a message that is complete."""

    def __init__(self, message: bytes) -> None:
        self.message, self.limits = message, limits(message)
        size = len(message)
        self.unpacker = msgpack.Unpacker(unicode_errors="surrogateescape", max_buffer_size=size, **self.limits)
        self.unpacker.feed(message)

    def value(self, deep: int) -> Any:
        """Return the next value."""
        start = self.unpacker.tell()
        mark = self.message[start]
        if deep and mark in MAPS:
            self.count()
            return {self.key(): self.value(deep - 1) for _ in range(self.unpacker.read_map_header())}
        if deep and mark in LISTS:
            numbers = self.numbers(start)
            if numbers is not None:
                self.unpacker.skip()
                return numbers
            if self.length(start) < LONG:
                self.count()
                return [self.value(deep - 1) for _ in range(self.unpacker.read_array_header())]
        return self.unpacker.unpack()

    def count(self) -> None:
        """Count a list or a map, as msgpack has those counted that it makes."""
        if self.limits:
            self.limits["list_hook"](None)

    def key(self) -> str:
        """Return the next key of a map."""
        key = self.unpacker.unpack()
        if not isinstance(key, str):
            raise ValueError(f"{key!r:.80} is no key of a map")  # noqa: TRY004 - what it is reported as
        return key

    def length(self, start: int) -> int:
        """Return how many values the list has that begins at a byte."""
        size = HEADS.get(self.message[start])
        return 0 if size is None else int.from_bytes(self.message[start + 1 : start + size])

    def numbers(self, start: int) -> Numbers | None:
        """Return the list that begins at a byte, None where it is short, or of other values."""
        count = self.length(start)
        if count < LONG:
            return None
        rest = memoryview(self.message)[start + HEADS[self.message[start]] :]
        return singles(rest, count) if rest[0] == SINGLE_MARK[0] else integers(rest, count)
