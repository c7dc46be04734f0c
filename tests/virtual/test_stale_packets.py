"""Packets that come late, twice, in the wrong order, or from an earlier session are not used."""

import pytest

from teletaction.testbed.network import TO_OPERATOR, TO_REMOTE
from tests.virtual.session import VirtualSession

STREAMS = (
    "motion",
    "touch",
    pytest.param("heartbeat", marks=pytest.mark.long),
    pytest.param("control", marks=pytest.mark.long),
)
STALE: dict[str, dict[str, float]] = {
    "twice": {"duplicate": 0.5},
    "overtaken by 20 ms": {"reorder": 0.5, "reorder_s": 0.020},
    "of this and an earlier session": {"replay": 0.3},
}


@pytest.mark.long
def test_a_stall_that_ends_in_a_burst_is_safe_and_the_work_resumes(working: VirtualSession) -> None:
    working.network.impair(stalled=True)
    working.run(0.7)
    assert (working.now.force_n, working.now.motor_mv, working.now.peltier) == (0.0, 0, 0.0)
    server, client = working.remote.server, working.operator.client
    before = server.acceptance.received, client.acceptance.received
    working.network.heal()
    working.run(0.02)
    assert (server.acceptance.received, client.acceptance.received) == before, "the burst begins with what is oldest"
    assert {*server.acceptance.refused, *client.acceptance.refused} & {"age", "session"}
    working.resume()


@pytest.mark.long
@pytest.mark.parametrize("stream", STREAMS)
def test_packets_that_come_twice_late_or_of_an_earlier_session_do_nothing_but_count(
    working: VirtualSession, stream: str
) -> None:
    working.network.impair(cut=True)
    working.run(0.5)
    working.run_coarsely(2.0)
    working.network.heal()
    working.work()
    ident = working.remote.server.session.ident
    for how, impairment in STALE.items():
        working.network.impair(stream=stream, **impairment)
        for now in working.run(0.9):
            assert now.force_n > 0.2, (how, now)
        assert working.at_work, how
        assert working.remote.server.session.ident == ident, how
        working.network.heal()
    if stream in ("motion", "touch"):
        side = working.remote.server if stream == "motion" else working.operator.client
        assert min(side.acceptance.overtaken, side.acceptance.refused["session"]) > 5


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
