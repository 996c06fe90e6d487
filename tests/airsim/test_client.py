"""The clients: every method there and back, several at once, lateness, loss."""

import asyncio
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgpack
import numpy as np
import pytest
from toy_server import HANDLERS, Toy, toy

from crosstrack import airsim
from crosstrack.airsim import arrays, codec, structs
from crosstrack.airsim.client.calls import Calls
from crosstrack.airsim.methods import METHODS, External
from crosstrack.errors import InputError, LinkLost


def example(kind: codec.Codec) -> Any:
    """Return a value that travels by a codec."""
    match kind:
        case codec.Record():
            return kind.kind(**{name: example(of) for name, of in kind.fields})
        case codec.Listed():
            return (example(kind.codec), example(kind.codec))
        case External():
            return True
        case codec.Flag():
            return True
        case codec.Whole():
            return 200
        case codec.Single() | codec.Double():
            return 2.5
        case codec.Text():
            return "näme"
        case codec.Binary():
            return b"\x00\xff"
        case arrays.Components():
            return np.arange(len(kind.keys)) + 0.5
        case arrays.Rows():
            return np.arange(6.0).reshape(2, 3)
        case arrays.Singles() | arrays.Wholes():
            return np.arange(5)
        case arrays.Matrix():
            return np.arange(16.0).reshape(4, 4)
    return None


def method_names() -> list[str]:
    """Return the Python names of all calls."""
    return [name for part in Calls.__mro__ for name, value in vars(part).items() if hasattr(value, "make")]


def test_there_is_a_name_for_every_method() -> None:
    assert len(set(method_names())) == len(METHODS)


@pytest.fixture(scope="module")
def mirror() -> Iterator[tuple[Toy, dict[str, tuple[Any, ...]]]]:
    """Run a server that has every method, and keeps the arguments of the last call of each."""
    heard: dict[str, tuple[Any, ...]] = {}

    def handler(name: str) -> Any:
        def handle(_: object, *arguments: Any) -> Any:
            heard[name] = arguments
            return 1 if name == "getServerVersion" else example(METHODS[name].result)

        return handle

    with toy({name: handler(name) for name in METHODS}) as server:
        yield server, heard


@pytest.mark.parametrize("name", method_names())
def test_every_call_arrives_as_it_was_made_and_so_does_its_result(
    name: str, mirror: tuple[Toy, dict[str, tuple[Any, ...]]]
) -> None:
    server, heard = mirror
    make = getattr(Calls, name)
    count = make.__code__.co_argcount - 1
    wire = make.__code__.co_consts[1]
    codecs = list(METHODS[wire].parameters.values())
    assert count == len(codecs)
    arguments = [example(kind) for kind in codecs]
    with airsim.Client(port=server.port) as client:
        answer = getattr(client, name)(*arguments)
        value = answer.join(10) if isinstance(answer, airsim.Pending) else answer
    for kind, sent, arrived in zip(codecs, arguments, heard[wire], strict=True):
        assert kind.pack(arrived) == kind.pack(sent)
    if wire != "getServerVersion":
        result = METHODS[wire].result
        assert result.pack(value) == result.pack(example(result))


def test_several_calls_are_on_their_way_at_once() -> None:
    with toy() as server, airsim.Client(port=server.port) as client:
        slow, fast = client.takeoff(0.4), client.takeoff(0.1)
        assert client.get_multirotor_state().timestamp == 7
        assert fast.join(10) is True
        assert not slow.done()
        assert slow.join() is True
        assert slow.done()
        assert slow.join() is True


def test_threads_share_a_client() -> None:
    with toy() as server, airsim.Client(port=server.port) as client:
        slow = client.takeoff(0.5)
        waiting = threading.Thread(target=slow.join)
        waiting.start()
        found: list[int] = []
        asking = [
            threading.Thread(target=lambda: found.append(client.get_multirotor_state().timestamp)) for _ in range(8)
        ]
        for thread in asking:
            thread.start()
        for thread in asking:
            thread.join(10)
        assert found == [7] * 8
        assert waiting.is_alive()
        waiting.join(10)
        assert slow.done()


def test_lateness_raises_and_can_be_waited_out() -> None:
    with toy() as server, airsim.Client(port=server.port) as client:
        pending = client.takeoff(0.5)
        with pytest.raises(LinkLost, match=r"takeoff: no answer within 0.05 s"):
            pending.join(0.05)
        with pytest.raises(LinkLost, match=r"takeoff: no answer within -1 s"):
            pending.join(-1)
        assert pending.join(3e38) is True
        assert client.ping()


def test_errors_of_the_server_carry_its_words() -> None:
    with toy() as server, airsim.Client(port=server.port) as client:
        with pytest.raises(airsim.RemoteError, match="no Ghost") as caught:
            client.hover("Ghost").join(10)
        assert caught.value.method == "hover"
        with pytest.raises(airsim.RemoteError, match="could not find function 'reset'"):
            client.reset()
        assert client.ping()


def test_arguments_of_the_wrong_kind_are_all_named_before_anything_is_sent() -> None:
    with toy() as server, airsim.Client(port=server.port) as client:
        with pytest.raises(InputError) as caught:
            client.move_on_path([[1, 2]], "fast")  # type: ignore[arg-type]  # what is tested
        assert [problem.place for problem in caught.value.problems] == ["path", "velocity"]
        assert client.ping()


