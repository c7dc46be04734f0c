"""The operator's end of a session against a remote site whose messages the test sends, in virtual time."""

from typing import Any

import pytest

from common.faults.fault import Fault, FaultCode
from common.limits import AGE_MAX_S
from common.link.capabilities import OBSERVER, OPERATOR
from common.link.emergency_stop import PATIENCE_NS
from common.link.session_state import Refused
from common.wire.messages import Motion
from common.wire.noted_consent import NotedConsent
from common.wire.packets import MAX_TEXT, LinkState
from common.wire.session_messages import ASKED_BEFORE, Answer
from operator_site.session.session_client import SILENCE_NS
from tests.unit.operator_site.session_pair import ABLE, FIRST_MOTION, IDENT, MS, Pair

HERE = "here: stopped, confirmed by every device after 2 ms"
UNCONFIRMED = {"after_s": 0.3, "unconfirmed": "middle thermal_sensor: no report"}
THERE = "remote site: stopped, confirmed by every device after 12 ms"
CONFIRMED = {"after_s": 0.012, "unconfirmed": ""}


def engage(pair: Pair, engages_itself: bool = False) -> None:
    """Engage at both sites."""
    pair.client.want_engaged, pair.client.engages_itself = True, engages_itself
    pair.run(300)
    pair.answer("engage", max_age_s=0.15)
    pair.remote.state = LinkState.ENGAGED
    pair.run(300)
    assert pair.client.both_engaged


def test_the_remote_calibration_is_reported_and_bounded(pair: Pair) -> None:
    assert pair.client.calibrated == ""
    pair.client.remote["calibrated"] = "Calibrated 2026-11-03, " + "x" * 1000
    assert pair.client.calibrated.startswith("Calibrated 2026-11-03, x")
    assert len(pair.client.calibrated) == 80


def test_an_emergency_stop_is_over_once_both_sites_reported_its_outcome(pair: Pair) -> None:
    pair.stop()
    assert pair.client.stopped == "", "the remote site has said nothing yet"
    pair.answer("estop", **CONFIRMED)
    assert pair.client.stopped == f"{HERE}; {THERE}"
    happenings = [happening.text for happening in pair.client.session.take_happenings() if happening.what == "estop"]
    assert happenings == [HERE, THERE]
    pair.stop()
    assert pair.client.stopped == "", "a second stop needs its own confirmation"
    pair.run(200)
    pair.answer("estop", after_s=0.034, unconfirmed="")
    assert pair.client.stopped == f"{HERE}; remote site: stopped, confirmed by every device after 34 ms"


