"""One site's end of a tunnel: it connects outwards to the rendezvous, and needs no open port.

The remote site's end keeps connections ready there. When the operator's end asks for a stream, one of them is joined to
it, and the remote site's end connects to the site. Each connection of the link has a connection of its own all the way,
so that no stream waits behind another.
"""

import asyncio
import logging
import random
from collections.abc import Callable, Coroutine
from functools import partial

from common.config.link_models import TunnelConfig
from common.files.printable import printable
from common.link.host_name import Resolver, bare_host
from common.runtime.status_file import StatusFile
from common.wire.streams import STREAMS
from teletaction.tunnel.connection import Connection, close_all
from teletaction.tunnel.greeting import REACHED, READY, read_hello, read_stream, refusal, request
from teletaction.tunnel.room_secret import read_secret
from teletaction.tunnel.until_stopped import until_stopped

log = logging.getLogger(__name__)

AGAIN_S = 0.5
"""Mean time between two attempts to reach the rendezvous, s."""
CONNECT_S = 2.0
"""Maximum time of an attempt, s."""
ANSWER_S = 4.0
"""Maximum wait for a line of the rendezvous, s; it lets the operator's end wait for half of it."""
_LOOK_S = 0.05
"""Interval between two looks for the address of the rendezvous, s."""
_PORTS = tuple(stream.port for stream in STREAMS.values())
Address = tuple[str, int]
"""Host and port."""


class _Outward(Connection):
    """A connection to the rendezvous: it answers the first line with a request, and takes the answer.

    Attributes:
        greeted: whether the rendezvous has sent its first line.
    """

    def __init__(self, end: "TunnelEnd", port: int | None) -> None:
        super().__init__(end.connections)
        self._end, self._port = end, port
        self.greeted = False
        self._timer: asyncio.TimerHandle | None = None

    def opened(self) -> None:
        self._wait()

    def _wait(self) -> None:
        self._timer = asyncio.get_running_loop().call_later(ANSWER_S, self._give_up)

    def _give_up(self) -> None:
        self._end.notice(self._end.rendezvous, "no answer")
        self.transport.abort()

    def closed(self) -> None:
        if self._timer is not None:
            self._timer.cancel()

    def take_line(self, line: str) -> None:
        assert self._timer is not None
        self._timer.cancel()
        try:
            if self.greeted:
                self.answered(line)
            else:
                self.greeted = True
                config = self._end.config
                self.say(request(self._end.secret, read_hello(line), config.room, self._port))
                if self._port is not None:  # the remote site's end waits for its answer as long as nobody reaches it
                    self._wait()
        except ValueError as error:
            self._end.notice(self._end.rendezvous, str(error))
            self.transport.close()

    def answered(self, line: str) -> None:
        """Take the answer; raises ValueError for a refusal."""
        raise NotImplementedError


class _Ready(_Outward):
    """A connection of the remote site's end."""

    def __init__(self, end: "TunnelEnd") -> None:
        super().__init__(end, None)

    def answered(self, line: str) -> None:
        port = read_stream(line)
        if port not in _PORTS:
            raise ValueError(f"the link has no port {port}")
        self._end.notice(self._end.rendezvous, "")
        self._end.release(self)
        self.end_lines()
        self._end.begin(self._connect(port))

    async def _connect(self, port: int) -> None:
        config, local = self._end.config, partial(Connection, self._end.connections)
        address = bare_host(config.site_host), config.base_port + port
        site = await self._end.connect(local, address)
        if site is not None:
            self._end.notice(address, "")
        if site is None or self.transport.is_closing():
            self.transport.close()
        else:
            Connection.join(self, site)

    def closed(self) -> None:
        super().closed()
        self._end.release(self)


class _Reaching(_Outward):
    """A connection of the operator's end, for one that the site has opened."""

    def __init__(self, end: "TunnelEnd", port: int, local: Connection) -> None:
        super().__init__(end, port)
        self._local = local

    def answered(self, line: str) -> None:
        if line != REACHED:
            raise ValueError(refusal(line))
        self._end.notice(self._end.rendezvous, "")
        if self._local.transport.is_closing():
            self.transport.close()
        else:
            Connection.join(self, self._local)

    def closed(self) -> None:
        super().closed()
        if not self._local.joined:
            self._local.transport.close()


class _Local(Connection):
    """A connection that the operator's site has opened."""

    def __init__(self, end: "TunnelEnd", port: int) -> None:
        super().__init__(end.connections)
        self._end, self._port = end, port

    def opened(self) -> None:
        self.transport.pause_reading()
        self._end.begin(self._reach())

    async def _reach(self) -> None:
        if await self._end.connect(partial(_Reaching, self._end, self._port, self), self._end.rendezvous) is None:
            self.transport.close()


