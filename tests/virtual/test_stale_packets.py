"""Packets that come late, twice, in the wrong order, or from an earlier session are not used."""

import pytest

from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.session import VirtualSession

STREAMS = ("motion", "touch", "heartbeat", "control")


def works_on(working: VirtualSession, stream: str, refused: list[str], **changes: float) -> None:
    """The work continues in the same session on such a stream; where it is judged, each reason is counted."""
    ident = working.remote.server.session.ident
    working.network.impair(stream=stream, **changes)
    for now in working.run(2.0):
        assert now.force_n > 0.2, now
    assert working.at_work
    assert working.remote.server.session.ident == ident
    if stream in ("motion", "touch"):
        side = working.remote.server if stream == "motion" else working.operator.client
        for reason in refused:
            assert side.acceptance.refused[reason] > 10


@pytest.mark.long
@pytest.mark.parametrize("seconds", [0.7, 3.0])
def test_a_stall_that_ends_in_a_burst_is_safe_and_the_work_resumes(working: VirtualSession, seconds: float) -> None:
    working.network.impair(stalled=True)
    working.run(seconds)
    assert (working.now.force_n, working.now.motor_mv, working.now.peltier) == (0.0, 0, 0.0)
    server, client = working.remote.server, working.operator.client
    before = server.acceptance.received, client.acceptance.received
    working.network.heal()
    working.run(0.02)
    assert (server.acceptance.received, client.acceptance.received) == before, "the burst begins with what is oldest"
    assert {*server.acceptance.refused, *client.acceptance.refused} & {"age", "session"}
    working.work()


@pytest.mark.long
@pytest.mark.parametrize("stream", STREAMS)
def test_repeated_packets_are_only_counted(working: VirtualSession, stream: str) -> None:
    works_on(working, stream, ["sequence"], duplicate=0.5)


@pytest.mark.long
@pytest.mark.parametrize("stream", STREAMS)
def test_packets_that_overtake_each_other_by_20_ms_are_only_counted(working: VirtualSession, stream: str) -> None:
    works_on(working, stream, ["sequence"], reorder=0.5, reorder_s=0.020)


@pytest.mark.parametrize("stream", STREAMS)
def test_old_packets_of_this_and_of_an_earlier_session_are_only_counted(working: VirtualSession, stream: str) -> None:
    working.network.impair(cut=True)
    working.run(2.5)
    working.network.heal()
    working.work()
    working.run(0.3)
    works_on(working, stream, ["sequence", "session"], replay=0.3)


def test_old_packets_alone_move_nothing(working: VirtualSession) -> None:
    """Somebody plays a recording of both directions into a network that carries nothing else."""
    recordings = {
        direction: [packet for _, packet in working.network.ways[stream, direction].recorded]
        for stream, direction in (("motion", TO_REMOTE), ("touch", TO_OPERATOR))
    }
    working.network.impair(cut=True)
    working.run(0.5)
    working.network.impair(cut=False)
    for number in range(200):
        for stream, direction in (("motion", TO_REMOTE), ("touch", TO_OPERATOR)):
            recording = recordings[direction]
            working.network.ways[stream, direction].play(working.time_s, recording[number % len(recording)])
        working.tick()
