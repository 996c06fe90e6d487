"""Long lists of numbers in messages."""

import math
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.airsim.arrays import INTS, SINGLES, UINTS
from crosstrack.airsim.bulk import DEEP, LONG, decode_bulk
from crosstrack.airsim.codec import BadCast
from crosstrack.airsim.messages import MOST_CONTAINERS, BadStream, decode

PLAIN = st.none() | st.booleans() | st.integers(-(2**40), 2**40) | st.text(max_size=40) | st.binary(max_size=400)
SINGLE = st.floats(allow_nan=False, width=32)
LISTS = (st.lists(SINGLE, min_size=1, max_size=3) | st.lists(st.integers(-40, 300), min_size=1, max_size=3)).map(
    lambda few: few * LONG
)
VALUES = st.recursive(
    PLAIN | SINGLE | LISTS,
    lambda inside: st.lists(inside, max_size=4) | st.dictionaries(st.text(max_size=5), inside, max_size=4),
    max_leaves=8,
)


BYTES = st.lists(st.sampled_from([-33, -32, -1, 0, 127, 128, 203, 204, 205, 255]), min_size=1, max_size=7)


def same(bulk: Any, plain: Any) -> bool:
    """Return whether two decoded values agree, with an array standing for a list of singles."""
    match bulk:
        case np.ndarray():
            kind = float if bulk.dtype == np.float32 else int
            return {type(one) for one in plain} == {kind} and plain == bulk.tolist()
        case list():
            return len(bulk) == len(plain) and all(map(same, bulk, plain))
        case dict():
            return list(bulk) == list(plain) and all(map(same, bulk.values(), plain.values()))
    return type(bulk) is type(plain) and bool(bulk == plain)


@settings(max_examples=50)
@given(VALUES, st.booleans())
def test_any_message_is_decoded_as_ever(value: object, single: bool) -> None:
    message = msgpack.Packer(use_single_float=single).pack(["padding" * LONG, value])
    assert same(decode_bulk(message), decode(message))


@given(st.integers(LONG, 3 * LONG), st.integers(0, 50))
def test_a_long_list_of_singles_is_an_array_and_what_follows_is_read(count: int, after: int) -> None:
    numbers = np.linspace(-1e9, 1e9, count, dtype=np.float32)
    rest = list(range(after))
    message = b"\x93" + SINGLES.pack(numbers) + msgpack.packb({"after": rest}) + SINGLES.pack(numbers[::-1])
    one, middle, two = decode_bulk(message)
    assert isinstance(one, np.ndarray)
    assert np.array_equal(one, numbers)
    assert middle == {"after": rest}
    assert np.array_equal(two, numbers[::-1])
    assert np.array_equal(SINGLES.unpack(one), numbers)


@given(BYTES, st.lists(st.sampled_from([0, 204, 255]), max_size=4), st.binary(max_size=3))
def test_a_long_list_of_small_integers_is_an_array(some: list[int], last: list[int], rest: bytes) -> None:
    integers = some * LONG + last
    found, after = decode_bulk(msgpack.packb([integers, rest]))
    assert after == rest
    assert isinstance(found, list if -33 in integers else np.ndarray)
    assert list(found) == integers
    assert INTS.unpack(found).tolist() == integers
    if min(integers) < 0:
        with pytest.raises(BadCast):
            UINTS.unpack(found)
    else:
        assert UINTS.unpack(found).tolist() == integers


def test_numbers_that_are_not_integers_are_none() -> None:
    (found,) = decode_bulk(b"\x91" + SINGLES.pack(np.ones(LONG)))
    with pytest.raises(BadCast):
        INTS.unpack(found)


def test_numbers_that_are_not_finite_come_through() -> None:
    numbers = np.full(LONG, np.nan, dtype=np.float32)
    numbers[3], numbers[4] = math.inf, -math.inf
    (found,) = decode_bulk(b"\x91" + SINGLES.pack(numbers))
    assert np.array_equal(found, numbers, equal_nan=True)


@pytest.mark.parametrize("spoilt", [b"\xc3", b"\xcb" + bytes(8), b"\xa1x"])
def test_a_list_with_anything_but_singles_stays_a_list(spoilt: bytes) -> None:
    packed = b"\x91\xdc" + (2 * LONG).to_bytes(2) + (b"\xca" + bytes(4)) * (2 * LONG - 1) + spoilt
    (found,) = decode_bulk(packed)
    assert isinstance(found, list)
    assert same(found, decode(packed)[0])


def test_a_picture_of_bytes_that_look_like_numbers_stays_bytes() -> None:
    picture = SINGLES.pack(np.zeros(2 * LONG))
    assert decode_bulk(msgpack.packb([picture])) == [picture]


def test_nesting_is_followed_only_so_far() -> None:
    deep: object = [0.5] * LONG
    for _ in range(2 * DEEP):
        deep = [deep]
    message = msgpack.Packer(use_single_float=True).pack(deep)
    assert decode_bulk(message) == deep


@pytest.mark.parametrize("inside", [b"\x90", b"\x80"])
def test_too_many_containers_are_refused(inside: bytes) -> None:
    few = b"\xdc" + (LONG - 1).to_bytes(2)
    message = few + (few + (few + inside * (LONG - 1)) * (LONG - 1)) * (LONG - 1)
    assert (LONG - 1) ** 3 > 10 * MOST_CONTAINERS
    with pytest.raises(BadStream, match="lists and maps"):
        decode_bulk(message)


@pytest.mark.parametrize("broken", [{1: 2.5}, {None: 0}])
def test_keys_that_are_no_text_are_refused(broken: object) -> None:
    with pytest.raises(BadStream):
        decode_bulk(msgpack.packb(["padding" * LONG, broken]))
