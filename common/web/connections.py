"""Limits the open connections of a page's server, and chooses the connection to drop for a new one."""

import resource
from enum import IntEnum
from typing import Protocol

MOST_CONNECTIONS = 256
"""Maximum number of connections at a time, with enough file descriptors."""
SHARE = 4
"""File descriptors of the process for each allowed connection; an answer opens a file, too."""
IDLE_S = 5.0
"""Longest time from connecting to a whole request head, TLS included, and from an answer to the next request, s."""
MOST_UNSENT = 4 << 20
"""Maximum number of bytes that wait for one client, several times the largest message: websockets answer every ping,
and a client that sends pings and reads nothing would fill the memory."""


class Stage(IntEnum):
    """State of a connection; the lowest state is dropped first for a new connection."""

    ARRIVING = 0
    """The connection has not sent a complete request head."""
    IDLE = 1
    """Its request was answered, or its page was disconnected."""
    BUSY = 2
    """Its request is being answered."""
    PAGE = 3
    """An admitted page; never dropped for a new connection."""


class Connection(Protocol):
    """An accepted connection."""

    @property
    def is_open(self) -> bool:
        """Whether the connection still holds a file descriptor."""

    @property
    def unsent_bytes(self) -> int:
        """Number of bytes that wait until the client reads."""

    def drop(self) -> None:
        """Close the connection at once."""


class Connections:
    """Open connections by stage. Pure: time is an argument, s of any monotonic clock.

    Attributes:
        most: maximum number of connections at a time.
        dropped: number of connections dropped or refused so far.
    """

    def __init__(self, most: int):
        """Allow `most` connections, 1 or more."""
        self.most = most
        self.dropped = 0
        self._since_s: dict[Stage, dict[Connection, float]] = {stage: {} for stage in Stage}
        """Connections of each stage with the time at which each reached it, oldest first."""

    def __len__(self) -> int:
        """Return the number of connections that hold a file descriptor."""
        self._forget()
        return sum(map(len, self._since_s.values()))

    def arrived(self, connection: Connection, now_s: float) -> Connection | None:
        """Add a new connection; return the one to drop for it, which is the new one if all others are pages."""
        dropped = None
        if len(self) >= self.most:
            self.dropped += 1
            stage = next(stage for stage, places in self._since_s.items() if places)
            if stage is Stage.PAGE:
                return connection
            dropped = next(iter(self._since_s[stage]))
            del self._since_s[stage][dropped]
        self._since_s[Stage.ARRIVING][connection] = now_s
        return dropped

    def stage(self, connection: Connection) -> Stage | None:
        """Return the stage of a connection; None if it was dropped or never added."""
        return next((stage for stage, places in self._since_s.items() if connection in places), None)

    def reached(self, connection: Connection, stage: Stage, now_s: float) -> None:
        """Move a connection to another stage; a dropped one stays dropped."""
        before = self.stage(connection)
        if before is not None and before is not stage:
            del self._since_s[before][connection]
            self._since_s[stage][connection] = now_s

    def overdue(self, now_s: float) -> list[Connection]:
        """Remove and return the connections that have waited longer than IDLE_S, or with MOST_UNSENT bytes."""
        self._forget()
        found = []
        for stage, places in self._since_s.items():
            waits = stage in (Stage.ARRIVING, Stage.IDLE)
            late = [
                connection
                for connection, since_s in places.items()
                if (waits and now_s - since_s > IDLE_S) or connection.unsent_bytes > MOST_UNSENT
            ]
            for connection in late:
                del places[connection]
            found += late
        self.dropped += len(found)
        return found

    def _forget(self) -> None:
        for places in self._since_s.values():
            for connection in [connection for connection in places if not connection.is_open]:
                del places[connection]


def most_connections(descriptors: int) -> int:
    """Return the maximum number of connections for a process with this limit of open files."""
    return max(1, min(MOST_CONNECTIONS, descriptors // SHARE))


def raise_descriptor_limit() -> int:
    """Raise this process's limit of open files to SHARE * MOST_CONNECTIONS if allowed; return the usable limit."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = SHARE * MOST_CONNECTIONS
    if soft != resource.RLIM_INFINITY and soft < wanted:
        soft = wanted if hard == resource.RLIM_INFINITY else min(hard, wanted)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return wanted if soft == resource.RLIM_INFINITY else soft
