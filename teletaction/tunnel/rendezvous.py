"""The rendezvous: both sites connect to it, and it joins their connections in pairs.

It reads one request of each connection. Then it carries bytes that only the sites can read: the link is encrypted and
authenticated from site to site, so the rendezvous can neither read nor change nor add a packet.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Mapping

from common.config.link_models import RendezvousConfig
from common.files.printable import printable
from common.link.host_name import bare_host
from common.runtime.status_file import StatusFile
from common.timing.interval import Interval
from teletaction.tunnel.connection import Connection, close_all
from teletaction.tunnel.greeting import (
    REACHED,
    READY,
    Request,
    is_proved,
    new_hello,
    read_request,
    refused,
    stream_line,
)
from teletaction.tunnel.room_secret import read_secret
from teletaction.tunnel.until_stopped import until_stopped

log = logging.getLogger(__name__)

GREETING_S = 5.0
"""Time in which a new connection has to send its request, s."""
PATIENCE_S = 2.0
"""Time for which the operator's end waits for the remote site's, s."""
MOST_STRANGERS = 64
"""Maximum number of connections without a request; a further one takes the place of the oldest."""
MOST_REACHING = 16
"""Maximum number of a room's waiting connections of the operator's side."""
SECOND_END = "another remote end serves this room; one that has lost its network is forgotten within 10 s"
"""Reason to refuse a waiting connection of the remote side beyond READY: streams would reach either end's site."""
MOST_JOINED = 64
"""Maximum number of a room's pairs."""
QUIET_S = 10.0
"""Minimum time between two logged refusals, s; strangers must not fill the disk."""


class _Room:
    def __init__(self, secret: bytes) -> None:
        self.secret = secret
        self.serving: deque[_Visitor] = deque()
        self.reaching: deque[_Visitor] = deque()
        self.joined = 0

    def end_pair(self) -> None:
        self.joined -= 1


class _Visitor(Connection):
    """A connection of either site."""

    def __init__(self, rendezvous: "Rendezvous") -> None:
        super().__init__(rendezvous.connections)
        self._rendezvous = rendezvous
        self.number = ""
        self.request: Request | None = None
        self.timer: asyncio.TimerHandle | None = None
        self.leave: Callable[[], None] = lambda: None

    def opened(self) -> None:
        hello, self.number = new_hello()
        self.say(hello)
        self._rendezvous.greet(self)

    def take_line(self, line: str) -> None:
        if self.request is not None:
            self.transport.abort()  # nothing is to be sent before the answer
            return
        try:
            self.request = read_request(line)
        except ValueError:
            self.refuse("no request of this version")
        else:
            self._rendezvous.take(self, self.request)

    @property
    def host(self) -> str:
        """Address from which it comes."""
        return str((self.transport.get_extra_info("peername") or ("an unknown address",))[0])

    def refuse(self, reason: str) -> None:
        """Send the reason and close."""
        self.say(refused(reason))
        self.transport.close()

    def after(self, seconds: float, then: Callable[[], None]) -> None:
        """Do something after a time, s, in place of what was to be done before."""
        self.rest()
        self.timer = asyncio.get_running_loop().call_later(seconds, then)

    def rest(self) -> None:
        """Do nothing later."""
        if self.timer is not None:
            self.timer.cancel()

    def closed(self) -> None:
        self.rest()
        self.leave()


class Rendezvous:
    """Joins connections of the same room. Needs a running event loop."""

    def __init__(self, secrets: Mapping[str, bytes]) -> None:
        """Open rooms, by name with their secrets."""
        self._rooms = {name: _Room(secret) for name, secret in secrets.items()}
        self.connections: set[Connection] = set()
        self._strangers: dict[_Visitor, None] = {}
        self._may_log = Interval(QUIET_S)
        self.refused = 0
        """Number of requests without a valid proof."""

    def visitor(self) -> Connection:
        """Return the protocol of a new connection."""
        return _Visitor(self)

    def greet(self, visitor: _Visitor) -> None:
        """Wait for the request of a new connection."""
        self._strangers[visitor] = None
        visitor.leave = lambda: self._strangers.pop(visitor, None)
        visitor.after(GREETING_S, visitor.transport.abort)
        if len(self._strangers) > MOST_STRANGERS:
            oldest = next(iter(self._strangers))
            del self._strangers[oldest]  # it closes only in a later turn of the loop
            oldest.transport.abort()

    def take(self, visitor: _Visitor, request: Request) -> None:
        """Join a connection to one that waits for it, or let it wait."""
        self._strangers.pop(visitor, None)
        visitor.rest()
        visitor.leave = lambda: None
        room = self._rooms.get(request.room)
        if room is None or not is_proved(request, room.secret, visitor.number):
            self.refused += 1
            self._log("refused a request for room %s", request.room)
            visitor.refuse("room and secret do not match")
            return
        serves = request.port is None
        mine, others = (room.serving, room.reaching) if serves else (room.reaching, room.serving)
        if others:
            other = others.popleft()
            self._join(room, *((visitor, other) if serves else (other, visitor)))
        elif serves and len(mine) >= READY:
            self._log("room %s: refused a second remote end, at %s", request.room, visitor.host)
            visitor.refuse(SECOND_END)
        elif len(mine) >= MOST_REACHING:
            visitor.refuse("too many connections of this room are waiting")
        else:
            mine.append(visitor)
            visitor.leave = lambda: mine.remove(visitor)
            if not serves:
                visitor.transport.pause_reading()
                visitor.after(PATIENCE_S, lambda: visitor.refuse("the remote site is not there"))

    def _log(self, text: str, *values: str) -> None:
        """Log a refusal within the rate limit."""
        if self._may_log(asyncio.get_running_loop().time()):
            log.warning(text, *map(printable, values))

    def _join(self, room: _Room, serving: _Visitor, reaching: _Visitor) -> None:
        assert reaching.request is not None
        assert reaching.request.port is not None
        for visitor in (serving, reaching):
            visitor.rest()
            visitor.leave = lambda: None
        if room.joined >= MOST_JOINED:
            for visitor in (serving, reaching):
                visitor.refuse("too many connections of this room are open")
            return
        room.joined += 1
        reaching.leave = room.end_pair
        serving.say(stream_line(reaching.request.port))
        reaching.say(REACHED)
        Connection.join(serving, reaching)

    def figures(self) -> dict[str, object]:
        """Return the numbers of connections of each room."""
        rooms = {
            name: {"waiting": len(room.serving), "joined": room.joined} for name, room in sorted(self._rooms.items())
        }
        return {"rooms": rooms, "refused": self.refused}


def run_rendezvous(config: RendezvousConfig, stop: Callable[[], bool]) -> None:
    """Run a rendezvous until `stop()`.

    Raises:
        KeyProblem: the file of a room's secret cannot be used.
        OSError: the address is taken, or is not this machine's.
    """
    secrets = {name: read_secret(path) for name, path in config.rooms.items()}
    asyncio.run(_serve(config, secrets, stop))


async def _serve(config: RendezvousConfig, secrets: Mapping[str, bytes], stop: Callable[[], bool]) -> None:
    rendezvous = Rendezvous(secrets)
    loop = asyncio.get_running_loop()
    server = await loop.create_server(rendezvous.visitor, bare_host(config.bind), config.port)
    log.info("%s:%d, rooms: %s", config.bind, config.port, ", ".join(sorted(secrets)))
    try:
        await until_stopped(stop, StatusFile(config.status, "rendezvous"), rendezvous.figures)
    finally:
        server.close()
        await close_all(rendezvous.connections)
