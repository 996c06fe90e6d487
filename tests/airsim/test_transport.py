"""Connections: replies as they are done, rpclib's errors, bounds on what a client can cost."""

import asyncio
import logging
import socket
import threading
import time
from contextlib import ExitStack

import msgpack
import pytest
from toy_server import HANDLERS, LARGE, Toy, ask, replies, toy, until

from crosstrack.airsim.messages import LARGEST_REQUEST
from crosstrack.airsim.server import transport
from crosstrack.airsim.server.transport import Listener
from crosstrack.errors import InputError


def ended(link: socket.socket) -> bool:
    """Read until the connection ends, and return whether it does."""
    try:
        while link.recv(1 << 20):
            pass
    except ConnectionError:
        return True
    except TimeoutError:
        return False
    return True


def test_calls_are_answered() -> None:
    with toy() as server, server.connect() as link:
        assert ask(link, 3, "ping") == [1, 3, None, True]
        assert ask(link, (1 << 32) - 1, "getServerVersion") == [1, (1 << 32) - 1, None, 1]
        number, error, state = ask(link, 4, "getMultirotorState", "")[1:]
        assert (number, error, state["timestamp"]) == (4, None, 7)
        yaw = {"is_rate": True, "yaw_or_rate": 0.0}
        assert ask(link, 5, "moveToZ", 2.5, 1, 3e38, yaw, -1, 1, "")[3] is True


def test_errors_are_those_of_rpclib(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, "crosstrack")
    thrown = (
        "rpclib: function '{}' (called with {} arg(s)) threw an exception. "
        "The exception contained this information: {}."
    )
    with toy() as server, server.connect() as link:
        assert ask(link, 0, "simFly", 1, 2)[2:] == [
            "rpclib: server could not find function 'simFly' with argument count 2.",
            None,
        ]
        assert ask(link, 1, "takeoff", 5.0)[2] == (
            "rpclib: client error C0002: Function 'takeoff' was called with an invalid number of arguments. "
            "Expected: 1, got: 2"
        )
        assert ask(link, 2, "takeoff", "soon", "")[2] == thrown.format("takeoff", 2, "std::bad_cast")
        assert ask(link, 3, "hover", "Ghost")[2] == thrown.format("hover", 1, "no Ghost")
        assert ask(link, 4, "takeoff", 0.01, "broken")[2] == thrown.format("takeoff", 2, "it moves")
        assert "ZeroDivisionError" in ask(link, 5, "listVehicles")[2]
        assert "TypeError" in ask(link, 6, "simListAssets")[2]
        assert ask(link, 7, "ping")[3] is True


def test_replies_come_in_the_order_of_completion() -> None:
    with toy() as server, server.connect() as link:
        for number, seconds in enumerate((0.9, 0.6, 0.3)):
            link.sendall(msgpack.packb([0, number, "takeoff", [seconds, ""]]))
        link.sendall(msgpack.packb([0, 3, "ping", []]))
        assert [reply[1] for reply in replies(link, 4)] == [3, 2, 1, 0]


def test_notifications_are_done_and_not_answered() -> None:
    with toy() as server, server.connect() as link:
        link.sendall(msgpack.packb([2, "simRunConsoleCommand", ["first"]]))
        link.sendall(msgpack.packb([2, "takeoff", [0.0, ""]]))
        link.sendall(msgpack.packb([2, "no such thing", []]))
        assert ask(link, 1, "ping") == [1, 1, None, True]
        assert server.heard == ["first"]


@pytest.mark.parametrize(
    "message", [[], [0, 1], [0, 1, "ping", [], 5], 5, None, "ping", {"a": 1}, [0, "x", "ping", []]]
)
def test_what_is_no_call_is_passed_over(message: object) -> None:
    with toy() as server, server.connect() as link:
        link.sendall(msgpack.packb(message))
        assert ask(link, 1, "ping") == [1, 1, None, True]


