"""A rendezvous and the remote site's end of a tunnel in one event loop: problems, and strangers."""

import asyncio
import socket
import threading
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from common.config.link_models import TunnelConfig
from common.link import host_name
from teletaction.tunnel import tunnel_end
from teletaction.tunnel.connection import Connection, close_all
from teletaction.tunnel.greeting import READY, new_hello, read_hello, request
from teletaction.tunnel.rendezvous import MOST_STRANGERS, SECOND_END, Rendezvous
from teletaction.tunnel.room_secret import create_secret
from teletaction.tunnel.tunnel_end import TunnelEnd, run_tunnel
from tests.conftest import free_ports
from tests.ports import free_port

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


def test_a_second_remote_end_is_refused_with_the_reason_until_the_first_is_gone(
    caplog: pytest.LogCaptureFixture,
) -> None:
    room = Rendezvous({ROOM: SECRET})

    async def main() -> None:
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]

        async def second_is_refused(first: TunnelEnd) -> None:
            async def takes_over(second: TunnelEnd) -> None:
                await until(lambda: second.problem == f"127.0.0.1:{port}: {SECOND_END}")
                assert (first.figures()["ready"], first.problem) == (READY, "")
                await first.close()
                await until(lambda: second.figures()["ready"] == READY and second.problem == "")

            await until(lambda: first.figures()["ready"] == READY)
            await with_remote_end(port, "127.0.0.1", takes_over)

        try:
            await with_remote_end(port, "127.0.0.1", second_is_refused)
        finally:
            server.close()
            await close_all(room.connections)

    asyncio.run(main())
    said = [record.getMessage() for record in caplog.records]
    assert said.count(f"room {ROOM}: refused a second remote end, at 127.0.0.1") == 1
    assert len([line for line in said if line.endswith(SECOND_END)]) == 1


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


async def with_silent_rendezvous(test: Callable[[int], Awaitable[None]]) -> None:
    """Test with the port of a rendezvous that accepts and says nothing."""
    accepted = set[Connection]()
    server = await asyncio.get_running_loop().create_server(lambda: Connection(accepted), "127.0.0.1", 0)
    try:
        await test(server.sockets[0].getsockname()[1])
    finally:
        server.close()
        await close_all(accepted)


def test_a_rendezvous_that_says_nothing_holds_no_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tunnel_end, "ANSWER_S", 0.2)

    async def test(port: int) -> None:
        config = TunnelConfig(
            side="operator", host="127.0.0.1", port=port, room=ROOM, secret=Path("unused"), base_port=free_ports()
        )
        end = TunnelEnd(config, SECRET)
        await end.listen()
        try:
            for _ in range(5):
                _, writer = await asyncio.open_connection("127.0.0.1", config.base_port)
                writer.close()
                await writer.wait_closed()
            await until(lambda: len(end.connections) > 5)
            await until(lambda: not end.connections)
            assert end.problem == f"127.0.0.1:{port}: no answer"
        finally:
            await end.close()

    asyncio.run(with_silent_rendezvous(test))


def test_the_remote_end_is_not_ready_at_a_rendezvous_that_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tunnel_end, "ANSWER_S", 0.5)

    async def shown(end: TunnelEnd) -> None:
        await until(lambda: "no answer" in end.problem)
        await until(lambda: len(end.connections) == READY)
        await asyncio.sleep(0.4)  # longer than CONNECT_S
        assert end.figures()["ready"] == 0
        assert "no answer" in end.problem

    asyncio.run(with_silent_rendezvous(lambda port: with_remote_end(port, "127.0.0.1", shown)))


