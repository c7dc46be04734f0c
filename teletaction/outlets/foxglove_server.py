"""Serves live messages to Foxglove over a WebSocket, with the topics and schemas of the export."""

import json
from collections.abc import Sequence

import foxglove

from teletaction.export.foxglove import LOG_NAME, encoded, schema_name
from teletaction.export.log_entries import LOG_SCHEMA, log_entry
from teletaction.export.named_fields import Named, Schema
from teletaction.export.named_recording import NamedMessage
from teletaction.export.topics import TOPICS
from teletaction.outlets.live_messages import FED_TOPICS
from teletaction.outlets.place import Place

BACKLOG = 1024
"""Maximum number of messages that wait for one client; for a slower one the oldest are dropped."""


class FoxgloveServer:
    """A server that clients can only read.

    Attributes:
        address: URL for `Open connection` in Foxglove.
    """

    def __init__(self, place: Place):
        """Listen; raises RuntimeError where the port is in use."""
        self._context = foxglove.Context()
        self._channels = {topic: self._channel(topic, schema_name(topic), TOPICS[topic].schema) for topic in FED_TOPICS}
        self._log = self._channel("log", LOG_NAME, LOG_SCHEMA)
        self._server = foxglove.start_server(
            name=f"teletaction {place.site}",
            host=place.host,
            port=place.port,
            context=self._context,
            message_backlog_size=BACKLOG,
        )
        self.address = f"ws://{place.url_host}:{self._server.port}"

    def offer(self, messages: Sequence[NamedMessage]) -> None:
        """Queue messages for the clients that subscribe to their topics."""
        for message in messages:
            _send(self._channels[message.topic], message, message.fields)
            if (entry := log_entry(message)) is not None:
                _send(self._log, message, entry)

    def close(self) -> None:
        """Disconnect all clients and release the port."""
        self._server.stop()

    def _channel(self, topic: str, name: str, schema: Schema) -> foxglove.Channel:
        described = foxglove.Schema(name=name, encoding="jsonschema", data=json.dumps(schema).encode())
        return foxglove.Channel(f"/{topic}", schema=described, message_encoding="json", context=self._context)


def _send(channel: foxglove.Channel, message: NamedMessage, fields: Named) -> None:
    if channel.has_sinks():  # without a reader, JSON costs no time
        channel.log(encoded(fields), log_time=message.wall_ns)
