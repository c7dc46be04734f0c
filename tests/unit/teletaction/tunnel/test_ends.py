"""A rendezvous and the remote site's end of a tunnel in one event loop: problems, and strangers."""

import asyncio
import socket
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from common.config.link_models import TunnelConfig
from teletaction.tunnel import tunnel_end
from teletaction.tunnel.connection import close_all
from teletaction.tunnel.greeting import read_hello, request
from teletaction.tunnel.rendezvous import MOST_STRANGERS, Rendezvous
from teletaction.tunnel.tunnel_end import READY, TunnelEnd
from tests.conftest import free_ports
from tests.unit.common.link.listener import free_port

ROOM, SECRET = "ward-3", b"s" * 32


async def until(reached: Callable[[], bool]) -> None:
    async with asyncio.timeout(3.0):
        while not reached():
            await asyncio.sleep(0.005)


async def with_remote_end(port: int, host: str, test: Callable[[TunnelEnd], Awaitable[None]]) -> None:
    config = TunnelConfig(side="remote", host=host, port=port, room=ROOM, secret=Path("unused"), base_port=free_ports())
    end = TunnelEnd(config, SECRET)
    end.begin(end.keep_ready())
    try:
        await test(end)
    finally:
        await end.close()


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tunnel_end, "AGAIN_S", 0.05)
    monkeypatch.setattr(tunnel_end, "CONNECT_S", 0.3)


@pytest.mark.parametrize("host", ["127.0.0.1", "[::1]"])
def test_a_problem_ends_when_the_rendezvous_is_there_again(host: str) -> None:
    port, room = free_port(), Rendezvous({ROOM: SECRET})

    async def test(end: TunnelEnd) -> None:
        await until(lambda: "connection refused" in end.problem)
        server = await asyncio.get_running_loop().create_server(room.visitor, host.strip("[]"), port)
        try:
            await until(lambda: end.figures()["ready"] == READY and end.problem == "")
        finally:
            server.close()
            await close_all(room.connections)

    asyncio.run(with_remote_end(port, host, test))


async def reach(port: int, stream: int, secret: bytes = SECRET) -> None:
    """Ask for a stream until the far side gives it up."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    number = read_hello((await reader.readline()).decode().strip())
    writer.write(request(secret, number, ROOM, stream).encode() + b"\n")
    await reader.read()
    writer.close()


def test_a_site_that_is_not_there_is_logged_once_for_each_port(caplog: pytest.LogCaptureFixture) -> None:
    room = Rendezvous({ROOM: SECRET})

    async def main() -> None:
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]

        async def test(end: TunnelEnd) -> None:
            for _ in range(4):
                for stream in (0, 1):
                    await reach(port, stream)
            assert end.problem.endswith("connection refused")

        try:
            await with_remote_end(port, "127.0.0.1", test)
        finally:
            server.close()
            await close_all(room.connections)

    asyncio.run(main())
    assert len([record for record in caplog.records if "connection refused" in record.getMessage()]) == 2


def test_many_strangers_at_once_stay_within_the_limit() -> None:
    room = Rendezvous({ROOM: SECRET})

    async def main() -> None:
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", 0)
        strangers = []
        for _ in range(3):
            for _ in range(MOST_STRANGERS):
                strangers.append(socket.socket())
                strangers[-1].setblocking(False)
                strangers[-1].connect_ex(server.sockets[0].getsockname())
            await asyncio.sleep(0.05)
        try:
            await until(lambda: len(room.connections) <= MOST_STRANGERS)
        finally:
            for one in strangers:
                one.close()
            server.close()
            await close_all(room.connections)

    asyncio.run(main())


def test_refusals_are_counted_and_logged_now_and_then(caplog: pytest.LogCaptureFixture) -> None:
    room = Rendezvous({ROOM: SECRET})

    async def main() -> None:
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", 0)
        for _ in range(5):
            await reach(server.sockets[0].getsockname()[1], 0, b"another secret")
        server.close()
        await close_all(room.connections)

    asyncio.run(main())
    assert room.figures()["refused"] == 5
    assert [record.getMessage() for record in caplog.records] == [f"refused a request for room {ROOM}"]