def test_the_type_of_a_message_is_not_looked_at() -> None:
    with toy() as server, server.connect() as link:
        link.sendall(msgpack.packb([7, 9, "ping", []]))
        assert replies(link, 1) == [[1, 9, None, True]]


def test_a_client_that_vanishes_in_mid_move_does_not_matter() -> None:
    with toy() as server, server.connect() as good:
        bad = server.connect()
        bad.sendall(msgpack.packb([0, 1, "takeoff", [0.1, ""]]) + b"\x94\x00")
        bad.close()
        assert ask(good, 1, "takeoff", 0.2, "")[3] is True
        assert until(lambda: server.run(lambda: len(server.listener.connections)) == 1)
        assert server.run(lambda: server.listener.held) == 0


def test_a_client_that_sends_nonsense_is_dropped_and_the_others_are_not() -> None:
    with toy() as server, server.connect() as good, server.connect() as bad:
        bad.sendall(b"\xc1\xc1\xc1")
        assert ended(bad)
        assert ask(good, 1, "ping")[3] is True


def test_a_message_without_end_is_dropped() -> None:
    with toy() as server, server.connect() as good, server.connect() as bad:
        bad.sendall(b"\xdd\xff\xff\xff\xff")
        with pytest.raises(ConnectionError):
            bad.sendall(b"\x01" * (4 * LARGEST_REQUEST))
        assert ask(good, 1, "ping")[3] is True
        assert until(lambda: server.run(lambda: server.listener.held) == 0)


def test_incomplete_messages_of_all_together_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "MOST_HELD", 1 << 20)
    with toy() as server, server.connect() as good, server.connect() as small, server.connect() as large:
        small.sendall(b"\xc6\x00\x05\x00\x00" + bytes(1 << 18))
        assert until(lambda: server.run(lambda: server.listener.held) > 1 << 18)
        large.sendall(b"\xc6\x00\x70\x00\x00" + bytes(1 << 20))
        assert ended(large)
        assert until(lambda: server.run(lambda: server.listener.held) <= 1 << 20)
        small.sendall(bytes((5 << 16) - (1 << 18)))
        assert ask(small, 1, "ping")[3] is True
        assert ask(good, 1, "ping")[3] is True


def test_a_client_that_never_reads_its_replies_stops_only_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "STALLED", 0.3)
    with toy() as server, server.connect() as good, server.connect() as bad:
        bad.setblocking(False)
        flood(bad, msgpack.packb([0, 1, "getSettingsString", []]), 1.0)
        unsent = server.run(lambda: max(each.unsent for each in server.listener.connections))
        assert unsent <= transport.HIGH_WATER + 2 * len(LARGE)
        assert ask(good, 1, "ping")[3] is True
        assert until(lambda: server.run(lambda: len(server.listener.connections)) == 1)


