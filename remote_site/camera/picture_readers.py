"""Keeps count of what each reader has received, so that no picture waits behind others on a slow way."""

import math
from collections import deque
from dataclasses import dataclass, field

from common.wire.camera_messages import CameraAsk
from remote_site.stream_server import LEFT_S, make_place

MOST_IN_FLIGHT_S = 0.25
"""Largest excess of the oldest unacknowledged picture's time over the shortest way so far, s."""
KEY_EVERY_S = 1.0
"""Least time between two key pictures that readers ask for, s."""
_WAYS = 50
"""Number of acknowledgements over which the shortest way is known."""


@dataclass(slots=True)
class Reader:
    """One reader of the pictures.

    Attributes:
        who: routing identity.
        operates: whether the key of its newest packet may operate the session.
        heard_s: time of its newest packet, s.
        asked_ns, heard_ns: its newest packet's time on its own clock, and on the camera's when it was read, ns.
        needs_key: whether it can only use a picture that can be decoded by itself.
    """

    who: bytes
    operates: bool = False
    heard_s: float = 0.0
    asked_ns: int = 0
    heard_ns: int = 0
    needs_key: bool = True
    _in_flight: deque[tuple[int, float]] = field(default_factory=deque)
    _ways_s: deque[float] = field(default_factory=lambda: deque(maxlen=_WAYS))

    def take(self, ask: CameraAsk, now_ns: int) -> None:
        """Take a packet of the reader."""
        self.heard_s, self.asked_ns, self.heard_ns = now_ns * 1e-9, ask.time_ns, now_ns
        self.needs_key |= ask.wants_key
        while self._in_flight and self._in_flight[0][0] <= ask.sequence:
            sequence, sent_s = self._in_flight.popleft()
            if sequence == ask.sequence:
                self._ways_s.append(self.heard_s - sent_s)

    def has_credit(self, now_s: float) -> bool:
        """Return whether the oldest picture on its way is not later than usual by MOST_IN_FLIGHT_S."""
        if not self._in_flight:
            return True
        usual_s = min(self._ways_s, default=0.0)
        return now_s - self._in_flight[0][1] < usual_s + MOST_IN_FLIGHT_S

    def sent(self, sequence: int, now_s: float, is_key: bool) -> None:
        """Note a picture that was sent to the reader."""
        self._in_flight.append((sequence, now_s))
        if is_key:
            self.needs_key = False


class PictureReaders:
    """All readers of one camera. Pure: times are arguments."""

    def __init__(self) -> None:
        self._readers: dict[bytes, Reader] = {}
        self._key_s = -math.inf

    @property
    def present(self) -> list[Reader]:
        """The readers."""
        return list(self._readers.values())

    def take(self, who: bytes, operates: bool, ask: CameraAsk, now_ns: int) -> Reader | None:
        """Take a packet of a reader; return the reader, None where there are too many."""
        reader = self._readers.get(who)
        if reader is None:
            if not make_place(self._readers, operates=operates):
                return None
            reader = self._readers[who] = Reader(who)
        reader.operates = operates
        reader.take(ask, now_ns)
        return reader

    def drop_absent(self, now_s: float) -> None:
        """Forget readers that have left."""
        self._readers = {who: reader for who, reader in self._readers.items() if now_s - reader.heard_s < LEFT_S}

    def ready(self, now_s: float) -> list[Reader]:
        """Return the readers to which a picture may be sent now."""
        return [reader for reader in self._readers.values() if reader.has_credit(now_s)]

    def key_is_due(self, now_s: float, ready: list[Reader]) -> bool:
        """Return whether the next picture has to be a key picture; at most one in KEY_EVERY_S."""
        if now_s - self._key_s < KEY_EVERY_S or not any(reader.needs_key for reader in ready):
            return False
        self._key_s = now_s
        return True

    def sent(self, sequence: int, now_s: float, is_key: bool, ready: list[Reader]) -> list[Reader]:
        """Return the readers that get this picture; the others need a key picture next."""
        get = [reader for reader in ready if is_key or not reader.needs_key]
        for reader in self._readers.values():
            if reader in get:
                reader.sent(sequence, now_s, is_key)
            else:
                reader.needs_key = True
        return get
