"""A remote site that sends impossible packets: the operator's site keeps working and records what it played."""

from collections.abc import Callable
from typing import Any

import pytest

from common.recording.recorder import Recorder
from common.wire.messages import Event, EventKind, Touch
from operator_site.site_recording import SiteRecording
from tests.virtual.kept_record import KeptRecord
from tests.virtual.session import TICK_S, VirtualSession

pytestmark = pytest.mark.long

_INDEX = 1
_GROOVE_RAD_S = 300.0


def lie(session: VirtualSession, change: Callable[[Touch], Touch]) -> None:
    """From now on the remote site sends each touch as `change` returns it."""
    perception: Any = session.remote.perception
    packet = perception.packet

    def changed(*given: Any) -> Touch:
        return change(packet(*given))

    perception.packet = changed


def record(session: VirtualSession) -> KeptRecord:
    """Record the operator's site in memory from now on."""
    kept: Any = KeptRecord()
    recorder: Recorder = kept
    session.operator._recording = SiteRecording(recorder)
    return kept  # type: ignore[no-any-return]


def test_a_groove_of_a_single_packet_is_played_and_recorded_at_its_time(
    working: VirtualSession,
) -> None:
    late_s = [0.030, 0.004]
    operator_ns = working.operator_clock.now_ns
    named = list[Event]()

    def name_once(touch: Touch) -> Touch:
        events: tuple[Event, ...] = ()
        if late_s:
            hand_ns = operator_ns(working.time_s - late_s.pop(0))
            named.append(Event(10_000 + len(named), EventKind.GROOVE, _INDEX, touch.time_ns, hand_ns, _GROOVE_RAD_S))
            events = (named[-1],)
        return touch._replace(events=events)

    kept = record(working)
    lie(working, name_once)
    working.run(3 * TICK_S)
    assert [played[0] for played in kept.streams["operator/played"]] == [10_000], "the second waits"
    working.run(0.1)
    assert kept.streams["operator/played"] == [[event.ident, EventKind.GROOVE, _INDEX] for event in named]
    assert working.both_engaged