def flood(link: socket.socket, message: bytes, seconds: float) -> None:
    """Send a message again and again, as long as the other side takes it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            link.send(message)
        except BlockingIOError:
            time.sleep(0.01)
        except ConnectionError:
            return


def test_replies_that_nobody_fetches_are_bounded_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "MOST_UNSENT", 2 << 20)
    with toy() as server, server.connect() as good, ExitStack() as closing:
        # Each holds a quarter of a mebibyte at least.
        bad = [closing.enter_context(server.connect()) for _ in range(12)]
        for link in bad:  # far more than the system keeps for them
            link.sendall(msgpack.packb([0, 1, "getSettingsString", []]) * 60)
        assert until(lambda: server.run(lambda: len(server.listener.connections)) < 13)
        assert server.run(lambda: sum(each.unsent for each in server.listener.connections)) <= 4 << 20
        assert ask(good, 1, "ping")[3] is True


def test_a_client_that_reads_late_gets_every_reply() -> None:
    with toy() as server, server.connect() as link:
        link.sendall(b"".join(msgpack.packb([0, number, "getSettingsString", []]) for number in range(30)))
        time.sleep(0.3)
        assert [reply[1] for reply in replies(link, 30)] == list(range(30))


def test_calls_on_their_way_are_bounded_and_none_is_lost() -> None:
    with toy() as server, server.connect() as link, server.connect() as good:
        count = 3 * transport.MOST_PENDING
        link.sendall(b"".join(msgpack.packb([0, number, "takeoff", [0.2, ""]]) for number in range(count)))
        assert ask(good, 1, "ping")[3] is True
        assert server.run(lambda: max(each.pending for each in server.listener.connections)) <= transport.MOST_PENDING
        assert sorted(reply[1] for reply in replies(link, count)) == list(range(count))


def test_a_thousand_connections_do_not_disturb_a_good_one() -> None:
    with toy() as server, server.connect() as good:
        assert ask(good, 1, "ping")[3] is True
        idle = []
        for k in range(1000):
            idle.append(server.connect())
            if k % 100 == 0:
                assert ask(good, k, "ping") == [1, k, None, True]
            if len(idle) > 300:
                idle.pop(0).close()
        with server.connect() as late:
            assert ask(late, 2, "ping")[3] is True
        assert ask(good, 3, "getMultirotorState", "")[2] is None
        for link in idle:
            link.close()
        assert until(lambda: server.run(lambda: len(server.listener.connections)) == 1)


def test_of_too_many_connections_the_one_that_is_silent_longest_is_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(transport, "MOST_CONNECTIONS", 10)
    with toy() as server, server.connect() as mover, server.connect() as good:
        mover.sendall(msgpack.packb([0, 1, "takeoff", [1.0, ""]]))
        assert ask(good, 1, "ping")[3] is True
        silent = [server.connect() for _ in range(30)]
        assert ended(silent[0])
        assert server.run(lambda: len(server.listener.connections)) <= 10
        assert ask(good, 2, "ping")[3] is True
        assert replies(mover, 1) == [[1, 1, None, True]]
        for link in silent:
            link.close()


def test_a_flood_of_calls_leaves_the_others_their_turn() -> None:
    stop = threading.Event()
    with toy() as server, server.connect() as good, server.connect() as bad:
        bad.setblocking(False)
        flooding = threading.Thread(target=flood_until, args=(bad, stop))
        flooding.start()
        try:
            turns = [ask(good, number, "ping")[1] for number in range(50)]
        finally:
            stop.set()
            flooding.join()
        assert turns == list(range(50))


def flood_until(link: socket.socket, stop: threading.Event) -> None:
    """Send calls and drop their replies until told to stop."""
    calls = msgpack.packb([0, 1, "ping", []]) * 1000
    while not stop.is_set():
        for act in (lambda: link.send(calls), lambda: link.recv(1 << 20)):
            try:
                act()
            except BlockingIOError:
                time.sleep(0.001)


def test_a_port_in_use_is_one_clear_error() -> None:
    with toy() as server:
        other = Listener(lambda message, answer: None)
        with pytest.raises(InputError, match=f"{server.port} of 127.0.0.1: in use"):
            asyncio.run(other.open(port=server.port))
        with pytest.raises(InputError, match="99999"):
            asyncio.run(other.open(port=99999))


@pytest.mark.parametrize("host", ["", "127.0.0.1"])
def test_only_this_machine_is_listened_to_unless_told_otherwise(host: str) -> None:
    async def bound() -> str:
        listener = Listener(lambda message, answer: None)
        await listener.open(host, 0)
        assert listener.server is not None
        address: str = listener.server.sockets[0].getsockname()[0]
        await listener.close()
        return address

    assert asyncio.run(bound()) == "127.0.0.1"


def test_stopping_ends_every_connection() -> None:
    server = Toy(HANDLERS)
    with server.connect() as link:
        assert ask(link, 1, "ping")[3] is True
        link.sendall(msgpack.packb([0, 1, "takeoff", [60.0, ""]]))
        server.stop()
        assert ended(link)
