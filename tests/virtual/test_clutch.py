"""Clutch and motion scale in a session of both sites: where the remote hand goes, and what the finger gets."""

from concurrent.futures import Future
from itertools import pairwise
from typing import Any

import msgpack
import pytest

from common.fingers import FINGERS
from common.limits import COUPLING_STEP_N, FORCE_SAFE_S, GAP_S
from common.link.session_state import Refused
from common.timing.timeouts import MOTION_SILENCE_S
from common.wire.packets import LinkState
from operator_site.console.model import Console
from operator_site.console.texts import MOTION_LOST
from operator_site.coupling.coupling import Places
from tests.virtual.session import VirtualSession

RESOLUTION_N = 0.01
"""Of a force on the exoskeleton's bus, N."""
KNOWN_WITHIN_S = 1.5
"""Time in which the operator's site knows the remote one's status: it is asked once a second."""
SETTLED_S = 0.3
"""Longest time in which the remote hand stands after the command does, s."""


def ask(session: VirtualSession, verb: str, **details: Any) -> dict[str, Any]:
    """Ask at the operator's desk; the next tick answers."""
    answer: Future[dict[str, Any]] = session.desks["operator"].ask(verb, details)
    while not answer.done():
        session.tick()
    return answer.result()


@pytest.mark.long
def test_an_open_clutch_holds_the_remote_hand_and_frees_the_finger(working: VirtualSession) -> None:
    pressing = len(working.truth) - 1
    ask(working, "clutch", open=True)
    working.run(0.5)
    forces = [truth.force_n for truth in working.truth[pressing:]]
    assert forces[0] > 0.3
    assert forces[-1] == 0.0
    assert max(before - after for before, after in pairwise(forces)) <= COUPLING_STEP_N + RESOLUTION_N
    hand = working.sim_operator.hand
    from_m, (first, *_, last) = hand.x_m, working.run(1.0)
    assert abs(hand.x_m - from_m) > 0.02, "the operator's hand moves"
    assert abs(last.x_m - first.x_m) < 0.1e-3
    assert last.contact_n > 0.1, "the remote finger stays on the object"
    assert last.force_n == 0.0
    assert working.both_engaged


def test_closing_begins_at_the_hand_and_the_scale_divides_its_motion(working: VirtualSession) -> None:
    ask(working, "clutch", open=True)
    working.run(SETTLED_S)
    held_m = working.now.x_m
    ask(working, "scale", scale=5)
    ask(working, "clutch", open=False)
    hand = working.sim_operator.hand
    from_m, first = hand.x_m, len(working.truth)
    working.run(0.4)
    moved_m = hand.x_m - from_m
    assert abs(moved_m) > 0.005
    steps_m = [abs(after.x_m - before.x_m) for before, after in pairwise(working.truth[first:])]
    assert max(steps_m) < 0.1e-3, "no step of the remote hand"
    command_m = working.operator.coupling.now.command(Places(hand.x_m, 0.0, (0.0,) * len(FINGERS))).x_m
    assert command_m - held_m == pytest.approx(moved_m / 5, abs=0.5e-3)
    assert working.now.x_m == pytest.approx(command_m, abs=2e-3), "behind by link and servo"
    assert working.latched == (False, False)


@pytest.mark.long
def test_the_scale_stays_while_the_finger_presses(working: VirtualSession) -> None:
    with pytest.raises(Refused, match="a finger presses"):
        ask(working, "scale", scale=2)
    assert working.operator.coupling.now.direct


@pytest.mark.long
def test_a_silent_link_under_an_open_clutch_pauses_the_session(working: VirtualSession) -> None:
    ask(working, "clutch", open=True)
    working.run(SETTLED_S)
    before = working.operator.client._sequence
    working.network.impair(cut=True)
    working.run(GAP_S + FORCE_SAFE_S)
    assert working.operator.client.session.state is LinkState.CONNECTED
    assert working.operator.client.session.paused == "the link was silent while the clutch was open"
    assert working.operator.client._sequence - before < 20, "it disengages once, not in each tick"


@pytest.mark.long
def test_lost_motion_under_an_open_clutch_lifts_the_finger_and_pauses_the_session(working: VirtualSession) -> None:
    """The operator's site hears the remote one, and learns from its status that no motion arrives."""
    ask(working, "clutch", open=True)
    working.run(SETTLED_S)
    assert working.now.contact_n > 0.1
    working.network.impair(stream="motion", cut=True)
    working.until(lambda each: each.now.contact_n == 0.0, 0.5)
    session = working.operator.client.session
    working.until(lambda _: session.state is LinkState.CONNECTED, KNOWN_WITHIN_S)
    assert session.paused == "motion was lost while the clutch was open"
    working.network.heal()
    working.run(1.0)
    assert working.now.contact_n == 0.0, "no hand lowers the finger"


@pytest.mark.long
def test_lost_motion_is_said_at_both_sites_and_disengages_them(working: VirtualSession) -> None:
    console = Console()

    def alarms() -> list[str]:
        now_ns = working.operator_host.now_ns()
        console.take("operator/figures", now_ns, msgpack.packb(working.operator.figures()))
        console.step(now_ns * 1e-9)
        return [alarm.text for alarm in console.alarms.listed if alarm.ended_s is None]

    working.run(1.0)
    assert MOTION_LOST not in alarms()
    working.operator.client.engages_itself = False
    working.network.impair(stream="motion", cut=True)
    working.run(GAP_S + KNOWN_WITHIN_S)
    assert working.remote.figures()["state"] == "lost"
    assert str(working.remote.figures()["stale"]).startswith("no motion for 1.")
    assert str(working.operator.figures()["stale"]).startswith("at the remote site: no motion for ")
    assert MOTION_LOST in alarms()
    working.run(MOTION_SILENCE_S)
    sessions = working.remote.server.session, working.operator.client.session
    assert [session.state for session in sessions] == [LinkState.CONNECTED] * 2
    assert sessions[0].paused == "no motion for 5 s"
    assert str(sessions[1].paused).startswith("the remote site is no longer engaged: no motion for ")
    assert MOTION_LOST not in alarms()
    working.network.heal()
    working.run(1.0)
    assert working.now.contact_n == 0.0
    assert not working.operator.client.want_engaged, "a person engages again"


@pytest.mark.long
def test_a_pause_and_a_resume_close_the_clutch_where_the_hand_is(working: VirtualSession) -> None:
    ask(working, "clutch", open=True)
    working.run(SETTLED_S)
    ask(working, "disengage")
    working.run(0.5)
    with pytest.raises(Refused, match="only while engaged"):
        ask(working, "clutch", open=True)
    working.engage()
    working.until(lambda each: each.both_engaged, 2.0)
    working.run(0.02)
    assert not working.operator.coupling.now.open
    before_m = working.now.x_m
    working.tick()
    assert abs(working.now.x_m - before_m) < 1e-3
