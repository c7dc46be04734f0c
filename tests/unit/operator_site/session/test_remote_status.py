"""The state of the remote site's recording: requested once a second, bounded, and known until the next report."""

from typing import Any

import pytest

from common.faults.fault import Fault, FaultCode
from common.wire.packets import LinkState
from common.wire.session_messages import LONGEST_REFUSAL
from tests.unit.operator_site.session_pair import Pair

DEAD = Fault(FaultCode.FORCE_SENSOR_DEAD, "index", "telemanipulator", 1.2, 0.8)
STOPPED = "the process that writes it has ended"


def test_the_remote_status_is_requested_once_a_second(pair: Pair) -> None:
    assert 9 <= pair.asked("status", 10_000) <= 11


def test_a_stopped_remote_recording_is_known_until_it_works_again(pair: Pair, caplog: pytest.LogCaptureFixture) -> None:
    for recording in (STOPPED, STOPPED, ""):
        pair.run(1_000)
        pair.answer("status", state="engaged", fault=None, missing="", recording=recording)
        assert pair.client.remote_recording == recording
    assert caplog.text.count(STOPPED) == 1
    pair.run(1_000)
    pair.answer("status", state="connected", fault=None, missing="")
    assert pair.client.remote_recording == "", "an older remote site says nothing of it"


def test_motion_that_does_not_arrive_is_known_while_engaged_and_explains_the_pause(pair: Pair) -> None:
    pair.client.want_engaged, pair.remote.state = True, LinkState.ENGAGED
    pair.run(400)
    pair.answer("engage", max_age_s=0.15)
    assert pair.client.remote_stale == ""
    pair.run(1_000)
    pair.answer("status", stale="no motion for 1.20 s")
    assert pair.client.remote_stale == "no motion for 1.20 s"
    assert pair.asked("status", 1_000) == 5, "its end should be known soon"
    pair.remote.state = LinkState.CONNECTED
    pair.run(400)
    assert pair.client.session.paused == "the remote site is no longer engaged: no motion for 1.20 s"
    assert pair.client.remote_stale == "", "what is not engaged waits for no motion"
    assert pair.asked("status", 1_000) == 1
    pair.client.engage()
    pair.remote.state = LinkState.ENGAGED
    pair.run(400)
    pair.answer("engage", max_age_s=0.15)
    assert pair.client.session.engaged
    assert pair.client.remote_stale == "", "that was before"
    pair.run(1_000)
    pair.answer("status", stale="no motion for 1.20 s")
    pair.run(1_000)
    pair.answer("status", state="engaged")
    assert pair.client.remote_stale == "", "an older remote site says nothing of it"


def test_the_remote_status_ends_with_the_session(pair: Pair) -> None:
    pair.run(1_000)
    pair.answer("status", recording=STOPPED, stale="no motion for 1.20 s")
    pair.remote.alive = False
    pair.run(2_000)
    assert pair.client.session.state is LinkState.DISCONNECTED
    assert pair.client.remote_recording == pair.client.remote_stale == ""


@pytest.mark.parametrize("recording", ["x" * 3000, "no\nspace\x1b[31m\x00left", "\n" * 10])
def test_a_remote_text_is_one_short_line(pair: Pair, recording: str) -> None:
    pair.run(1_000)
    pair.answer("status", recording=recording)
    assert len(pair.client.remote_recording) <= LONGEST_REFUSAL
    assert pair.client.remote_recording.isprintable()
    assert pair.client.remote_recording.strip(), "that it has stopped is known, whatever it says"


@pytest.mark.parametrize("recording", [7, True, ["x"], {"a": 1}, None, 1.5])
def test_a_wrong_text_counts_as_damaged_and_changes_nothing(pair: Pair, recording: Any) -> None:
    pair.run(1_000)
    pair.answer("status", recording=STOPPED)
    pair.run(1_000)
    damaged = pair.client.damaged["control"]
    pair.answer("status", recording=recording)
    assert pair.client.remote_recording == STOPPED
    assert pair.client.damaged["control"] == damaged + 1


def test_a_fault_is_requested_at_once_and_ends_with_a_touch_packet(pair: Pair) -> None:
    pair.run(1_000)
    pair.remote.state = LinkState.FAULT
    assert pair.asked("status", 500) >= 2
    pair.answer("status", fault=DEAD, recording=STOPPED)
    assert (pair.client.remote_fault, pair.client.remote_recording) == (DEAD, STOPPED)
    pair.remote.state = LinkState.CONNECTED
    pair.run(1_000)
    pair.remote.answer("status", fault=DEAD, recording="")
    pair.run(20)
    assert (pair.client.remote_fault, pair.client.remote_recording) == (None, "")
