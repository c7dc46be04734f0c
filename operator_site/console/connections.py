"""Bounds the open connections of the console's server, and chooses the one that is dropped for a new one."""

import resource
from dataclasses import dataclass
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


@dataclass(slots=True)
class _Place:
    stage: Stage
    since_s: float


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
        self._places: dict[Connection, _Place] = {}

    def __len__(self) -> int:
        """Connections that hold a file descriptor."""
        self._forget()
        return len(self._places)

    def arrived(self, connection: Connection, now_s: float) -> Connection | None:
        """Give a new connection a place; returns which one to drop for it, itself where all others are pages."""
        dropped = None
        if len(self) >= self.most:
            self.dropped += 1
            dropped = min(self._places, key=self._rank)
            if self._places[dropped].stage is Stage.PAGE:
                return connection
            del self._places[dropped]
        self._places[connection] = _Place(Stage.ARRIVING, now_s)
        return dropped

    def reached(self, connection: Connection, stage: Stage, now_s: float) -> None:
        """Note that a connection is in another stage now; one that was dropped stays out."""
        if (place := self._places.get(connection)) is not None:
            place.stage, place.since_s = stage, now_s

    def overdue(self, now_s: float) -> list[Connection]:
        """Take out and return the connections that have waited longer than IDLE_S for their client."""
        self._forget()
        found = [
            connection
            for connection, place in self._places.items()
            if place.stage <= Stage.IDLE and now_s - place.since_s > IDLE_S
        ]
        for connection in found:
            del self._places[connection]
        self.dropped += len(found)
        return found

    def _rank(self, connection: Connection) -> tuple[Stage, float]:
        place = self._places[connection]
        return place.stage, place.since_s

    def _forget(self) -> None:
        self._places = {connection: place for connection, place in self._places.items() if connection.is_open}


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
