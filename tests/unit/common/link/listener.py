"""Somebody on the way between two ends, who reads and may change the bytes."""

import asyncio
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from tests.ports import free_port


@contextmanager
def running(run: Callable[[Any, Callable[[], bool]], None], config: object) -> Iterator[None]:
    """Run a process's function in a thread."""
    stop = threading.Event()
    thread = threading.Thread(target=run, args=(config, stop.is_set))
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(10.0)
        assert not thread.is_alive()


CHANGES: tuple[Callable[[bytes], bytes], ...] = (
    lambda data: data[:-1] + bytes([data[-1] ^ 1]),
    lambda data: bytes([data[0] ^ 255]) + data[1:],
    lambda data: data + data,
    lambda data: data + secrets.token_bytes(40),
    lambda data: data[:-1],
)
"""Changes of bytes on the way: another bit at either end, twice the same, more, less."""


class Listener:
    """Somebody between an end and the rendezvous, who reads all bytes and may change them.

    Attributes:
        heard: all bytes of both directions.
        pieces: number of pieces of bytes so far.
        change: what becomes of each piece of bytes.
    """

    def __init__(self, to_port: int, port: int = 0) -> None:
        """Carry to `to_port` what comes at `port`; 0 takes a free one."""
        self.heard = bytearray()
        self.pieces = 0
        self.change: Callable[[bytes], bytes] = bytes
        self.port = port or free_port()
        self._to_port = to_port
        self._clients: dict[asyncio.Task[None], asyncio.StreamWriter] = {}

    @contextmanager
    def listening(self) -> Iterator[None]:
        with running(lambda _, stop: asyncio.run(self._run(stop)), None):
            yield

    async def _run(self, stop: Callable[[], bool]) -> None:
        server = await asyncio.start_server(self._accept, "127.0.0.1", self.port)
        while not stop():
            await asyncio.sleep(0.05)
        server.close()
        for client in (clients := dict(self._clients)):
            client.cancel()
        await asyncio.gather(*clients, return_exceptions=True)
        await _end(*clients.values())  # a client that had not begun has ended nothing

    def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        client = asyncio.create_task(self._client(reader, writer))
        self._clients[client] = writer
        client.add_done_callback(self._clients.pop)

    async def _client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        connecting = asyncio.create_task(asyncio.open_connection("127.0.0.1", self._to_port))
        try:
            to_reader, to_writer = await asyncio.shield(connecting)
            ways = [asyncio.create_task(self._carry(*way)) for way in ((reader, to_writer), (to_reader, writer))]
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            for way in ways:
                way.cancel()
            await asyncio.wait(ways)
        except OSError:
            pass
        finally:
            await _end(writer)
            with suppress(OSError):  # a cancelled client ends a connection that was just made, too
                await _end((await connecting)[1])

    async def _carry(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            while data := await reader.read(4096):
                self.heard += data
                self.pieces += 1
                writer.write(self.change(data))
                await writer.drain()


async def _end(*writers: asyncio.StreamWriter) -> None:
    for writer in writers:
        writer.transport.abort()
        with suppress(OSError):
            await writer.wait_closed()