class TunnelEnd:
    """An end of a tunnel. Needs a running event loop.

    Attributes:
        config: its configuration.
        secret: the room's secret.
        rendezvous: host and port of the rendezvous.
        connections: all open connections.
    """

    def __init__(self, config: TunnelConfig, secret: bytes) -> None:
        self.config, self.secret = config, secret
        self.rendezvous = bare_host(config.host), config.port
        # The event loop would look the name up in a thread for which it waits at its end.
        self._resolver = Resolver(config.host, config.port)
        self.connections: set[Connection] = set()
        self._problems: dict[Address, str] = {}
        self._ready: set[_Ready] = set()
        self._fewer = asyncio.Event()
        self._tasks: set[asyncio.Task[None]] = set()
        self._servers: list[asyncio.Server] = []

    @property
    def problem(self) -> str:
        """What keeps it from working; empty when nothing does."""
        return next((f"{host}:{port}: {why}" for (host, port), why in self._problems.items()), "")

    @property
    def _waiting(self) -> int:
        """Number of connections that wait at the rendezvous."""
        return sum(ready.greeted for ready in self._ready)

    def notice(self, address: Address, problem: str) -> None:
        """Log a new problem with an address once; an empty one means that there is none any more."""
        before = self._problems.pop(address, "")
        if problem:
            self._problems[address] = problem
        if problem not in ("", before):
            log.warning("%s:%d: %s", *address, printable(problem))

    def begin(self, work: Coroutine[None, None, None]) -> None:
        """Do some work beside everything else."""
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def release(self, ready: _Ready) -> None:
        """Count a connection no longer as ready."""
        self._ready.discard(ready)
        self._fewer.set()

    async def connect(self, protocol: Callable[[], Connection], address: Address) -> Connection | None:
        """Open a connection; return None, and note the problem, where that fails."""
        loop, (host, port) = asyncio.get_running_loop(), address
        try:
            async with asyncio.timeout(CONNECT_S):
                if address == self.rendezvous:
                    host = await self._resolved()
                _, connection = await loop.create_connection(protocol, host, port)
        except (OSError, UnicodeError, TimeoutError) as error:  # UnicodeError: not a valid host name
            refused = isinstance(error, ConnectionRefusedError)
            unresolved = self._resolver.problem if address == self.rendezvous else ""
            self.notice(address, "connection refused" if refused else str(error) or unresolved or "no answer")
            return None
        return connection

    async def _resolved(self) -> str:
        """Return the address of the rendezvous, once it is known."""
        while (found := self._resolver.address) is None:
            await asyncio.sleep(_LOOK_S)
        return found

    async def keep_ready(self) -> None:
        """Keep READY connections waiting at the rendezvous until it is cancelled."""
        while True:
            self._fewer.clear()
            for _ in range(READY - len(self._ready)):
                opened = await self.connect(partial(_Ready, self), self.rendezvous)
                if opened is None:
                    break
                assert isinstance(opened, _Ready)
                self._ready.add(opened)
            all_ready = len(self._ready) == READY
            try:
                async with asyncio.timeout(CONNECT_S if all_ready else AGAIN_S):
                    await self._fewer.wait()
            except TimeoutError:
                if all_ready and self._waiting == READY:  # the rendezvous has refused none of them
                    self.notice(self.rendezvous, "")
            if self.problem:
                await asyncio.sleep(AGAIN_S * random.uniform(0.5, 1.5))

    async def close(self) -> None:
        """End all connections and all work."""
        self._resolver.close()
        for server in self._servers:
            server.close()
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await close_all(self.connections)

    async def listen(self) -> None:
        """Listen at the ports of the link; raises OSError where one is taken."""
        loop, config = asyncio.get_running_loop(), self.config
        for port in _PORTS:
            host = bare_host(config.site_host)
            self._servers.append(await loop.create_server(partial(_Local, self, port), host, config.base_port + port))

    def figures(self) -> dict[str, object]:
        """Return the number of connections that are ready, and the problem."""
        return {"side": self.config.side, "room": self.config.room, "ready": self._waiting, "missing": self.problem}


def run_tunnel(config: TunnelConfig, stop: Callable[[], bool]) -> None:
    """Run one end of a tunnel until `stop()`.

    Raises:
        KeyProblem: the file of the room's secret cannot be used.
        OSError: at the operator's end, a port of the link is taken.
    """
    asyncio.run(_run(TunnelEnd(config, read_secret(config.secret)), stop))


async def _run(end: TunnelEnd, stop: Callable[[], bool]) -> None:
    config = end.config
    try:
        if config.side == "remote":
            end.begin(end.keep_ready())
        else:
            await end.listen()
        log.info("room %s over %s:%d, %s side", config.room, config.host, config.port, config.side)
        await until_stopped(stop, StatusFile(config.status, "tunnel"), end.figures)
    finally:
        await end.close()
