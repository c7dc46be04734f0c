"""Status files, supervisor and local control of both sites over a silent link never report engaged."""

import pytest

from common.limits import GAP_S
from common.runtime.site_loop import in_words
from operator_site.session.local_control import answer_desk
from operator_site.session.session_client import SILENCE_NS
from tests.virtual.session import TICK_S, VirtualSession

pytestmark = pytest.mark.long


def states(session: VirtualSession) -> set[str]:
    """The state by each way in which a site says it."""
    operator, remote = session.operator, session.remote
    now_ns = session.operator_host.now_ns()
    desk = answer_desk(operator.client, operator.attendance, operator.coupling, now_ns, "", "status", {})["state"]
    figures = [site.figures() for site in (operator, remote)]
    return {desk, *(str(each["state"]) for each in figures), *(in_words(each).split(":")[0] for each in figures)}


def test_no_site_reports_engaged_over_a_silent_link(working: VirtualSession) -> None:
    assert states(working) == {"engaged"}
    working.network.impair(cut=True)
    working.run(GAP_S + 5 * TICK_S)
    silent_s = SILENCE_NS * 1e-9
    while not working.operator.client.acceptance.gap_ns(working.operator_host.now_ns()) >= 0.9 * silent_s * 1e9:
        working.tick()
        assert states(working) <= {"lost", "disconnected"}
    working.run(silent_s)
    assert states(working) == {"disconnected"}
    working.network.heal()
    working.until(lambda session: session.both_engaged, 3.0)
    assert states(working) == {"engaged"}


def test_a_site_with_a_disengaged_peer_is_engaging_at_most(working: VirtualSession) -> None:
    working.ask("disengage")
    while working.remote.server.session.engaged:
        working.tick()
    assert working.remote.figures()["state"] == "connected"
    while working.operator.client.session.engaged:
        touch = working.operator.client.touch
        assert touch is not None
        assert (working.operator.figures()["state"] == "engaged") is (touch.state.name == "ENGAGED")
        working.tick()
