"""Connections that send nothing, or not all, keep nobody out; with TLS and without."""

import asyncio
import gc
import logging
import socket
import ssl
import subprocess
from asyncio import sslproto
from collections.abc import AsyncIterator
from contextlib import ExitStack, asynccontextmanager, closing, suppress
from pathlib import Path

import pytest
import uvicorn
from starlette.types import Receive, Scope, Send

from common.runtime.containment import Containment
from common.web import connections as rule
from common.web.connections import Connections
from common.web.door import Accepted, Door, Stages
from tests.conftest import Contained

MOST = 8
HEAD = b"GET / HTTP/1.1\r\nHost: localhost\r\n"


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificate")
    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "1")
    names = ("-addext", "subjectAltName=DNS:localhost", "-keyout", folder / "key.pem", "-out", folder / "both.pem")
    subprocess.run(
        ("openssl", "req", "-x509", "-subj", "/CN=localhost", *curve, *names), capture_output=True, check=True
    )
    return folder / "both.pem"


async def page(scope: Scope, receive: Receive, send: Send) -> None:
    """A page of two bytes; a websocket at /page is sent a text and stays, one elsewhere is sent away."""
    if scope["path"] == "/broken":
        raise KeyError("broken")
    if scope["type"] == "http":
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
        await send({"type": "http.response.body", "body": b"ok"})
        return
    await send({"type": "websocket.accept"})
    if scope["path"] == "/page":
        await send({"type": "websocket.send", "text": "hello"})
        while (await receive())["type"] != "websocket.disconnect":
            pass
    else:
        await send({"type": "websocket.close", "code": 4401})


@asynccontextmanager
async def served(certificate: Path | None = None) -> AsyncIterator[tuple[Door, int, ExitStack]]:
    """A door with MOST places, its port, and what is closed after it."""
    connections = Connections(MOST)
    key = None if certificate is None else certificate.with_name("key.pem")
    stages = Stages(page, connections, Containment())
    config = uvicorn.Config(
        stages, lifespan="off", log_config=None, ws="websockets-sansio", ssl_certfile=certificate, ssl_keyfile=key
    )
    config.load()
    listening = socket.create_server(("127.0.0.1", 0), backlog=200)
    with ExitStack() as opened, closing(Door(listening, uvicorn.Server(config), connections)) as door:
        yield door, listening.getsockname()[1], opened


async def got(port: int, trust: ssl.SSLContext | None = None) -> bytes:
    """The answer to one request, on a connection of its own."""
    name = None if trust is None else "localhost"
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=trust, server_hostname=name)
    writer.write(HEAD + b"\r\n")
    answer = await asyncio.wait_for(reader.readuntil(b"\r\n\r\nok"), 5.0)
    writer.close()
    with suppress(ConnectionError, ssl.SSLError):
        await writer.wait_closed()
    return answer


async def until_closed(line: socket.socket) -> None:
    """Wait until the other end has closed it."""
    with suppress(ConnectionError):
        while await asyncio.wait_for(asyncio.get_running_loop().sock_recv(line, 4096), 5.0):
            pass


def half_open(opened: ExitStack, port: int, sent: bytes) -> socket.socket:
    """A connection that sends no more than this."""
    line = opened.enter_context(socket.create_connection(("127.0.0.1", port)))
    line.sendall(sent)
    line.setblocking(False)
    return line


@pytest.mark.parametrize("sent", [b"", HEAD, b"\x16\x03\x01"])
@pytest.mark.parametrize("tls", [False, True])
def test_half_open_connections_do_not_keep_a_page_out(certificate: Path, sent: bytes, tls: bool) -> None:
    trust = ssl.create_default_context(cafile=certificate) if tls else None

    async def flood() -> None:
        async with served(certificate if tls else None) as (door, port, opened):
            lines = [half_open(opened, port, sent) for _ in range(10 * MOST)]
            for _ in range(5):
                assert b"200 OK" in await got(port, trust)
                assert len(door.connections) <= MOST
            await until_closed(lines[0])
            assert sent or door.connections.dropped >= 9 * MOST

    asyncio.run(flood())


