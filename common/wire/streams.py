"""The one table of streams between the sites: sockets, watchdogs and recording derive from it."""

from dataclasses import dataclass
from enum import Enum

from common.limits import GAP_S


class Direction(Enum):
    """Who sends a stream."""

    TO_REMOTE = "operator to remote"
    TO_OPERATOR = "remote to operator"
    TO_OBSERVERS = "remote to observers"
    BOTH = "request and answer"


@dataclass(frozen=True, slots=True)
class Stream:
    """One stream of the link.

    Attributes:
        name: its name in configuration, recordings and counters.
        direction: who sends it.
        rate_hz: how often it is sent at most while a session runs (common/link/deadband.py spares some); 0 for events.
        latest_only: an unread packet is replaced by a newer one instead of queueing behind it.
        port: its TCP port, counted from the link's first port.
        recorded: whether its sender records every packet of it.
    """

    name: str
    direction: Direction
    rate_hz: float
    latest_only: bool
    port: int
    recorded: bool

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
        # The same packets as touch, on a socket of its own: cutting off an observer does not disturb the operator.
        Stream("observed", Direction.TO_OBSERVERS, 500.0, latest_only=True, port=4, recorded=False),
    )
}
