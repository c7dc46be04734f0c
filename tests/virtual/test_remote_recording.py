"""A recording that stopped at the remote site: the operator's site knows it, its figures say so, its console alarms."""

from typing import cast

import msgpack
import pytest

from common.recording.recorder import Recorder
from operator_site.console.model import Console
from operator_site.console.texts import REMOTE_NOT_RECORDED
from tests.virtual.conftest import MakeSession
from tests.virtual.kept_record import KeptRecord
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

KNOWN_WITHIN_S = 1.5
"""It is asked once a second, and an answer takes a moment."""


def alarms(session: VirtualSession) -> list[str]:
    """What a console shows by the operator site's figures."""
    console, now_ns = Console(), session.operator_host.now_ns()
    console.take("operator/figures", now_ns, msgpack.packb(session.operator.figures()))
    console.step(now_ns * 1e-9)
    return [alarm.text for alarm in console.alarms.listed]


def test_a_stopped_remote_recording_alarms_at_the_operators_console(make_session: MakeSession) -> None:
    kept = KeptRecord()
    session = make_session(recorders={"remote": cast(Recorder, kept)})
    session.until(lambda session: session.both_engaged, 20.0)
    session.run(KNOWN_WITHIN_S)
    assert session.operator.figures()["remote_recording"] == ""
    assert REMOTE_NOT_RECORDED not in alarms(session)
    kept.failed = "the process that writes it has ended"
    session.run(KNOWN_WITHIN_S)
    assert session.both_engaged, "a recording stops nothing"
    assert session.operator.figures()["remote_recording"] == kept.failed
    assert REMOTE_NOT_RECORDED in alarms(session)
