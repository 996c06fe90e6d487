"""Messages of msgpack-rpc as rpclib speaks it: requests, replies, notifications, out of a stream of bytes.

A request is `[0, id, name, arguments]`, a reply `[1, id, error, result]`, a notification `[2, name, arguments]`; they
follow one another without framing. What a request is, its length tells: the number in front is not looked at.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgpack

from crosstrack.airsim.codec import TEXT, UINT32, array_header
from crosstrack.errors import CrosstrackError

LARGEST_REQUEST = 8 << 20
"""bytes of a message that a server takes: markers at 170 000 points"""
LARGEST_REPLY = 512 << 20
"""bytes of a message that a client takes"""
MOST_CONTAINERS = 1 << 19
"""lists and maps in a message: empty ones are a byte long, and take 64 in memory"""
NIL = b"\xc0"


class BadStream(CrosstrackError):  # noqa: N818 - nothing more can be read from there
    """Bytes that are no messages, or too many for one."""


@dataclass(frozen=True, slots=True)
class Request:
    """A call that arrived."""

    id: int | None
    """what the reply is to carry; None for a notification, which wants none"""
    name: str
    """of the method"""
    arguments: list[Any]
    """as msgpack decoded them"""


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer that arrived."""

    id: int
    """of the request"""
    error: Any
    """None where there is a result"""
    result: Any
    """as msgpack decoded it"""


def request(number: int, name: str, arguments: Sequence[bytes]) -> bytes:
    """Return a call with packed arguments."""
    head = b"\x94\x00" + UINT32.pack(number) + TEXT.pack(name) + array_header(len(arguments))
    return head + b"".join(arguments)


def result(number: int, packed: bytes) -> bytes:
    """Return the reply of a call that was done."""
    return b"".join((b"\x94\x01", UINT32.pack(number), NIL, packed))


def failure(number: int, words: str) -> bytes:
    """Return the reply of a call that failed."""
    return b"".join((b"\x94\x01", UINT32.pack(number), TEXT.pack(words), NIL))


def unknown(name: str, count: int) -> str:
    """Return rpclib's words for a method that is not there."""
    return f"rpclib: server could not find function '{name}' with argument count {count}."


def wrong_arity(name: str, sent: int, wanted: int) -> str:
    """Return rpclib's words for another number of arguments; it calls what was sent expected, and conversely."""
    return (
        f"rpclib: client error C0002: Function '{name}' was called with an invalid number of arguments. "
        f"Expected: {sent}, got: {wanted}"
    )


def thrown(name: str, count: int, what: str) -> str:
    """Return rpclib's words for a call that failed."""
    return (
        f"rpclib: function '{name}' (called with {count} arg(s)) threw an exception. "
        f"The exception contained this information: {what}."
    )


def read_request(message: object) -> Request | None:
    """Return the call that a message is, None where it is none."""
    match message:
        case [_, int(number), str(name), list(arguments)] if 0 <= number < 1 << 32 and type(number) is int:
            return Request(number, name, arguments)
        case [_, str(name), list(arguments)]:
            return Request(None, name, arguments)
    return None


def read_reply(message: object) -> Reply | None:
    """Return the answer that a message is, None where it is none."""
    match message:
        case [1, int(number), error, value]:
            return Reply(number, error, value)
    return None


def decode(message: bytes) -> Any:
    """Return what a message holds.

    Raises:
        BadStream: it cannot be decoded, has keys that are no text, or too many lists and maps.
    """
    try:
        return msgpack.unpackb(message, unicode_errors="surrogateescape", **limits(message))
    except (ValueError, OverflowError, msgpack.UnpackException) as error:
        raise BadStream(f"a message that cannot be decoded: {error}") from None


def limits(message: bytes) -> dict[str, Callable[[Any], Any]]:
    """Return options of msgpack by which a message with too many lists and maps is a `BadStream`."""
    containers = 0

    def counted(container: Any) -> Any:
        nonlocal containers
        containers += 1
        if containers > MOST_CONTAINERS:
            raise BadStream(f"more than {MOST_CONTAINERS} lists and maps in a message")
        return container

    return {"list_hook": counted, "object_hook": counted} if len(message) > MOST_CONTAINERS else {}


class Stream:
    """Messages out of bytes as they arrive.

    Their ends are found before anything is built of them, so that a length that is only announced costs nothing.

    Args:
        largest: bytes that a message may have
    """

    def __init__(self, largest: int) -> None:
        self.largest = largest
        self.held = bytearray()
        self.passed = 0
        """bytes of the messages that were taken"""
        self.scanner = msgpack.Unpacker(read_size=4096, max_buffer_size=2 * largest)

    def __len__(self) -> int:
        """Return the bytes that are held."""
        return len(self.held)

    def feed(self, data: bytes) -> None:
        """Take in what arrived.

        Raises:
            BadStream: more is held than a message may have.
        """
        if len(self.held) + len(data) > 2 * self.largest:
            raise BadStream(f"more than {self.largest} bytes for a message")
        self.held += data
        self.scanner.feed(data)

    def take(self) -> bytes | None:
        """Return the next message, None where it is not complete.

        Raises:
            BadStream: these bytes are no message, or too many.
        """
        try:
            self.scanner.skip()
        except msgpack.OutOfData:
            if len(self.held) > self.largest:
                raise BadStream(f"more than {self.largest} bytes for a message") from None
            return None
        except (ValueError, msgpack.UnpackException) as error:
            raise BadStream(f"bytes that are no message: {error or type(error).__name__}") from None
        size = self.scanner.tell() - self.passed
        if size > self.largest:
            raise BadStream(f"more than {self.largest} bytes for a message")
        message = bytes(self.held[:size])
        del self.held[:size]
        self.passed += size
        return message
