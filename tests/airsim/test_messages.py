"""Messages out of a stream: split anywhere, hostile, too large; and rpclib's words."""

import tracemalloc
from contextlib import suppress

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.airsim import messages
from crosstrack.airsim.messages import BadStream, Request, Stream, decode, read_reply, read_request

VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(1 << 63), (1 << 64) - 1)
    | st.floats(allow_nan=False)
    | st.text()
    | st.binary(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=5), inner, max_size=5),
    max_leaves=20,
)


@given(st.lists(VALUES, max_size=6), st.data())
def test_messages_come_out_as_they_went_in_however_they_are_split(values: list[object], data: st.DataObject) -> None:
    sent = b"".join(map(msgpack.packb, values))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(sent)), max_size=8)))
    stream, found = Stream(1 << 16), []
    for start, end in zip([0, *cuts], [*cuts, len(sent)], strict=True):
        stream.feed(sent[start:end])
        while (message := stream.take()) is not None:
            found.append(decode(message))
    assert found == values
    assert len(stream) == 0


def test_a_message_byte_by_byte() -> None:
    sent = msgpack.packb([0, 1, "moveOnPath", [[{"x_val": 1.5, "y_val": "ü" * 300}], b"y" * 70000]])
    stream = Stream(1 << 17)
    for k in range(len(sent) - 1):
        stream.feed(sent[k : k + 1])
        if k % 1000 < 300:
            assert stream.take() is None
    stream.feed(sent[-1:])
    assert stream.take() == sent


@given(st.binary(max_size=400))
@settings(max_examples=300)
def test_random_bytes_are_messages_or_a_bad_stream(data: bytes) -> None:
    stream = Stream(1 << 12)
    stream.feed(data)
    try:
        while (message := stream.take()) is not None:
            with suppress(BadStream):
                read_request(decode(message))
    except BadStream:
        return
    assert len(stream) <= len(data)


def flood(stream: Stream) -> None:
    for _ in range(100):
        stream.feed(b"\x01" * 65536)
        stream.take()


HUGE = [b"\xdd\xff\xff\xff\xff", b"\xdf\xff\xff\xff\xff", b"\xdb\xff\xff\xff\xff", b"\xc6\xff\xff\xff\xff"]


@pytest.mark.parametrize("announced", HUGE, ids=["list", "map", "text", "bytes"])
def test_lengths_that_are_only_announced_cost_nothing(announced: bytes) -> None:
    stream = Stream(1 << 20)
    tracemalloc.start()
    try:
        stream.feed(announced * 50)
        assert stream.take() is None
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
        with pytest.raises(BadStream, match="more than 1048576 bytes"):
            flood(stream)
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()


def test_an_extension_of_the_largest_length_is_refused() -> None:
    stream = Stream(1 << 20)
    stream.feed(b"\x94\x00\x01\xa4ping\x91\xc9\xff\xff\xff\xff\x05")
    message = stream.take()
    assert message is not None
    with pytest.raises(BadStream):
        decode(message)


def test_nesting_without_end_is_a_bad_stream() -> None:
    stream = Stream(1 << 20)
    stream.feed(b"\x91" * 100_000)
    with pytest.raises(BadStream):
        stream.take()


def test_too_many_lists_in_a_message_are_refused() -> None:
    inside = b"\x90" * 1000
    count = messages.MOST_CONTAINERS // 1000 + 1
    with pytest.raises(BadStream, match="lists and maps"):
        decode(b"\xdd" + count.to_bytes(4) + (b"\xdc" + (1000).to_bytes(2) + inside) * count)


def test_keys_that_are_no_text_are_refused() -> None:
    with pytest.raises(BadStream):
        decode(msgpack.packb([0, 1, "ping", [{1: 2}]]))


def test_a_request_is_told_by_its_length_alone() -> None:
    assert read_request([0, 5, "ping", []]) == Request(5, "ping", [])
    assert read_request(["any", 5, "ping", [1]]) == Request(5, "ping", [1])
    assert read_request([2, "ping", []]) == Request(None, "ping", [])
    for other in ([], [0, 1, "ping"], [0, 1, "ping", [], 1], 5, None, {"a": 1}, "ping", [0, -1, "ping", []]):
        assert read_request(other) is None
    for other in (
        [0, 1 << 32, "ping", []],
        [0, True, "ping", []],
        [0, 1.0, "ping", []],
        [0, 1, 2, []],
        [0, 1, "ping", {}],
    ):
        assert read_request(other) is None


def test_replies() -> None:
    assert msgpack.unpackb(messages.result(4_000_000_000, b"\xc3")) == [1, 4_000_000_000, None, True]
    assert msgpack.unpackb(messages.failure(3, "no")) == [1, 3, "no", None]
    reply = read_reply(msgpack.unpackb(messages.result(7, b"\x05")))
    assert reply is not None
    assert (reply.id, reply.error, reply.result) == (7, None, 5)
    assert read_reply([2, "ping", []]) is None
    assert msgpack.unpackb(messages.request(9, "hover", [b"\xa0"])) == [0, 9, "hover", [""]]


def test_errors_are_in_the_words_of_rpclib() -> None:
    assert messages.unknown("simFoo", 2) == "rpclib: server could not find function 'simFoo' with argument count 2."
    assert messages.wrong_arity("ping", sent=1, wanted=0) == (
        "rpclib: client error C0002: Function 'ping' was called with an invalid number of arguments. "
        "Expected: 1, got: 0"
    )
    assert messages.thrown("land", 2, "std::bad_cast") == (
        "rpclib: function 'land' (called with 2 arg(s)) threw an exception. "
        "The exception contained this information: std::bad_cast."
    )
