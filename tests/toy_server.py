"""A server of the protocol with a handful of toy handlers, in a thread of its own."""

import asyncio
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import msgpack

from crosstrack.airsim.server.dispatch import Dispatcher
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.transport import Listener
from crosstrack.airsim.structs import MultirotorState

LARGE = "x" * (1 << 20)


def later(_: object, seconds: float, vehicle: str) -> "asyncio.Future[bool]":
    async def rise() -> bool:
        await asyncio.sleep(seconds)
        if vehicle == "broken":
            raise Refused("it moves")
        return True

    return asyncio.ensure_future(rise())


def refuse(_: object, vehicle: str) -> bool:
    raise Refused(f"no {vehicle}")


HANDLERS: dict[str, Callable[..., Any]] = {
    "ping": lambda _: True,
    "getServerVersion": lambda _: 1,
    "getMultirotorState": lambda _, vehicle: MultirotorState(timestamp=7),
    "getSettingsString": lambda _: LARGE,
    "takeoff": later,
    "hover": refuse,
    "listVehicles": lambda _: 1 / 0,
    "simListAssets": lambda _: 5,
    "simRunConsoleCommand": lambda simulator, command: simulator.append(command) or True,
    "moveToZ": lambda _, z, speed, timeout, yaw_mode, lookahead, adaptive, vehicle: z == 2.5 and yaw_mode.is_rate,
}


class Toy:
    """A running toy server."""

    def __init__(self, handlers: Mapping[str, Callable[..., Any]]) -> None:
        self.heard: list[str] = []
        self.loop = asyncio.new_event_loop()
        self.listener = Listener(Dispatcher(self.heard, handlers).dispatch)
        self.port = self.loop.run_until_complete(self.listener.open(port=0))
        self.thread = threading.Thread(target=self.loop.run_forever)
        self.thread.start()

    def run(self, function: Callable[[], Any]) -> Any:
        """Return what a function returns that the server's thread calls."""

        async def call() -> Any:
            return function()

        return asyncio.run_coroutine_threadsafe(call(), self.loop).result(10)

    def connect(self) -> socket.socket:
        """Return a bare connection."""
        link = socket.create_connection(("127.0.0.1", self.port), 10)
        link.settimeout(10)
        return link

    def stop(self) -> None:
        """End the server and its connections."""
        if self.thread.is_alive():
            asyncio.run_coroutine_threadsafe(self.listener.close(), self.loop).result(10)
            self.loop.call_soon_threadsafe(self.loop.stop)
            self.thread.join()
            for task in asyncio.all_tasks(self.loop):
                task.cancel()
            self.loop.run_until_complete(asyncio.sleep(0.01))
            self.loop.close()


@contextmanager
def toy(handlers: Mapping[str, Callable[..., Any]] = HANDLERS) -> Iterator[Toy]:
    """Run a toy server."""
    server = Toy(handlers)
    try:
        yield server
    finally:
        server.stop()


def replies(link: socket.socket, count: int) -> list[Any]:
    """Return as many replies as were asked for, or fewer where the connection ends."""
    unpacker = msgpack.Unpacker(max_buffer_size=1 << 30)
    found: list[Any] = []
    while len(found) < count and (data := link.recv(1 << 16)):
        unpacker.feed(data)
        found += list(unpacker)
    return found


def ask(link: socket.socket, number: int, name: str, *arguments: object) -> list[Any]:
    """Send a request as any msgpack packer packs it, and return the reply."""
    link.sendall(msgpack.packb([0, number, name, list(arguments)]))
    reply: list[Any] = replies(link, 1)[0]
    return reply


def until(holds: Callable[[], bool]) -> bool:
    """Wait until something holds."""
    end = time.monotonic() + 10
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