def test_bytes_that_arrive_with_a_request_do_not_end_the_wait_for_a_slow_reader() -> None:
    async def main() -> None:
        loop, every = asyncio.get_running_loop(), set[Connection]()
        ends = [socket.socketpair() for _ in range(2)]
        for end in (end for pair in ends for end in pair):
            end.setblocking(False)
        (sender, one), (other, _) = ends[0], ends[1]
        _, here = await loop.create_connection(lambda: Connection(every), sock=one)
        _, there = await loop.create_connection(lambda: Connection(every), sock=other)
        here.transport.pause_reading()
        here._head = bytes(1 << 20)
        Connection.join(here, there)
        sending = asyncio.create_task(loop.sock_sendall(sender, bytes(1 << 24)))
        await asyncio.sleep(0.2)
        assert there.transport.get_write_buffer_size() <= 1 << 20
        sending.cancel()
        await close_all(every)
        for end in (sender, ends[1][1]):
            end.close()

    asyncio.run(main())


def test_a_refused_end_tries_again_at_its_pace_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tunnel_end, "AGAIN_S", 10.0)
    room = Rendezvous({ROOM: b"another secret".ljust(32)})

    async def test(end: TunnelEnd) -> None:
        await until(lambda: "room and secret do not match" in end.problem)
        await asyncio.sleep(0.5)
        assert room.refused <= 2 * READY

    async def main() -> None:
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", 0)
        try:
            await with_remote_end(server.sockets[0].getsockname()[1], "127.0.0.1", test)
        finally:
            server.close()
            await close_all(room.connections)

    asyncio.run(main())


def test_what_follows_an_answer_is_carried_and_asks_for_no_further_stream() -> None:
    followed = b"stream 0\n" * 1000

    async def main() -> None:
        loop, ports = asyncio.get_running_loop(), free_ports()
        config = TunnelConfig(
            side="remote", host="127.0.0.1", port=1, room=ROOM, secret=Path("unused"), base_port=ports
        )
        end, (rendezvous, here) = TunnelEnd(config, SECRET), socket.socketpair()
        with rendezvous, socket.create_server(("127.0.0.1", ports)) as site:
            site.setblocking(False)
            await loop.create_connection(lambda: tunnel_end._Ready(end), sock=here)
            rendezvous.sendall(new_hello()[0].encode() + b"\nstream 0\n" + followed)
            try:
                async with asyncio.timeout(3.0):
                    stream, _ = await loop.sock_accept(site)
                    with stream:
                        arrived = b""
                        while len(arrived) < len(followed):
                            arrived += await loop.sock_recv(stream, len(followed))
                assert arrived == followed
                with pytest.raises(BlockingIOError):
                    site.accept()
            finally:
                await end.close()

    asyncio.run(main())


def test_it_ends_at_once_while_the_name_server_does_not_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    over, asked = threading.Event(), threading.Event()

    def look_up(*_: object, **__: object) -> None:
        asked.set()
        over.wait(10.0)
        raise socket.gaierror(socket.EAI_AGAIN, "Temporary failure in name resolution")

    monkeypatch.setattr(socket, "getaddrinfo", look_up)
    monkeypatch.setattr(host_name, "look_up", look_up)
    create_secret(tmp_path / "secret")
    config = TunnelConfig(side="remote", host="rendezvous.example", room=ROOM, secret=tmp_path / "secret")
    begun_s = time.monotonic()
    run_tunnel(config, asked.is_set)
    assert time.monotonic() - begun_s < 5.0
    over.set()


def test_a_name_is_looked_up_and_its_problem_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    port, room = free_port(), Rendezvous({ROOM: SECRET})
    answers: list[str] = []

    def look_up(*_: object, **__: object) -> list[tuple[object, ...]]:
        if not answers:
            raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")
        return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (answer, port)) for answer in answers]

    monkeypatch.setattr(host_name, "look_up", look_up)
    monkeypatch.setattr(host_name, "AGAIN_S", 0.05)

    async def test(end: TunnelEnd) -> None:
        await until(lambda: "not known" in end.problem)
        answers.append("127.0.0.1")
        server = await asyncio.get_running_loop().create_server(room.visitor, "127.0.0.1", port)
        try:
            await until(lambda: end.figures()["ready"] == READY and end.problem == "")
        finally:
            server.close()
            await close_all(room.connections)

    asyncio.run(with_remote_end(port, "rendezvous.example", test))
