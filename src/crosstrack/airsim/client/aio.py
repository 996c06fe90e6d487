"""The client for asyncio."""

import asyncio
from typing import Any, Self, TypeVar, cast

from crosstrack.airsim.bulk import decode_bulk
from crosstrack.airsim.client.call import Call
from crosstrack.airsim.client.calls import Calls
from crosstrack.airsim.client.errors import RemoteError
from crosstrack.airsim.messages import LARGEST_REPLY, BadStream, Stream, read_reply, request
from crosstrack.errors import LinkLost

Result = TypeVar("Result")


class AsyncClient(Calls, asyncio.Protocol):
    """Talk to AirSim, or to `crosstrack serve`, from coroutines: every call is a future, sent at once.

    Args:
        host: where the server is
        port: where it listens
        timeout: s, for connecting and for every call that is answered at once
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 41451, timeout: float = 10.0) -> None:
        self.host, self.port, self.timeout = host, port, timeout
        self.calls: dict[int, tuple[Call[Any], asyncio.Future[Any]]] = {}
        self.lost: str | None = "not connected"
        self.number = 0
        self.cosys = False
        self.stream = Stream(LARGEST_REPLY)

    async def connect(self) -> Self:
        """Connect, and return the client.

        Raises:
            LinkLost: there is no server, or it does not answer.
        """
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(self.timeout):
                await loop.create_connection(lambda: self, self.host, self.port)
        except (OSError, OverflowError) as error:
            why = str(error) or f"no answer within {self.timeout:g} s"
            raise LinkLost(f"no server at {self.host}:{self.port}: {why}") from None
        try:
            self.cosys = await self.get_server_version() > 1
        except BaseException:
            self.close()
            raise
        return self

    async def __aenter__(self) -> Self:
        """Connect, and return the client."""
        return await self.connect()

    async def __aexit__(self, *_: object) -> None:
        """Close the connection."""
        self.close()

    def close(self) -> None:
        """Close the connection; what is on its way is lost."""
        self.lose("the client was closed")
        self.transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        self.transport = cast(asyncio.Transport, transport)
        self.stream = Stream(LARGEST_REPLY)
        self.lost = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Let every call on its way know."""
        self.lose("the server closed the connection" if exc is None else f"the connection is lost: {exc}")

    def data_received(self, data: bytes) -> None:
        """Hand the replies that arrived to their calls."""
        try:
            self.stream.feed(data)
            while (message := self.stream.take()) is not None:
                reply = read_reply(decode_bulk(message))
                call, future = self.calls.pop(reply.id, (None, None)) if reply is not None else (None, None)
                if reply is None or call is None or future is None or future.done():
                    continue
                try:
                    future.set_result(call.result(reply))
                except RemoteError as error:
                    future.set_exception(error)
        except BadStream as error:
            self.lose(f"the server sends what is no reply: {error}")
            self.transport.abort()

    def lose(self, why: str) -> None:
        """Let every call on its way know that there will be no reply."""
        if self.lost is None:
            self.lost = why
        calls, self.calls = self.calls, {}
        for call, future in calls.values():
            if not future.done():
                future.set_exception(LinkLost(f"{call.method}: {self.lost}"))

    def begin(self, call: Call[Result]) -> "asyncio.Future[Result]":
        """Make a call, and return the future of its result.

        Raises:
            InputError: an argument is of the wrong type.
            LinkLost: the connection is gone.
        """
        arguments = call.pack(self.cosys)
        if self.lost is not None:
            raise LinkLost(f"{call.method}: {self.lost}")
        self.number = (self.number + 1) % (1 << 32)
        future: asyncio.Future[Result] = asyncio.get_running_loop().create_future()
        # That nobody waits for a call is no mistake: what became of it counts as looked at.
        future.add_done_callback(lambda done: done.cancelled() or done.exception())
        self.calls[self.number] = call, future
        self.transport.write(request(self.number, call.method, arguments))
        return future

    def query(self, call: Call[Result]) -> "asyncio.Future[Result]":
        """Make a call that is answered at once, and return the future of its result, which fails when it is late."""
        future = self.begin(call)
        number = self.number

        def late() -> None:
            self.calls.pop(number, None)
            if not future.done():
                future.set_exception(LinkLost(f"{call.method}: no answer within {self.timeout:g} s"))

        timer = asyncio.get_running_loop().call_later(self.timeout, late)
        future.add_done_callback(lambda _: timer.cancel())
        return future
