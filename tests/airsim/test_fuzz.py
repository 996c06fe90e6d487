"""Random and mutated packets: each message is answered once or not at all, nothing breaks, nothing grows."""

import logging
import random
import tracemalloc
from typing import Any

import msgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_server import HANDLERS, ask, replies, toy, until

from crosstrack.airsim.messages import read_request
from crosstrack.airsim.methods import METHODS
from crosstrack.airsim.server.dispatch import Dispatcher

SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(1 << 63), (1 << 64) - 1)
    | st.floats()
    | st.text(max_size=8)
    | st.binary(max_size=8)
    | st.sampled_from(["", "Drone1", "0"])
)
KEYS = st.sampled_from(["x_val", "y_val", "z_val", "position", "orientation", "is_rate", "camera_name"]) | st.text(
    max_size=4
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4), max_leaves=10
)


class Untouched:
    """Handlers that only count their calls."""

    def __init__(self) -> None:
        self.calls = 0

    def handle(self, *_: Any) -> None:
        self.calls += 1


def answers(dispatcher: Dispatcher, message: bytes) -> list[bytes | None]:
    """Return all answers to a message."""
    found: list[bytes | None] = []
    dispatcher.dispatch(message, found.append)
    return found


@given(st.sampled_from(sorted(METHODS)), st.lists(VALUES, max_size=8), st.integers(0, (1 << 32) - 1))
@settings(max_examples=300)
def test_any_arguments_of_any_method_are_answered_once(name: str, arguments: list[Any], number: int) -> None:
    logging.getLogger("crosstrack.airsim").setLevel(logging.CRITICAL)
    counter = Untouched()
    dispatcher = Dispatcher(None, dict.fromkeys(METHODS, counter.handle))
    (answer,) = answers(dispatcher, msgpack.packb([0, number, name, arguments]))
    assert answer is not None
    kind, back, error, _ = msgpack.unpackb(answer)
    assert (kind, back) == (1, number)
    if counter.calls == 0:
        assert error.endswith("std::bad_cast.") or "invalid number of arguments" in error
    assert answers(dispatcher, msgpack.packb([2, name, arguments])) == [None]


@given(VALUES)
@settings(max_examples=200)
def test_any_message_is_answered_once_or_passed_over(message: Any) -> None:
    logging.getLogger("crosstrack.airsim").setLevel(logging.CRITICAL)
    dispatcher = Dispatcher(None, {})
    (answer,) = answers(dispatcher, msgpack.packb(message))
    request = read_request(message)
    assert (answer is None) == (request is None or request.id is None)


def packets(seed: int, count: int) -> list[bytes]:
    """Return good packets with some bytes changed, left out or put in."""
    rng = random.Random(seed)
    good = [
        msgpack.packb([0, 1, "ping", []]),
        msgpack.packb([0, 2, "takeoff", [0.0, ""]]),
        msgpack.packb([0, 3, "moveToZ", [2.5, 1, 9, {"is_rate": True, "yaw_or_rate": 0.0}, -1, 1, ""]]),
        msgpack.packb([2, "getMultirotorState", ["Drone" * 20]]),
        msgpack.packb([0, 4, "simRunConsoleCommand", ["x" * 300]]),
    ]
    made = []
    for _ in range(count):
        packet = bytearray(rng.choice(good))
        for _ in range(rng.randrange(4)):
            place = rng.randrange(len(packet))
            match rng.randrange(4):
                case 0:
                    packet[place] = rng.randrange(256)
                case 1:
                    del packet[place : place + rng.randrange(1, 4)]
                case 2:
                    packet[place:place] = rng.randbytes(rng.randrange(1, 6))
                case 3:
                    packet = packet[: place + 1]
            packet = packet or bytearray(b"\x00")
        made.append(bytes(packet))
    return made


@pytest.mark.parametrize("seed", range(4))
def test_mutated_packets_never_disturb_a_good_client(seed: int, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, "crosstrack")
    with toy(HANDLERS | {"takeoff": lambda _, seconds, vehicle: True}) as server, server.connect() as good:
        for k in range(60):
            with server.connect() as bad:
                bad.sendall(b"".join(packets(1000 * seed + k, 30)))
            if k % 10 == 0:
                assert ask(good, k, "ping") == [1, k, None, True]
        assert ask(good, 99, "getMultirotorState", "")[2] is None
        assert server.thread.is_alive()


def test_hostile_clients_leave_nothing_behind(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, "crosstrack")

    def round_of_abuse(server: Any, seed: int) -> None:
        for k, packet in enumerate(packets(seed, 150)):
            with server.connect() as bad:
                bad.sendall(packet * (1 + k % 20))
        with server.connect() as last:
            assert ask(last, 1, "ping")[3] is True
        assert until(lambda: server.run(lambda: len(server.listener.connections)) == 1)
        assert server.run(lambda: server.listener.held) == 0

    with toy() as server, server.connect() as good:
        round_of_abuse(server, 1)
        assert ask(good, 1, "ping")[3] is True
        tracemalloc.start()
        try:
            before = tracemalloc.get_traced_memory()[0]
            round_of_abuse(server, 2)
            assert ask(good, 2, "ping")[3] is True
            assert tracemalloc.get_traced_memory()[0] - before < 1 << 20
        finally:
            tracemalloc.stop()


def test_half_messages_are_waited_for() -> None:
    with toy() as server, server.connect() as slow, server.connect() as good:
        packet = msgpack.packb([0, 5, "getMultirotorState", ["ü" * 40]])
        for k in range(len(packet)):
            slow.sendall(packet[k : k + 1])
            if k % 20 == 0:
                assert ask(good, k, "ping")[1] == k
        assert replies(slow, 1)[0][1] == 5
