"""A recorder that keeps its rows in memory instead of a file."""

from collections import Counter, defaultdict
from typing import Any

import msgpack


class KeptRecord:
    """What a site recorded, with what the site uses of `common.recording.recorder.Recorder`.

    Attributes:
        streams: unpacked payloads of each stream, oldest first.
    """

    failed: str | None = None
    failed_ns: int | None = None
    disk_full = False
    lost = 0

    def __init__(self) -> None:
        self.streams: dict[str, list[Any]] = defaultdict(list)

    @property
    def written(self) -> Counter[str]:
        """Messages of each stream."""
        return Counter({stream: len(payloads) for stream, payloads in self.streams.items()})

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Keep one message; one that is not MessagePack raises."""
        self.streams[stream].append(msgpack.unpackb(payload))
