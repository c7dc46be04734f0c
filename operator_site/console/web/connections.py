"""Bounds the open connections of the console's server, and chooses the one that is dropped for a new one."""

import resource
from enum import IntEnum
from typing import Generic, Protocol, TypeVar

MOST_CONNECTIONS = 256
"""Connections that may be open at a time, whatever the process may open."""
SHARE = 4
"""One in so many of the process's file descriptors may be a connection: an answer opens a file, too."""
IDLE_S = 5.0
"""Longest time from connecting to a whole request head, TLS included, and from an answer to the next request, s."""


class Stage(IntEnum):
    """State of a connection; the lower it is, the sooner the connection is dropped for a new one."""

    ARRIVING = 0
    """It has not sent a whole request head."""
    IDLE = 1
    """Its request was answered, or its page was sent away."""
    BUSY = 2
    """Its request is being answered."""
    PAGE = 3
    """A page that was let in; never dropped here."""


class Open(Protocol):
    """A connection, as far as its place matters."""

    @property
    def is_open(self) -> bool:
        """Whether it still holds a file descriptor."""


Connection = TypeVar("Connection", bound=Open)


class Connections(Generic[Connection]):
    """Pure: time is an argument, s of any clock that never goes back.

    Attributes:
        most: connections that may be open at a time.
        dropped: connections that were dropped or refused, so far.
    """

    def __init__(self, most: int):
        """Allow `most` connections, 1 or more."""
        self.most = most
        self.dropped = 0
        self._since_s: dict[Stage, dict[Connection, float]] = {stage: {} for stage in Stage}
        """Connections of each stage and when each reached it, the oldest first."""

    def __len__(self) -> int:
        """Connections that hold a file descriptor."""
        self._forget()
        return sum(map(len, self._since_s.values()))

    def arrived(self, connection: Connection, now_s: float) -> Connection | None:
        """Give a new connection a place; returns which one to drop for it, itself where all others are pages."""
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
        """The stage of a connection; None where it has no place."""
        return next((stage for stage, places in self._since_s.items() if connection in places), None)

    def reached(self, connection: Connection, stage: Stage, now_s: float) -> None:
        """Note that a connection is in another stage now; one that was dropped stays out."""
        before = self.stage(connection)
        if before is not None and before is not stage:
            del self._since_s[before][connection]
            self._since_s[stage][connection] = now_s

    def overdue(self, now_s: float) -> list[Connection]:
        """Take out and return the connections that have waited longer than IDLE_S for their client."""
        self._forget()
        found = []
        for stage in (Stage.ARRIVING, Stage.IDLE):
            late = [connection for connection, since_s in self._since_s[stage].items() if now_s - since_s > IDLE_S]
            for connection in late:
                del self._since_s[stage][connection]
            found += late
        self.dropped += len(found)
        return found

    def _forget(self) -> None:
        for places in self._since_s.values():
            for connection in [connection for connection in places if not connection.is_open]:
                del places[connection]


def most_connections(descriptors: int) -> int:
    """Connections that a process may have open that may open so many files."""
    return max(1, min(MOST_CONNECTIONS, descriptors // SHARE))


def raise_descriptor_limit() -> int:
    """Raise this process's limit of open files as far as it is allowed; returns the limit."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = SHARE * MOST_CONNECTIONS
    if soft != resource.RLIM_INFINITY and soft < wanted:
        soft = wanted if hard == resource.RLIM_INFINITY else min(hard, wanted)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    return wanted if soft == resource.RLIM_INFINITY else soft