def test_a_device_of_either_site_that_does_not_confirm_is_named(pair: Pair) -> None:
    pair.here = "no report"
    pair.stop()
    pair.answer("estop", **UNCONFIRMED)
    assert pair.client.stopped == "", "this site's own devices still have time"
    pair.run(PATIENCE_NS // MS)
    here, there = pair.client.stopped.split("; ")
    assert here == "here: stopped, but not confirmed within 300 ms by index tacttip: no report"
    assert there == "remote site: not confirmed by middle thermal_sensor: no report after 300 ms"


def test_each_confirmation_is_reported_and_the_remote_site_is_asked_until_it_confirms(pair: Pair) -> None:
    pair.here = "no report"
    pair.stop()
    assert pair.client.stopping.after_s == {
        "index tacttip": None,
        "exoskeleton": pytest.approx(0.002),
        "remote hand": None,
    }
    pair.answer("estop", **UNCONFIRMED)
    pair.run(98)
    pair.here = ""
    assert pair.asked("estop", 200) == 0, "it has just said that it cannot"
    assert pair.asked("estop", 1000) > 0
    assert pair.client.stopping.after_s["index tacttip"] == pytest.approx(0.11, abs=0.005)
    assert pair.client.stopping.after_s["remote hand"] is None
    pair.answer("estop", **CONFIRMED)
    assert pair.client.stopping.after_s["remote hand"] == pytest.approx(1.31, abs=0.02)
    assert pair.asked("estop", 1000) == 0


def test_a_cleared_stop_is_not_requested_again(pair: Pair) -> None:
    pair.stop()
    pair.answer("estop", **UNCONFIRMED)
    pair.client.clear(pair.remote.now_ns)
    pair.run(10)
    assert pair.asked("estop", 1000) == 0
    assert (pair.client.stopping.asked_ns, pair.client.stopping.after_s) == (None, {})


def test_a_silent_remote_site_is_reported_and_asked_again(pair: Pair) -> None:
    pair.stop()
    pair.run(round(PATIENCE_NS / MS + 2e3 * AGE_MAX_S) - 20)
    assert pair.client.stopped == "", "on the slowest link its word may still come"
    pair.run(30)
    assert pair.client.stopped == f"{HERE}; remote site: not confirmed, no answer within 1300 ms"
    assert pair.asked("estop", 1000) > 0
    pair.answer("estop", **CONFIRMED)
    assert pair.client.stopped == f"{HERE}; {THERE}"
    assert pair.asked("estop", 1000) == 0


def test_an_absent_remote_site_has_not_confirmed(pair: Pair) -> None:
    pair.remote.alive = False
    pair.run(SILENCE_NS // MS - 100)
    pair.stop()
    pair.run(200)
    assert pair.client.session.ident == 0
    assert pair.client.stopped == f"{HERE}; remote site: not confirmed, the remote site is silent"


@pytest.mark.parametrize("engages_itself", [True, False])
def test_a_lost_session_engages_again_only_without_a_required_request(pair: Pair, engages_itself: bool) -> None:
    pair.client.want_engaged, pair.client.engages_itself = True, engages_itself
    pair.remote.alive = False
    pair.run(SILENCE_NS // MS + 100)
    assert pair.client.session.ident == 0
    assert pair.client.want_engaged is engages_itself


def test_only_own_devices_count_without_a_remote_site() -> None:
    alone = Pair()
    alone.stop()
    assert alone.client.stopped == f"{HERE}; remote site: not connected"


@pytest.mark.parametrize(
    ("refused", "details", "words"),
    [
        ("that is not the present session", {}, "that is not the present session"),
        ("", {}, "it does not say how it went"),
        ("", {"after_s": "soon", "unconfirmed": ""}, "it does not say how it went"),
    ],
)
def test_an_answer_without_a_confirmation_confirms_nothing(
    refused: str, details: dict[str, Any], words: str, pair: Pair
) -> None:
    pair.stop()
    pair.answer("estop", refused, **details)
    assert pair.client.stopped == f"{HERE}; remote site: not confirmed, {words}"


def test_a_remote_fault_is_bounded_and_a_wrong_value_is_damaged(pair: Pair) -> None:
    pair.remote.state = LinkState.FAULT
    pair.run(20)
    pair.answer("status", fault=["made-up", "x" * 3000, "", 1.0, None, None, "y" * 3000, False])
    assert pair.client.remote_fault == Fault(FaultCode.UNKNOWN, "x" * MAX_TEXT, value=1.0, detail="made-up")
    for fault in ("hot", ["plate-too-hot"], {"code": "plate-too-hot"}, 7):
        damaged = pair.client.damaged["control"]
        pair.run(1_000)
        pair.answer("status", fault=fault)
        assert pair.client.damaged["control"] == damaged + 1
        assert pair.client.remote_fault is not None, "it is still latched there"


def test_the_reason_of_the_remote_site_for_not_clearing_is_known_until_its_fault_ends(pair: Pair) -> None:
    pair.remote.state = LinkState.FAULT
    pair.run(20)
    pair.answer("status", fault=Fault(FaultCode.REMOTE_STOP))
    assert pair.client.remote_fault == Fault(FaultCode.REMOTE_STOP)
    pair.client.refusal = "of something long ago"
    pair.client.clear(pair.remote.now_ns)
    assert pair.client.refusal == ""
    pair.run(20)
    pair.answer("clear_fault", "to be cleared where it was latched")
    assert pair.client.refusal == "to be cleared where it was latched"
    pair.remote.state = LinkState.CONNECTED
    pair.run(20)
    assert (pair.client.remote_fault, pair.client.refusal) == (None, "")
    with pytest.raises(Refused, match="no fault is latched"):
        pair.client.clear(pair.remote.now_ns)


def test_the_capabilities_of_the_remote_site_are_those_of_its_answer(pair: Pair) -> None:
    (connected,) = pair.client.session.take_happenings()
    assert (connected.what, connected.text) == ("connected", "calibration abc")
    assert pair.client.remote["calibration"] == "abc"


def test_an_incompatible_remote_site_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    foreign = Pair()
    for _ in range(5):
        hellos = foreign.remote.count("hello")
        while foreign.remote.count("hello") == hellos:
            foreign.run(200)
        foreign.answer("hello", session=IDENT, **{**ABLE, "layout": "another"})
        assert "laid out differently" in foreign.client.refusal
        assert foreign.client.session.ident == 0
    assert foreign.remote.count("goodbye") == 5, "it shall not wait for this operator"
    assert foreign.client.session.take_happenings() == [], "there was no session"
    assert caplog.text.count("laid out differently") == 1


def test_a_remote_site_that_this_site_refuses_is_asked_less_and_less_often() -> None:
    """The remote site logs two lines of each session that begins."""
    pair, asked = Pair(), []
    pair.client.calibration = "another"
    for _ in range(120):
        if pair.asked("hello", 1_000):
            pair.answer("hello", session=IDENT, first_motion=FIRST_MOTION, **ABLE)
            asked.append(pair.remote.now_ns)
            assert pair.client.refusal == "the remote site is calibrated with abc, this site expects another"
    assert 5 <= len(asked) <= 9
    assert (asked[-1] - asked[-2]) * 1e-9 == pytest.approx(30.0, abs=1.1)
    pair.client.calibration = "abc"  # as after a restart of the remote site with the right table
    while not pair.asked("hello", 1_000):
        pass
    pair.answer("hello", session=IDENT, first_motion=FIRST_MOTION, **ABLE)
    assert (pair.client.session.state, pair.client.refusal) == (LinkState.CONNECTED, "")


def test_an_old_clock_ends_the_wait_for_a_refused_remote_site() -> None:
    pair = Pair()
    pair.client.calibration = "another"
    pair.run(10)
    pair.answer("hello", session=IDENT, first_motion=FIRST_MOTION, **ABLE)
    assert pair.asked("hello", 500) == 0
    pair.remote.now_ns -= 10**11
    assert pair.asked("hello", 500) > 0


def test_without_motion_the_site_engages_again_later_and_later_and_says_why(
    pair: Pair, caplog: pytest.LogCaptureFixture
) -> None:
    pair.client.want_engaged = pair.client.engages_itself = True
    engaged = []
    for _ in range(300):
        if pair.asked("engage", 1_000):
            engage_without_motion(pair)
            engaged.append(pair.remote.now_ns)
            assert pair.client.refusal.startswith("no motion reaches the remote site; check that")
    assert 5 <= len(engaged) <= 8
    assert caplog.text.count("engages again after 60 s") >= 1
    pair.client.engage()
    assert pair.asked("engage", 400) > 0, "a person may try at any time"
    pair.answer("engage", max_age_s=0.15)
    pair.remote.state = LinkState.ENGAGED
    pair.run(10_000)
    assert pair.client.refusal == "", "motion arrives"
    engage_without_motion(pair)
    assert pair.client.refusal.endswith("engages again after 5 s"), "the failures before do not count"


def engage_without_motion(pair: Pair) -> None:
    """The remote site grants engaging, gets no motion, and ends it."""
    if not pair.client.session.engaged:
        pair.answer("engage", max_age_s=0.15)
    pair.remote.state = LinkState.ENGAGED
    pair.run(1_200)
    pair.answer("status", stale="no motion yet")
    pair.run(3_800)
    pair.remote.state = LinkState.CONNECTED
    pair.run(10)
    assert pair.client.session.state is LinkState.CONNECTED


def test_a_late_answer_to_a_repeated_hello_refuses_nothing() -> None:
    """A remote site that is slow to start grants the first hello, and has heard of the session at the second."""
    pair = Pair()
    pair.run(202)
    hellos = [request for request in pair.remote.asked if request.verb == "hello"]
    assert len(hellos) == 2
    granted = Answer(IDENT, hellos[0].sequence, pair.remote.now_ns, "", {"session": IDENT, **ABLE})
    refused = Answer(IDENT, hellos[1].sequence, pair.remote.now_ns, "another operator is connected", {})
    pair.remote.answers += [granted.encode(), refused.encode()]
    pair.run(20)
    assert pair.client.session.state is LinkState.CONNECTED
    assert pair.client.refusal == ""


def test_a_session_ended_by_the_remote_site_reports_the_reason_until_both_engage_again(pair: Pair) -> None:
    why = "motion has been refused for 1.5 s: sequence"
    pair.remote.answers.append(Answer(IDENT + 1, 0, pair.remote.now_ns, why, {}).encode())
    pair.run()
    assert pair.client.session.ident == IDENT, "of another session"
    pair.remote.answers.append(Answer(IDENT, 0, pair.remote.now_ns, why, {}).encode())
    pair.run()
    assert (pair.client.session.ident, pair.client.refusal) == (0, why)
    assert [h.text for h in pair.client.session.take_happenings() if h.what == "disconnected"] == [why]
    pair.run(ms=300)
    pair.answer("hello", session=IDENT, **ABLE)
    pair.run(ms=100)
    assert (pair.client.session.ident, pair.client.refusal) == (IDENT, why)
    pair.client.want_engaged = True
    pair.run(ms=300)
    pair.answer("engage", max_age_s=0.15)
    pair.run(ms=10)
    assert pair.client.session.engaged
    assert pair.client.refusal == ""


@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize("wanted_again", [False, True])
def test_an_engage_that_is_granted_after_a_person_has_disengaged_or_stopped_has_no_effect(
    pair: Pair, stopped: bool, wanted_again: bool
) -> None:
    pair.client.want_engaged = True
    assert pair.asked("engage", 300) > 0
    request = next(request for request in reversed(pair.remote.asked) if request.verb == "engage")
    if stopped:
        pair.stop()
        pair.client.clear(pair.remote.now_ns)
    else:
        pair.client.disengage(pair.remote.now_ns)
    pair.client.want_engaged = wanted_again
    granted = Answer(IDENT, request.sequence, pair.remote.now_ns, "", {"max_age_s": 0.15})
    pair.remote.answers.append(granted.encode())
    pair.run()
    assert pair.client.session.state is LinkState.CONNECTED
    pair.client.want_engaged = True
    assert pair.asked("engage", 300) > 0
    pair.answer("engage", max_age_s=0.15)
    assert pair.client.session.engaged


@pytest.mark.parametrize("engages_itself", [False, True])
def test_clearing_a_fault_needs_a_new_request_even_before_the_next_tick(pair: Pair, engages_itself: bool) -> None:
    engage(pair, engages_itself)
    pair.client.session.latch(Fault(FaultCode.MODULE_CUT_OUT, "index"))
    pair.client.clear(pair.remote.now_ns)
    assert pair.asked("engage", 300) == 0
    assert pair.client.session.state is LinkState.CONNECTED


@pytest.mark.parametrize("engages_itself", [False, True])
def test_after_a_fault_of_the_remote_site_engaging_needs_a_new_request(pair: Pair, engages_itself: bool) -> None:
    engage(pair, engages_itself)
    pair.remote.state = LinkState.FAULT
    pair.run(500)
    pair.remote.state = LinkState.CONNECTED
    assert pair.asked("engage", 1000) == 0
    assert pair.client.session.state is LinkState.CONNECTED


@pytest.mark.parametrize("engages_itself", [False, True])
def test_a_fault_of_this_site_ends_the_wish_to_engage(pair: Pair, engages_itself: bool) -> None:
    pair.client.want_engaged, pair.client.engages_itself = True, engages_itself
    pair.client.session.latch(Fault(FaultCode.MODULE_CUT_OUT, "index"))
    pair.run()
    assert not pair.client.want_engaged


def test_a_disengage_here_is_neutral_at_once_and_asked_of_the_remote_site(pair: Pair) -> None:
    engage(pair)
    pair.client.disengage(pair.remote.now_ns, "no console")
    session = pair.client.session
    assert (session.state, session.paused, pair.client.want_engaged) == (LinkState.CONNECTED, "no console", False)
    assert pair.remote.count("disengage") == 1


def test_a_note_is_sent_to_the_remote_site(pair: Pair) -> None:
    pair.client.annotate(pair.remote.now_ns, "warm here")
    assert pair.remote.asked[-1].verb == "annotate"
    assert pair.remote.asked[-1].details == {"text": "warm here"}


def test_a_lost_session_brings_no_wish_back_and_leaves_no_fault_of_the_remote_site(pair: Pair) -> None:
    pair.client.want_engaged, pair.remote.state = False, LinkState.FAULT
    pair.run(10)
    pair.answer("status", fault=list(Fault(FaultCode.REMOTE_STOP)))
    assert pair.client.remote_fault == Fault(FaultCode.REMOTE_STOP)
    pair.remote.alive = False
    pair.run(SILENCE_NS // MS + 100)
    assert (pair.client.session.ident, pair.client.want_engaged, pair.client.remote_fault) == (0, False, None)


def test_only_an_operator_in_a_session_says_goodbye(pair: Pair) -> None:
    alone = Pair()
    alone.client.goodbye(alone.remote.now_ns)
    pair.client.role = OBSERVER
    pair.client.goodbye(pair.remote.now_ns)
    assert alone.remote.count("goodbye") == pair.remote.count("goodbye") == 0
    pair.client.role = OPERATOR
    pair.client.goodbye(pair.remote.now_ns)
    assert pair.remote.count("goodbye") == 1


@pytest.mark.parametrize(
    ("refused", "engages_itself", "repeats"),
    [(ASKED_BEFORE, False, False), (ASKED_BEFORE, True, True), ("not ready: exoskeleton", False, True)],
)
def test_a_persons_engage_is_not_repeated_after_a_person_at_the_remote_site_has_disengaged(
    pair: Pair, refused: str, engages_itself: bool, repeats: bool
) -> None:
    pair.client.want_engaged, pair.client.engages_itself = True, engages_itself
    pair.run(300)
    pair.answer("engage", refused)
    assert pair.client.refusal == refused
    assert (pair.asked("engage", 1000) > 0) is pair.client.want_engaged is repeats


def test_no_motion_is_sent_without_a_session() -> None:
    pair = Pair()
    pair.run()
    assert pair.client.send_motion(pair.remote.now_ns, 0.0, 0.0, [0.0] * 5) is None


def test_an_observer_requests_nothing_but_the_session() -> None:
    pair = Pair()
    pair.client.role, pair.client.want_engaged = OBSERVER, True
    pair.connect()
    pair.run(3000)
    assert pair.client.session.ident == IDENT, "its heartbeats keep it"
    assert {request.verb for request in pair.remote.asked} == {"hello"}


@pytest.mark.parametrize("engages_itself", [False, True])
def test_a_remote_site_that_has_disengaged_is_asked_again_only_without_a_required_request(
    pair: Pair, engages_itself: bool
) -> None:
    engage(pair, engages_itself)
    pair.remote.state = LinkState.CONNECTED
    assert (pair.asked("engage", 1_000) > 0) is engages_itself
    assert pair.client.session.paused == "the remote site is no longer engaged"
    pair.client.want_engaged = True
    pair.run(300)
    pair.answer("engage", max_age_s=0.15)
    assert pair.client.session.engaged


@pytest.mark.parametrize("engages_itself", [False, True])
def test_an_engage_that_was_requested_before_the_session_counts_only_without_a_required_request(
    engages_itself: bool,
) -> None:
    """Otherwise a request at an absent remote site would engage whenever that site comes, with nobody there."""
    pair = Pair()
    pair.client.want_engaged, pair.client.engages_itself = True, engages_itself
    pair.run(2_000)
    pair.connect()
    assert (pair.asked("engage", 300) > 0) is engages_itself


def test_a_remote_site_cannot_raise_the_age_that_this_site_permits(pair: Pair) -> None:
    pair.client.want_engaged = True
    pair.run(300)
    pair.answer("engage", max_age_s=AGE_MAX_S)
    assert pair.client.session.engaged
    assert pair.client.acceptance.max_age_ns == 150 * MS


def test_touch_that_was_sent_before_the_remote_site_engaged_does_not_disengage(pair: Pair) -> None:
    pair.client.want_engaged, pair.client.max_age_s = True, AGE_MAX_S
    pair.run(300)
    pair.answer("engage", max_age_s=AGE_MAX_S)
    pair.run(round(1e3 * AGE_MAX_S) - 10)
    assert pair.client.session.engaged, "this touch may be older than the grant"
    pair.run(20)
    assert not pair.client.session.engaged


def test_a_link_that_was_too_slow_is_no_reason_any_more_after_it_became_fast(pair: Pair) -> None:
    usual_ns, pair.client.acceptance.max_age_ns = pair.client.acceptance.max_age_ns, 1
    pair.run(100)
    assert pair.client.refusal == "", "nobody asked to engage"
    pair.client.want_engaged = True
    assert pair.asked("engage", 100) == 0
    assert pair.client.refusal.startswith("the link is too slow: a round trip of ")
    pair.client.disengage(pair.remote.now_ns)
    pair.run(100)
    assert pair.client.refusal.startswith("the link is too slow"), "it still is"
    pair.client.acceptance.max_age_ns = usual_ns
    pair.run(100)
    assert pair.client.refusal == ""


def test_a_remote_site_that_sends_far_too_many_answers_is_read_no_faster(pair: Pair) -> None:
    for _ in range(10):
        pair.remote.answers += [b"rubbish"] * 60
        pair.run()
    assert pair.client.damaged["control"] <= 210
    assert pair.client.damaged["control: too many"] >= 390


def test_after_the_clock_was_set_back_it_asks_and_beats_on_and_finds_a_silent_remote_site(pair: Pair) -> None:
    pair.remote.now_ns -= 100 * 10**9
    assert pair.asked("status", 3000) >= 2
    assert pair.client.session.ident == IDENT
    pair.remote.now_ns -= 100 * 10**9
    pair.remote.alive = False
    pair.run(SILENCE_NS // MS)
    assert pair.client.session.ident == IDENT
    pair.run(100)
    assert pair.client.session.ident == 0


def test_a_silence_of_touch_and_its_end_are_noted(pair: Pair) -> None:
    pair.client.want_engaged, pair.remote.state = True, LinkState.ENGAGED
    pair.run()
    pair.answer("engage", max_age_s=0.15)
    pair.run(100)
    assert pair.client.both_engaged
    pair.client.session.take_happenings()
    pair.remote.alive = False
    pair.run(104)
    pair.remote.alive = True
    pair.run()
    said = [(happening.what, happening.text) for happening in pair.client.session.take_happenings()]
    assert said == [("silent", "no touch for 100 ms"), ("heard", "touch again")]


def test_the_patients_consent_is_what_the_remote_site_has_noted(pair: Pair) -> None:
    pair.client.remote.clear()  # as before the first hello
    assert pair.client.remote_consent is None
    pair.client.remote["session"] = 7
    assert pair.client.remote_consent == NotedConsent(None)
    pair.client.remote["consented"] = ["voice", "touch", "something newer"]
    assert pair.client.remote_consent == NotedConsent(("touch", "voice"))
    pair.client.remote["consented"] = "touch"
    assert pair.client.remote_consent == NotedConsent(None)


def test_the_scale_of_roughness_is_that_of_the_remote_site_or_none(pair: Pair) -> None:
    assert pair.client.roughness_um is None
    scale = {"ln_um": 4.0, "exponent": 0.8, "ln_sd": 0.1, "least_v": 0.01, "most_v": 0.3}
    pair.client.remote["roughness_um"] = scale | {"later": 1.0}
    assert pair.client.roughness_um == scale
    pair.client.remote["roughness_um"] = "rough"
    assert pair.client.roughness_um is None


@pytest.mark.parametrize(
    ("role", "gap_s", "doubled"), [(OPERATOR, 0.1, True), (OPERATOR, 0.07, False), (OBSERVER, 0.1, False)]
)
def test_the_operator_of_a_far_remote_site_with_late_heartbeats_gets_second_connections(
    pair: Pair, role: str, gap_s: float, doubled: bool
) -> None:
    pair.client.role, pair.client.gap_s = role, gap_s
    pair.remote.round_trip_ms = 100
    pair.run(5000)
    assert not pair.remote.doubled
    for _ in range(3):
        pair.remote.round_trip_ms = 250
        pair.run(100)
        pair.remote.round_trip_ms = 100
        pair.run(1000)
    assert pair.remote.doubled is doubled


def test_motion_is_numbered_from_where_the_answer_to_hello_says(pair: Pair) -> None:
    assert "first_motion" not in pair.client.remote, "it is no one else's business"
    packet = pair.client.send_motion(pair.remote.now_ns, 0.0, 0.0, [0.0] * 5)
    assert packet is not None
    assert Motion.decode(packet).sequence == FIRST_MOTION


@pytest.mark.parametrize("first_motion", [0, -1, 1.0, True, "1", None, [1]])
def test_an_answer_to_hello_with_a_wrong_first_number_begins_no_session(first_motion: Any) -> None:
    pair = Pair()
    pair.run()
    pair.remote.answer("hello", session=IDENT, first_motion=first_motion, **ABLE)
    pair.run(20)
    assert pair.client.session.ident == 0
    assert pair.client.damaged["control"] == 1
