"""Live messages are those of an export, at times of this machine's clocks."""

from collections import Counter

import pytest

from common.recording.clock_anchor import ClockAnchor
from operator_site.session.console_feed import STREAMS, Fed
from teletaction.export.named_recording import NamedMessage
from teletaction.outlets.live_messages import FED_TOPICS, LiveMessages
from tests.unit.operator_site.console.fed import S, figures, rendered

WALL_NS = 1_800_000_000 * S
LATE_NS = S // 30
HOUR_NS = 3600 * S


class Clocks:
    """This machine's clocks: a test sets the wall clock, and counts the readings."""

    def __init__(self) -> None:
        self.here_ns, self.wall_ns, self.readings = 1000 * S, WALL_NS, 0

    def __call__(self) -> ClockAnchor:
        self.readings += 1
        return ClockAnchor("boot", self.here_ns, self.wall_ns, 0)

    def pass_time(self, time_ns: int) -> None:
        self.here_ns += time_ns
        self.wall_ns += time_ns


@pytest.fixture
def clocks() -> Clocks:
    return Clocks()


def times(live: LiveMessages, clocks: Clocks, site_ns: int) -> tuple[int, int]:
    """Both times of a message that the site sent at this time of its clock."""
    (message,) = live.take(clocks.here_ns, [Fed("operator/rendered", site_ns, rendered())])
    return message.monotonic_ns, message.wall_ns


def test_every_stream_of_the_feed_has_a_topic() -> None:
    assert set(FED_TOPICS) == STREAMS


@pytest.mark.long
def test_names_values_and_times_are_those_of_the_export(fed: list[Fed], exported: list[NamedMessage]) -> None:
    begin_ns = exported[0].monotonic_ns
    live = LiveMessages(lambda: ClockAnchor("", begin_ns, exported[0].wall_ns, 0))
    assert live.take(begin_ns + HOUR_NS, fed) == exported
    assert live.counts == Counter(message.topic for message in exported)
    assert live.counts.keys() >= STREAMS - {"operator/played", "operator/figures", "operator/coupling"}


def test_values_of_the_status_file_are_fields(clocks: Clocks) -> None:
    (message,) = LiveMessages(clocks).take(clocks.here_ns, [Fed("operator/figures", clocks.here_ns, figures())])
    assert message.fields["state"] == "engaged"


@pytest.mark.parametrize(
    "damaged", [Fed("operator/touch", 0, b"\xc1"), Fed("operator/input", 0, b""), Fed("x", 0, b"")]
)
def test_an_unreadable_message_is_counted_and_the_others_pass(damaged: Fed, clocks: Clocks) -> None:
    live = LiveMessages(clocks)
    whole = Fed("operator/rendered", 999 * S, rendered())
    assert len(live.take(clocks.here_ns, [whole, damaged, whole])) == 2
    assert (live.damaged, live.counts.total()) == (1, 2)


def test_nothing_fed_is_no_message(clocks: Clocks) -> None:
    assert LiveMessages(clocks).take(clocks.here_ns, []) == []


def test_a_step_of_the_wall_clock_changes_nothing(clocks: Clocks) -> None:
    live = LiveMessages(clocks)
    for step_ns in (0, HOUR_NS, -HOUR_NS):
        clocks.wall_ns += step_ns
        clocks.pass_time(S)
        sent_ns = clocks.here_ns - LATE_NS
        assert times(live, clocks, sent_ns) == (sent_ns, WALL_NS + sent_ns - 1000 * S)
    assert clocks.readings == 1


@pytest.mark.parametrize("standstill_ns", [S // 2, HOUR_NS])
def test_times_are_right_after_the_host_was_suspended(standstill_ns: int, clocks: Clocks) -> None:
    live = LiveMessages(clocks)
    clocks.pass_time(S)
    times(live, clocks, clocks.here_ns - LATE_NS)
    clocks.wall_ns += standstill_ns  # the monotonic clock stands still, the site's clock does not
    clocks.pass_time(S)
    monotonic_ns, wall_ns = times(live, clocks, clocks.here_ns - LATE_NS + standstill_ns)
    assert clocks.here_ns - LATE_NS <= monotonic_ns <= clocks.here_ns
    assert clocks.wall_ns - wall_ns == clocks.here_ns - monotonic_ns


def test_times_are_right_after_the_site_was_restarted(clocks: Clocks) -> None:
    """Its clock begins without the standstills that the earlier one had added."""
    live = LiveMessages(clocks)
    times(live, clocks, clocks.here_ns + HOUR_NS)
    clocks.pass_time(S)
    sent_ns = clocks.here_ns - LATE_NS
    assert times(live, clocks, sent_ns) == (sent_ns, clocks.wall_ns - LATE_NS)