def test_interrupts_at_any_instant_lose_no_reply() -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    rng = np.random.default_rng(1)
    before = signal.signal(signal.SIGALRM, interrupt)
    interrupted = 0
    try:
        with toy() as server, airsim.Client(port=server.port) as client:
            slow = client.takeoff(0.3)
            for _ in range(300):
                signal.setitimer(signal.ITIMER_REAL, rng.uniform(2e-4, 2e-3))
                try:
                    while True:
                        assert client.get_multirotor_state().timestamp == 7
                except KeyboardInterrupt:
                    interrupted += 1
            assert slow.join(10) is True
            assert client.ping()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert interrupted == 300


def test_a_link_that_is_lost_is_lost_for_every_call_at_once() -> None:
    server = Toy(HANDLERS)
    with airsim.Client(port=server.port) as client:
        first, second = client.takeoff(60), client.takeoff(60)
        assert client.ping()
        server.stop()
        start = time.monotonic()
        for pending in (first, second):
            with pytest.raises(LinkLost, match="takeoff: the server closed the connection"):
                pending.join()
            assert pending.done()
        with pytest.raises(LinkLost, match="ping"):
            client.ping()
        assert time.monotonic() - start < 2


def test_nobody_there_is_a_lost_link() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        with pytest.raises(LinkLost, match=f"no server at 127.0.0.1:{port}"):
            airsim.Client(port=port, timeout=1)
        with pytest.raises(LinkLost, match=f"no server at 127.0.0.1:{port}"):
            asyncio.run(airsim.AsyncClient(port=port, timeout=1).connect())


def test_a_server_that_says_nothing_is_a_lost_link() -> None:
    with socket.create_server(("127.0.0.1", 0)) as mute:
        port = mute.getsockname()[1]
        with pytest.raises(LinkLost, match=r"getServerVersion: no answer within 0.1 s"):
            airsim.Client(port=port, timeout=0.1)
        with pytest.raises(LinkLost, match=r"getServerVersion: no answer within 0.1 s"):
            asyncio.run(airsim.AsyncClient(port=port, timeout=0.1).connect())


@pytest.mark.parametrize("nonsense", [b"\xc1", b"\xdd\xff\xff\xff\xff\xc1", b"\x91" * 5000])
def test_a_server_that_sends_nonsense_is_a_lost_link(nonsense: bytes) -> None:
    def answer(listener: socket.socket) -> None:
        link, _ = listener.accept()
        with link:
            link.recv(1000)
            link.sendall(nonsense)
            link.recv(1000)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer, args=(listener,))
        thread.start()
        with pytest.raises(LinkLost, match="no reply"):
            airsim.Client(port=listener.getsockname()[1])
        thread.join(10)


def test_an_answer_of_another_kind_is_an_error_of_the_server() -> None:
    def answer(listener: socket.socket) -> None:
        link, _ = listener.accept()
        with link:
            link.recv(1000)
            link.sendall(b"\x01" + msgpack.packb([1, 99, None, 5]) + msgpack.packb([1, 1, None, "one"]))
            link.recv(1000)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=answer, args=(listener,))
        thread.start()
        with pytest.raises(airsim.RemoteError, match="an answer of another kind"):
            airsim.Client(port=listener.getsockname()[1])
        thread.join(10)


def test_a_client_speaks_cosys_airsim_where_the_server_does() -> None:
    heard: list[Any] = []

    def image(_: object, camera: str, kind: int, vehicle: str, external: bool) -> bytes:
        heard.append(external)
        return b"png"

    def pose(_: object, name: str) -> structs.Pose:
        return structs.Pose(np.array([1.0, 2.0, 3.0]))

    handlers: dict[str, Callable[..., Any]] = {
        "getServerVersion": lambda _: 4,
        "simGetImage": image,
        "simGetObjectPose": pose,
    }
    with toy(handlers) as server, airsim.Client(port=server.port) as client:
        assert client.cosys
        assert client.get_image("0", 0) == b"png"
        assert client.get_object_pose("box").position.tolist() == [1, 2, 3]
        assert heard == [False]


def test_coroutines_talk_too() -> None:
    async def talk(port: int) -> None:
        async with airsim.AsyncClient(port=port) as client:
            assert await client.ping() is True
            slow, fast = client.takeoff(0.3), client.takeoff(0.05)
            assert await fast is True
            assert not slow.done()
            assert (await client.get_multirotor_state()).timestamp == 7
            assert await slow is True
            with pytest.raises(airsim.RemoteError, match="no Ghost"):
                await client.hover("Ghost")
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(client.takeoff(60), 0.05)
            client.timeout = 0.05
            late = client.query(airsim.Client.takeoff(client, 60))
            with pytest.raises(LinkLost, match=r"takeoff: no answer within 0.05 s"):
                await late
            with pytest.raises(InputError):
                client.takeoff("soon")  # type: ignore[arg-type]  # what is tested
        with pytest.raises(LinkLost, match="closed"):
            client.ping()

    with toy() as server:
        asyncio.run(talk(server.port))


def test_coroutines_lose_the_link_at_once() -> None:
    async def talk(server: Toy) -> None:
        async with airsim.AsyncClient(port=server.port) as client:
            pending = [client.takeoff(60), client.takeoff(60)]
            await client.ping()
            await asyncio.to_thread(server.stop)
            for future in pending:
                with pytest.raises(LinkLost, match="takeoff: the "):
                    await asyncio.wait_for(future, 5)

    asyncio.run(talk(Toy(HANDLERS)))


def test_public_names_are_all_there() -> None:
    for name in airsim.__all__:
        assert getattr(airsim, name) is not None
    assert set(airsim.__all__) <= set(dir(airsim))
