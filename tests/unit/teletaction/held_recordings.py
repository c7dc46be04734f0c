"""Recordings as the tests of this room read them."""

from pathlib import Path

from mcap.reader import make_reader

Message = tuple[str, int, bytes]
"""Stream, time in ns, payload."""


def held(path: Path) -> list[Message]:
    """All messages of a recording in the file's order; every checksum is looked at."""
    with path.open("rb") as file:
        read = make_reader(file, validate_crcs=True).iter_messages(log_time_order=False)
        return [(channel.topic, message.log_time, message.data) for _, channel, message in read]
