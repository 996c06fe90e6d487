"""Messages with long lists of numbers, such as pictures of depth and clouds of points, without an object for each."""

from typing import Any

import msgpack
import numpy as np

from crosstrack.airsim.codec import SINGLE_MARK
from crosstrack.airsim.messages import BadStream, decode, limits

LONG = 256
"""numbers from which on a list is an array"""
DEEP = 8
"""lists and maps within one another, in which long lists are looked for"""
MAPS = {*range(0x80, 0x90), 0xDE, 0xDF}
LISTS = {*range(0x90, 0xA0), 0xDC, 0xDD}
"""first bytes"""
SINGLES = np.dtype([("mark", "u1"), ("number", ">f4")])


def decode_bulk(message: bytes) -> Any:
    """Return what a message holds; long lists of singles are arrays (n,).

    Raises:
        BadStream: it cannot be decoded, has keys that are no text, or too many lists and maps.
    """
    if len(message) < LONG * SINGLES.itemsize:
        return decode(message)
    try:
        return Reader(message).value(DEEP)
    except (ValueError, OverflowError, msgpack.UnpackException) as error:
        raise BadStream(f"a message that cannot be decoded: {error}") from None


class Reader:
    """A walk through a message that is complete."""

    def __init__(self, message: bytes) -> None:
        self.message, self.limits = message, limits(message)
        self.seek(0)

    def seek(self, position: int) -> None:
        """Go on from a byte."""
        self.began = position
        self.unpacker = msgpack.Unpacker(
            unicode_errors="surrogateescape", max_buffer_size=len(self.message), **self.limits
        )
        self.unpacker.feed(memoryview(self.message)[position:])

    @property
    def position(self) -> int:
        """Bytes that were read."""
        return self.began + int(self.unpacker.tell())

    def value(self, deep: int) -> Any:
        """Return the next value."""
        mark = self.message[self.position]
        if deep and mark in MAPS:
            self.count()
            return {self.key(): self.value(deep - 1) for _ in range(self.unpacker.read_map_header())}
        if deep and mark in LISTS:
            self.count()
            return self.list(self.unpacker.read_array_header(), deep - 1)
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

    def list(self, count: int, deep: int) -> Any:
        """Return so many values: an array where they are many singles."""
        if count < LONG:
            return [self.value(deep) for _ in range(count)]
        start, size = self.position, count * SINGLES.itemsize
        if self.message[start : start + 1] == SINGLE_MARK and start + size <= len(self.message):
            found = np.frombuffer(self.message, SINGLES, count, start)
            if (found["mark"] == SINGLE_MARK[0]).all():
                self.seek(start + size)
                return found["number"].astype(np.float32)
        return [self.unpacker.unpack() for _ in range(count)]
