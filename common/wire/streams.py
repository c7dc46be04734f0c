"""Table of the streams between the sites, from which sockets, watchdogs and recording derive."""

from dataclasses import dataclass
from enum import Enum

from common.limits import GAP_S


class Direction(Enum):
    """Sender and receiver of a stream."""

    TO_REMOTE = "operator to remote"
    TO_OPERATOR = "remote to operator"
    TO_OBSERVERS = "remote to observers"
    BOTH = "request and answer"


@dataclass(frozen=True, slots=True)
class Stream:
    """One stream of the link.

    Attributes:
        name: name in configuration, recordings and counters.
        direction: sender and receiver.
        rate_hz: maximum rate while a session runs, Hz (common/link/deadband.py omits some packets); 0 for events.
        latest_only: whether a newer packet replaces an unread one instead of queueing behind it.
        port: TCP port, counted from the link's first port.
        recorded: whether the sender records every packet.
        process: process of the remote site that serves it.
    """

    name: str
    direction: Direction
    rate_hz: float
    latest_only: bool
    port: int
    recorded: bool
    process: str = "site"

    def __post_init__(self) -> None:
        if self.latest_only and not 3.0 / self.rate_hz <= GAP_S:
            raise ValueError(f"{self.name}: a gap of {GAP_S} s must cover three periods")


STREAMS = {
    stream.name: stream
    for stream in (
        Stream("motion", Direction.TO_REMOTE, 500.0, latest_only=True, port=0, recorded=True),
        Stream("touch", Direction.TO_OPERATOR, 500.0, latest_only=True, port=1, recorded=True),
        Stream("heartbeat", Direction.BOTH, 20.0, latest_only=False, port=2, recorded=False),
        Stream("control", Direction.BOTH, 0.0, latest_only=False, port=3, recorded=False),
        # The same packets as touch, on a separate socket: disconnecting an observer does not disturb the operator.
        Stream("observed", Direction.TO_OBSERVERS, 500.0, latest_only=True, port=4, recorded=False),
        Stream("camera", Direction.BOTH, 0.0, latest_only=False, port=5, recorded=False, process="camera"),
        Stream("voice", Direction.BOTH, 0.0, latest_only=False, port=6, recorded=False, process="voice"),
    )
}
SITE_STREAMS = {name: stream for name, stream in STREAMS.items() if stream.process == "site"}
"""Streams that the sites' own processes serve and read."""
