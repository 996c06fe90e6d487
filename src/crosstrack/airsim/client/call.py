"""Calls as values, and the methods of the clients that are made of them.

A method of a client is written once, as a function that makes a `Call`. Asked of a `Client` it blocks, or gives a
`Pending` where the server takes its time; asked of an `AsyncClient` it gives a future.
"""

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Concatenate, Generic, ParamSpec, TypeVar, overload

from crosstrack.airsim.client.errors import RemoteError
from crosstrack.airsim.codec import BadCast
from crosstrack.airsim.messages import Reply
from crosstrack.airsim.methods import METHODS
from crosstrack.errors import InputError, Problem

if TYPE_CHECKING:
    from crosstrack.airsim.client.aio import AsyncClient
    from crosstrack.airsim.client.blocking import Client, Pending

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


class Call(Generic[Result]):
    """What is asked of the server.

    Args:
        method: as on the wire
        arguments: in AirSim's order
    """

    def __init__(self, method: str, *arguments: Any) -> None:
        self.method = method
        self.arguments = arguments

    def pack(self, cosys: bool) -> list[bytes]:
        """Return the packed arguments, as AirSim or Cosys-AirSim wants them.

        Raises:
            InputError: some are of the wrong type.
        """
        packed, problems = [], []
        for name, codec, value in METHODS[self.method].arranged(self.arguments, cosys):
            try:
                packed.append(codec.pack(value))
            except (TypeError, ValueError, OverflowError, AttributeError) as error:
                problems.append(Problem(name, f"{value!r:.60}: {error}"))
        if problems:
            raise InputError(self.method, problems)
        return packed

    def result(self, reply: Reply) -> Result:
        """Return what the server answered.

        Raises:
            RemoteError: it answered an error, or something else than the method does.
        """
        if reply.error is not None:
            raise RemoteError(self.method, str(reply.error))
        try:
            value: Result = METHODS[self.method].result.unpack(reply.result)
        except BadCast as error:
            raise RemoteError(self.method, f"an answer of another kind: {error}") from None
        return value


class Query(Generic[Parameters, Result]):
    """A method that is answered at once."""

    def __init__(self, make: Callable[Concatenate[Any, Parameters], Call[Result]]) -> None:
        self.make = make

    @overload
    def __get__(self, client: None, kind: type) -> Callable[Concatenate[Any, Parameters], Call[Result]]: ...
    @overload
    def __get__(self, client: "Client", kind: type) -> Callable[Parameters, Result]: ...
    @overload
    def __get__(self, client: "AsyncClient", kind: type) -> "Callable[Parameters, asyncio.Future[Result]]": ...
    def __get__(self, client: "Client | AsyncClient | None", kind: type) -> Any:
        """Return the method of a client; of its class, the function that makes the call."""
        if client is None:
            return self.make
        query = client.query

        def ask(*arguments: Parameters.args, **named: Parameters.kwargs) -> Any:
            return query(self.make(client, *arguments, **named))

        return ask


class Move(Generic[Parameters, Result]):
    """A method that is answered when something is over, which may take as long as it likes."""

    def __init__(self, make: Callable[Concatenate[Any, Parameters], Call[Result]]) -> None:
        self.make = make

    @overload
    def __get__(self, client: None, kind: type) -> Callable[Concatenate[Any, Parameters], Call[Result]]: ...
    @overload
    def __get__(self, client: "Client", kind: type) -> "Callable[Parameters, Pending[Result]]": ...
    @overload
    def __get__(self, client: "AsyncClient", kind: type) -> "Callable[Parameters, asyncio.Future[Result]]": ...
    def __get__(self, client: "Client | AsyncClient | None", kind: type) -> Any:
        """Return the method of a client; of its class, the function that makes the call."""
        if client is None:
            return self.make
        begin = client.begin

        def start(*arguments: Parameters.args, **named: Parameters.kwargs) -> Any:
            return begin(self.make(client, *arguments, **named))

        return start


query, move = Query, Move
"""as decorators"""
