"""Connections over TCP: many clients, none of which can stop the others or make the server grow without bound."""

import asyncio
import errno
import logging
from collections.abc import Callable
from typing import cast

from crosstrack.airsim.messages import LARGEST_REQUEST, BadStream, Stream
from crosstrack.airsim.server.dispatch import Answer
from crosstrack.errors import InputError, Problem

LOOPBACK = "127.0.0.1"
PORT = 41451

MOST_CONNECTIONS = 400
"""of all clients; beyond, the one that has been silent longest is dropped"""
MOST_PENDING = 64
"""calls of a connection that are not answered yet; beyond, no more are read from it"""
MOST_HELD = 64 << 20
"""bytes of incomplete messages of all connections; beyond, the one that holds most is dropped"""
MOST_UNSENT = 256 << 20
"""bytes of replies of all connections that were not fetched; beyond, the one with most of them is dropped"""
HIGH_WATER = 256 << 10
"""bytes of replies of a connection that were not fetched; beyond, no more calls are read from it"""
STALLED = 30.0
"""s without fetching any of the replies that wait, after which a connection is dropped"""
TURN = 8
"""messages of a connection that are dealt with before it is another's turn"""

log = logging.getLogger(__name__)

Dispatch = Callable[[bytes, Answer], None]


class Connection(asyncio.Protocol):
    """One client: its messages in, its replies out."""

    def __init__(self, listener: "Listener") -> None:
        self.listener = listener
        self.loop = asyncio.get_running_loop()
        self.stream = Stream(LARGEST_REQUEST)
        self.pending = 0
        self.spoke = False
        self.heard = 0
        """when it connected or spoke last, as a number that only grows"""
        self.full = False
        """whether replies wait to be fetched"""
        self.scheduled = False
        self.watch: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to serve."""
        self.transport = cast(asyncio.Transport, transport)
        self.transport.set_write_buffer_limits(HIGH_WATER)
        self.listener.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the client; what it asked for goes on, and nobody is told."""
        if self.watch is not None:
            self.watch.cancel()
        self.listener.remove(self)

    def data_received(self, data: bytes) -> None:
        """Take in what arrived."""
        try:
            self.stream.feed(data)
        except BadStream as error:
            self.drop(str(error))
            return
        self.listener.held += len(data)
        self.work()
        self.listener.bound_held()

    def work(self) -> None:
        """Deal with a few messages, and come back for the others."""
        self.scheduled = False
        for _ in range(TURN):
            if self.transport.is_closing():
                return
            if self.full or self.pending >= MOST_PENDING:
                self.transport.pause_reading()
                return
            if not self.deal():
                self.transport.resume_reading()
                return
        self.transport.pause_reading()
        self.schedule()

    def deal(self) -> bool:
        """Deal with the next message, and return whether there was one."""
        try:
            message = self.stream.take()
        except BadStream as error:
            self.drop(str(error))
            return False
        if message is None:
            return False
        self.listener.held -= len(message)
        self.spoke, self.heard = True, self.listener.tick()
        self.pending += 1
        self.listener.dispatch(message, self.answer)
        return True

    def schedule(self) -> None:
        """Come back when the others had their turn."""
        if not self.scheduled:
            self.scheduled = True
            self.loop.call_soon(self.work)

    def answer(self, reply: bytes | None) -> None:
        """Send a reply."""
        waited = self.pending >= MOST_PENDING
        self.pending -= 1
        if self.transport.is_closing():
            return
        if reply is not None:
            self.transport.write(reply)
        if waited:
            self.schedule()

    def pause_writing(self) -> None:
        """Wait until replies are fetched."""
        self.full = True
        self.watch_replies()
        self.listener.bound_unsent()

    def resume_writing(self) -> None:
        """Go on."""
        self.full = False
        if self.watch is not None:
            self.watch.cancel()
            self.watch = None
        self.schedule()

    def watch_replies(self, waiting: int | None = None) -> None:
        """Drop the client when none of the replies that wait (bytes) has been fetched for long."""
        left = self.unsent
        if waiting is not None and left >= waiting:
            self.drop(f"it has not fetched its replies for {STALLED:g} s")
        else:
            self.watch = self.loop.call_later(STALLED, self.watch_replies, left)

    @property
    def unsent(self) -> int:
        """Return the bytes of replies that were not fetched."""
        return self.transport.get_write_buffer_size()

    def drop(self, why: str) -> None:
        """End the connection at once."""
        log.warning("a connection is dropped: %s", why)
        self.transport.abort()


class Listener:
    """Listens for clients, and keeps what they cost within bounds.

    Args:
        dispatch: does what a message asks, and calls back with the reply
    """

    def __init__(self, dispatch: Dispatch) -> None:
        self.dispatch = dispatch
        self.connections: set[Connection] = set()
        self.held = 0
        self.events = 0
        self.server: asyncio.Server | None = None

    async def open(self, host: str = LOOPBACK, port: int = PORT) -> int:
        """Listen, and return the port: the one given, or a free one for 0. An empty host is the loopback interface.

        Raises:
            InputError: nothing can listen there.
        """
        loop = asyncio.get_running_loop()
        address = host or LOOPBACK
        try:
            self.server = await loop.create_server(lambda: Connection(self), address, port)
        except (OSError, OverflowError) as error:
            used = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
            why = "in use, by another server perhaps; choose another" if used else str(error)
            raise InputError("server", [Problem("port", f"{port} of {address}: {why}")]) from None
        number: int = self.server.sockets[0].getsockname()[1]
        return number

    async def close(self) -> None:
        """Stop listening, and end every connection."""
        if self.server is not None:
            self.server.close()
        for connection in list(self.connections):
            connection.transport.abort()
        await asyncio.sleep(0)

    def add(self, connection: Connection) -> None:
        """Count a connection in, and another one out where there are too many."""
        if len(self.connections) >= MOST_CONNECTIONS:
            silent = min(self.connections, key=lambda each: (each.pending > 0, each.spoke, each.heard))
            silent.drop(f"there are more than {MOST_CONNECTIONS}, and it has been silent longest")
            self.remove(silent)
        connection.heard = self.tick()
        self.connections.add(connection)

    def tick(self) -> int:
        """Return the number of one more event."""
        self.events += 1
        return self.events

    def remove(self, connection: Connection) -> None:
        """Count a connection out."""
        if connection in self.connections:
            self.connections.remove(connection)
            self.held -= len(connection.stream)

    def bound_held(self) -> None:
        """Drop the connection that holds most where all together hold too much."""
        if self.held > MOST_HELD:
            largest = max(self.connections, key=lambda each: len(each.stream))
            largest.drop(f"all hold more than {MOST_HELD} bytes of incomplete messages, and it most")
            self.remove(largest)

    def bound_unsent(self) -> None:
        """Drop the connection with most replies that wait where there are too many of all together."""
        if sum(each.unsent for each in self.connections) > MOST_UNSENT:
            largest = max(self.connections, key=lambda each: each.unsent)
            largest.drop(f"more than {MOST_UNSENT} bytes of replies wait, and most for it")
            self.remove(largest)