@pytest.mark.parametrize("at_once", [1, 10 * MOST])
def test_a_tls_handshake_that_ends_early_frees_its_memory_at_once(certificate: Path, at_once: int) -> None:
    """It was dropped for another one, or was no handshake. It holds 256 KiB until Python collects garbage."""

    def handshakes() -> int:
        return sum(isinstance(found, sslproto.SSLProtocol) for found in gc.get_objects())

    async def flood() -> int:
        asyncio.get_running_loop().set_exception_handler(lambda *_: None)  # records of the log would hold the errors
        async with served(certificate) as (door, port, opened):
            for _ in range(10 * MOST // at_once):
                for line in [half_open(opened, port, HEAD) for _ in range(at_once)]:
                    await until_closed(line)
            assert door.connections.dropped == 0 if at_once == 1 else door.connections.dropped >= 8 * MOST
            return handshakes()

    gc.collect()
    before = handshakes()
    gc.disable()
    try:
        assert asyncio.run(flood()) - before <= 2 * MOST
    finally:
        gc.enable()


@pytest.mark.parametrize("tls", [False, True])
def test_a_half_open_connection_is_closed_in_time(
    certificate: Path, tls: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rule, "IDLE_S", -1.0)

    async def wait() -> None:
        async with served(certificate if tls else None) as (door, port, opened):
            line = half_open(opened, port, b"")
            while not len(door.connections):
                await asyncio.sleep(0.0)
            door.step()
            await until_closed(line)
            while len(door.connections):
                await asyncio.sleep(0.0)
            assert door.connections.dropped == 1

    asyncio.run(wait())


UPGRADE = (
    b" HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


def test_a_page_is_never_dropped_and_one_that_was_sent_away_is(monkeypatch: pytest.MonkeyPatch) -> None:
    async def flood() -> None:
        async with served() as (door, port, opened):
            loop = asyncio.get_running_loop()
            inside, away = (half_open(opened, port, b"GET " + path + UPGRADE) for path in (b"/page", b"/other"))
            heard = b""
            while b"hello" not in heard:
                heard += await asyncio.wait_for(loop.sock_recv(inside, 4096), 5.0)
            assert await asyncio.wait_for(loop.sock_recv(away, 4096), 5.0)
            for _ in range(3 * MOST):
                half_open(opened, port, HEAD)
                await asyncio.sleep(0.0)
            assert b"200 OK" in await got(port)
            monkeypatch.setattr(rule, "IDLE_S", -1.0)
            door.step()
            await until_closed(away)
            inside.sendall(b"\x89\x80\x00\x00\x00\x00")  # a ping
            assert (await asyncio.wait_for(loop.sock_recv(inside, 4096), 5.0))[0] == 0x8A

    asyncio.run(flood())


@pytest.mark.parametrize("path", [b"/page", b"/other"])
def test_a_websocket_that_sends_pings_and_reads_nothing_is_closed(path: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule, "MOST_UNSENT", 1 << 16)
    pings = 1000 * (b"\x89\xfd\x00\x00\x00\x00" + bytes(125))

    async def flood() -> None:
        async with served() as (door, port, opened):
            loop = asyncio.get_running_loop()
            line = half_open(opened, port, b"GET " + path + UPGRADE)
            assert b"101 " in await asyncio.wait_for(loop.sock_recv(line, 4096), 5.0)
            with suppress(ConnectionError):
                for _ in range(100):  # 13 MB, more than the system keeps for both ends
                    await loop.sock_sendall(line, pings)
                    door.step()
            assert not len(door.connections)
            assert b"200 OK" in await got(port)

    asyncio.run(flood())


def test_a_tls_connection_that_has_ended_twice_has_nothing_unsent(certificate: Path) -> None:
    """A client's end and the server's own may both close it; its transport then has no buffer to ask for."""

    async def ask() -> None:
        async with served(certificate) as (door, port, _):
            assert b"200 OK" in await got(port, ssl.create_default_context(cafile=certificate))
            (connection,) = [each for stage in door.connections._since_s.values() for each in stage]
            assert isinstance(connection, Accepted)
            assert connection._transport is not None
            connection._transport.close()
            connection._transport.close()
            assert connection.unsent_bytes == 0

    asyncio.run(ask())


def test_an_answered_connection_is_idle_and_a_head_that_is_too_long_is_refused() -> None:
    async def ask() -> None:
        async with served() as (door, port, _):
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(HEAD + b"\r\n")
            await reader.readuntil(b"ok")
            later_s = asyncio.get_running_loop().time() + 2.0 * rule.IDLE_S
            assert len(door.connections.overdue(later_s)) == 1
            writer.write(HEAD + b"x: " + b"x" * 17_000)
            assert b"400" in await asyncio.wait_for(reader.read(), 5.0)
            writer.close()
            await writer.wait_closed()

    logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
    asyncio.run(ask())


def test_what_a_request_raises_is_named_once_and_ends_no_other(contained: Contained) -> None:
    async def ask() -> None:
        async with served() as (_, port, _):
            for _ in range(3):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.write(HEAD.replace(b"/ ", b"/broken ", 1) + b"\r\n")
                assert b" 500 " in await asyncio.wait_for(reader.readline(), 5.0)
                writer.close()
                await writer.wait_closed()
            assert b"200 OK" in await got(port)

    asyncio.run(ask())
    (name,) = contained.take()
    assert name.startswith("request: KeyError in test_door.py:")
