"""The messages of a short session as a feed brings them, and as an export has them."""

from pathlib import Path

import pytest

from operator_site.session.console_feed import Fed
from teletaction.export.named_recording import NamedMessage, NamedRecording
from teletaction.outlets.live_messages import FED_TOPICS
from teletaction.recordings.recorded_session import RecordedSession


@pytest.fixture(scope="package")
def fed(session: Path) -> list[Fed]:
    """The messages that the operator site feeds."""
    with session.open("rb") as file:
        recorded = RecordedSession(session, file).messages(FED_TOPICS)
        return [Fed(topic, time_ns, payload) for topic, _, time_ns, payload in recorded]


@pytest.fixture(scope="package")
def exported(session: Path) -> list[NamedMessage]:
    """The same messages as an export names them."""
    with session.open("rb") as file:
        recording = NamedRecording(session, file)
        return list(recording.messages([topic for topic in recording.topics if topic in FED_TOPICS]))
