"""From a message to the handler of its method, and from what the handler returns to a reply, in rpclib's words."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from crosstrack.airsim.codec import BadCast
from crosstrack.airsim.messages import (
    BadStream,
    Request,
    decode,
    failure,
    read_request,
    result,
    thrown,
    unknown,
    wrong_arity,
)
from crosstrack.airsim.methods import METHODS, WrongArity
from crosstrack.airsim.server.errors import Refused

Handler = Callable[..., Any]
Answer = Callable[[bytes | None], None]
"""called once for each message with the reply, or with None where there is none to send"""

log = logging.getLogger(__name__)


class NoSuchMethod(Exception):  # noqa: N818 - not of the server's making
    """A call of a method that nothing handles."""


class Dispatcher:
    """Calls handlers by the names of methods.

    A handler gets the simulator and the arguments of the call, and returns its result, or a future of it.

    Args:
        simulator: the first argument of every handler
        handlers: by the name of the method
    """

    def __init__(self, simulator: Any, handlers: Mapping[str, Handler]) -> None:
        self.simulator = simulator
        self.handlers = handlers

    def dispatch(self, message: bytes, answer: Answer) -> None:
        """Do what a message asks, and answer it: at once, or when the future of its handler is done."""
        try:
            request = read_request(decode(message))
        except BadStream as error:
            log.warning("a message is passed over: %s", error)
            request = None
        if request is None:
            answer(None)
            return
        try:
            value = self.call(request)
        except Exception as error:  # whatever a handler raises, the others are served
            answer(reply_to(request, failed(request, error)))
            return
        if isinstance(value, asyncio.Future):
            value.add_done_callback(partial(finish, request, answer))
        else:
            answer(packed(request, value))

    def call(self, request: Request) -> Any:
        """Return what the handler of a call returns."""
        handler = self.handlers.get(request.name)
        if handler is None:
            raise NoSuchMethod
        return handler(self.simulator, *METHODS[request.name].unpack(request.arguments))


def finish(request: Request, answer: Answer, done: "asyncio.Future[Any]") -> None:
    """Answer a call whose future is done."""
    if done.cancelled():
        answer(reply_to(request, thrown(request.name, len(request.arguments), "the server stops")))
    elif (error := done.exception()) is not None:
        answer(reply_to(request, failed(request, error)))
    else:
        answer(packed(request, done.result()))


def packed(request: Request, value: Any) -> bytes | None:
    """Return the reply that carries a result."""
    if request.id is None:
        return None
    try:
        return result(request.id, METHODS[request.name].result.pack(value))
    except Exception as error:  # a handler that returns something else is as bad as one that fails
        return reply_to(request, failed(request, error))


def reply_to(request: Request, words: str) -> bytes | None:
    """Return the reply that carries an error."""
    return None if request.id is None else failure(request.id, words)


def failed(request: Request, error: BaseException) -> str:
    """Return rpclib's words for what went wrong; log it where it is a mistake of ours."""
    name, count = request.name, len(request.arguments)
    match error:
        case Refused():
            return thrown(name, count, str(error))
        case BadCast():
            return thrown(name, count, "std::bad_cast")
        case WrongArity():
            return wrong_arity(name, count, len(METHODS[name].parameters))
        case NoSuchMethod():
            return unknown(name, count)
    log.error("%s failed", name, exc_info=error)
    return thrown(name, count, f"{type(error).__name__}: {error}")
