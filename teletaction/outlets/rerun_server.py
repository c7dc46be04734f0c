"""Serves live messages to Rerun viewers, with the entity paths of the export."""

from collections.abc import Sequence

import rerun as rr

from teletaction.export.named_recording import NamedMessage
from teletaction.export.rerun_file import Curves
from teletaction.outlets.live_messages import FED_TOPICS
from teletaction.outlets.place import Place

GROUP_S = 0.5
"""Time of the messages that are sent at once, s: one message alone costs as much as a group of each curve."""
HISTORY = "256MiB"
"""Memory for what a viewer that connects later receives; the oldest is dropped first."""


class RerunServer:
    """A server of one recording, which starts with it.

    Attributes:
        address: URL that a viewer opens.
    """

    def __init__(self, place: Place):
        """Listen."""
        server = rr.GrpcServerSink(place.host, place.port, server_memory_limit=HISTORY)
        self.address = f"rerun+http://{place.url_host}:{place.port}/proxy"
        self._stream = rr.RecordingStream("teletaction")
        self._stream.set_sinks(server)
        self._stream.send_recording_name(f"live session of {place.site}")
        self._curves = Curves(self._stream, FED_TOPICS)
        rr.TextLog("")  # The first text loads parts of the library, which takes a second: better before the feed.
        self._sent_ns = 0

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        """Add messages, and send them when a group is complete."""
        for message in messages:
            self._curves.add(message)
        newest_ns = messages[-1].monotonic_ns
        if not 0 <= newest_ns - self._sent_ns < GROUP_S * 1e9:
            self._sent_ns = newest_ns
            self._curves.write()

    def close(self) -> None:
        """Send the rest, disconnect all viewers and release the port."""
        self._curves.write()
        self._stream.disconnect()
