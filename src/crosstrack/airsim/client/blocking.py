"""The blocking client: a socket, and a thread that reads it.

Replies are read by a thread of their own, so that an interrupt of whoever waits for one, by Ctrl-C say, loses none of
the others: the vehicle can still be told to hover.
"""

import socket
import threading
from contextlib import suppress
from typing import Any, Generic, Self, TypeVar

from crosstrack.airsim.bulk import decode_bulk
from crosstrack.airsim.client.call import Call
from crosstrack.airsim.client.calls import Calls
from crosstrack.airsim.messages import LARGEST_REPLY, BadStream, Reply, Stream, read_reply, request
from crosstrack.errors import LinkLost

CHUNK = 1 << 18
"""bytes that are read at once"""

Result = TypeVar("Result")


class Pending(Generic[Result]):
    """A call that is on its way; several can be at once."""

    def __init__(self, call: Call[Result]) -> None:
        self.call = call
        self.reply: Reply | None = None
        self.lost: str | None = None
        """why there will be no reply"""
        self.open = threading.Lock()
        """held while the call is on its way"""
        self.open.acquire()

    def done(self) -> bool:
        """Return whether the call is over."""
        return self.reply is not None or self.lost is not None

    def settle(self, reply: Reply | None, lost: str | None = None) -> None:
        """Let those that wait know of the reply, or why there is none."""
        self.reply, self.lost = reply, lost
        self.open.release()

    def join(self, timeout: float | None = None) -> Result:
        """Wait for the reply, at most so long (s), and return the result.

        Raises:
            RemoteError: the server answered an error.
            LinkLost: the connection is gone, or the time is over; then it can be waited for again.
        """
        longest = threading.TIMEOUT_MAX if timeout is None else min(max(timeout, 0.0), threading.TIMEOUT_MAX)
        if not self.done() and self.open.acquire(timeout=longest):
            self.open.release()
        if self.reply is not None:
            return self.call.result(self.reply)
        raise LinkLost(f"{self.call.method}: {self.lost or f'no answer within {timeout:g} s'}")


class Client(Calls):
    """Talk to AirSim, or to `crosstrack serve`; can be shared by threads.

    Args:
        host: where the server is
        port: where it listens
        timeout: s, for connecting and for every call that is answered at once

    Raises:
        LinkLost: there is no server, or it does not answer.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 41451, timeout: float = 10.0) -> None:
        self.timeout = timeout
        self.calls: dict[int, Pending[Any]] = {}
        self.lost: str | None = None
        self.number = 0
        self.cosys = False
        self.stream = Stream(LARGEST_REPLY)
        self.changing, self.sending = threading.Lock(), threading.Lock()
        try:
            self.socket = socket.create_connection((host, port), timeout)
        except (OSError, OverflowError) as error:
            raise LinkLost(f"no server at {host}:{port}: {error}") from None
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.reader = threading.Thread(target=self.read, name="airsim client", daemon=True)
        self.reader.start()
        try:
            self.cosys = self.get_server_version() > 1
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        """Return the client."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the connection."""
        self.close()

    def close(self) -> None:
        """Close the connection; what is on its way is lost."""
        self.lose("the client was closed")
        with suppress(OSError):
            self.socket.shutdown(socket.SHUT_RDWR)
        self.reader.join()
        self.socket.close()

    def query(self, call: Call[Result]) -> Result:
        """Make a call that is answered at once, and return its result.

        Raises:
            InputError: an argument is of the wrong type.
            RemoteError: the server answered an error.
            LinkLost: the connection is gone, or there was no answer in time.
        """
        return self.begin(call).join(self.timeout)

    def begin(self, call: Call[Result]) -> Pending[Result]:
        """Make a call, and return it while it is on its way.

        Raises:
            InputError: an argument is of the wrong type.
            LinkLost: the connection is gone.
        """
        arguments = call.pack(self.cosys)
        pending = Pending(call)
        with self.changing:
            if self.lost is not None:
                raise LinkLost(f"{call.method}: {self.lost}")
            number = self.number = (self.number + 1) % (1 << 32)
            self.calls[number] = pending
        try:
            with self.sending:
                self.socket.sendall(request(number, call.method, arguments))
        except OSError as error:
            self.lose(f"the connection is lost: {error}")
        return pending

    def read(self) -> None:
        """Hand replies to their calls until the connection ends."""
        try:
            while data := self.receive():
                self.stream.feed(data)
                while (message := self.stream.take()) is not None:
                    self.settle(read_reply(decode_bulk(message)))
            why = "the server closed the connection"
        except OSError as error:
            why = f"the connection is lost: {error}"
        except BadStream as error:
            why = f"the server sends what is no reply: {error}"
        self.lose(why)

    def receive(self) -> bytes:
        """Return what arrives next, nothing at the end."""
        while True:
            try:
                return self.socket.recv(CHUNK)
            except TimeoutError:  # silence is no loss: it is those that wait who judge how long is too long
                continue

    def settle(self, reply: Reply | None) -> None:
        """Hand a reply to its call, if that is waited for."""
        if reply is not None:
            with self.changing:
                pending = self.calls.pop(reply.id, None)
            if pending is not None:
                pending.settle(reply)

    def lose(self, why: str) -> None:
        """Let every call on its way know that there will be no reply."""
        with self.changing:
            if self.lost is None:
                self.lost = why
            calls, self.calls = self.calls, {}
        for pending in calls.values():
            pending.settle(None, self.lost)
