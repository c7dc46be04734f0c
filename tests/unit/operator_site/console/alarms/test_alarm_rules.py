"""Each thing that may go wrong is one alarm with its priority, its words, and nothing beside it."""

from dataclasses import replace
from typing import Any

import msgpack
import pytest

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_figures
from operator_site.console.alarms.alarm_rules import Surroundings
from operator_site.console.model import Console
from operator_site.console.state.frame import Priority
from operator_site.console.web.page_state import page_state
from operator_site.safety.limit_flags import Limit
from tests.unit.operator_site.console.fed import S, fed, figures, happen, rendered, touch

DISK_FULL = (Priority.MEDIUM, "Disk full. Recording stopped, findings are kept.")
NOT_RECORDED = (Priority.MEDIUM, "Recording stopped. Check the disk, then start again.")
REMOTE_NOT_RECORDED = (Priority.MEDIUM, "Remote recording stopped. Check the remote site.")


@pytest.fixture
def console() -> Console:
    """At work up to 102 s."""
    made = Console()
    happen(made, 100.0, "connected")
    happen(made, 100.0, "engaged")
    fed(made, 100.0, 102.0)
    return made


def shown(console: Console, now_s: float) -> list[tuple[Priority, str]]:
    """Priority and text of the alarms that are shown."""
    console.step(now_s)
    return [(alarm.cause.priority, alarm.text) for alarm in console.alarms.listed if alarm.ended_s is None]


def test_nothing_is_wrong_where_nothing_is(console: Console) -> None:
    assert shown(console, 102.0) == []


def test_a_silent_site_is_the_only_alarm_there_is(console: Console) -> None:
    assert shown(console, 102.4) == []
    assert shown(console, 102.7) == [(Priority.HIGH, "No data for 0.7 s. Screen is not live.")]
    fed(console, 102.7, 102.8)
    assert shown(console, 102.8) == [], "its silence ended no session"


def test_a_silent_site_that_drives_nothing_is_of_low_priority_and_ends_by_itself() -> None:
    console = Console()
    happen(console, 100.0, "connected")
    assert shown(console, 100.6) == [(Priority.LOW, "No data for 0.6 s. Screen is not live.")]
    happen(console, 100.7, "connected")
    assert shown(console, 100.7) == []


def test_a_fault_is_not_over_while_its_site_is_silent(console: Console) -> None:
    happen(console, 102.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "middle", value=1.2, rate_hz=23.0))
    fault = (Priority.HIGH, "Middle: force swings 23 Hz, 1.2 N. Force is off.")
    assert shown(console, 102.0) == [fault]
    assert shown(console, 103.0) == [(Priority.HIGH, "No data for 1.0 s. Screen is not live."), fault]
    assert console.alarms.clear(103.0, "me") == 0


def test_a_short_silence_of_the_link_ends_by_itself(console: Console) -> None:
    console.take("operator/rendered", 102 * S, rendered(gap_s=0.15))
    assert shown(console, 102.0) == [(Priority.HIGH, "LINK LOST. Outputs are neutral. Wait for the link.")]
    fed(console, 102.0, 102.1)
    assert shown(console, 102.1) == []


@pytest.mark.parametrize("answers_first", [False, True])
def test_a_link_that_is_lost_while_engaged_latches_until_it_is_back_and_cleared(
    console: Console, answers_first: bool
) -> None:
    console.take("operator/rendered", 102 * S, rendered(gap_s=0.15))
    lost = (Priority.HIGH, "LINK LOST. Outputs are neutral. Wait for the link.")
    assert shown(console, 102.0) == [lost]
    if answers_first:  # the answer of the local control overtakes the feed
        console.take_answer(102.01, {"state": "disconnected", "session": 0, "time_ns": round(102.01 * S)})
        assert shown(console, 102.01) == [lost]
    happen(console, 102.0, "disconnected", "the remote site is silent")
    assert shown(console, 102.1) == [lost]
    assert console.alarms.clear(102.1, "me") == 0
    happen(console, 102.2, "connected")
    console.take("operator/rendered", round(102.2 * S), rendered(engaged=False))
    assert shown(console, 102.2) == [(Priority.HIGH, "Link was lost: session ended. Acknowledge (K).")]
    assert console.alarms.clear(102.3, "me") == 1


def test_motion_that_does_not_reach_the_remote_site_is_an_alarm_until_it_arrives_again(console: Console) -> None:
    answer = {"state": "engaged", "session": 7, "time_ns": 102 * S, "remote_stale": "no motion for 1.20 s"}
    console.take_answer(102.0, answer)
    assert shown(console, 102.0) == [(Priority.HIGH, "MOTION LOST: remote fingers have lifted. Wait, or pause.")]
    console.take("operator/rendered", 102 * S, rendered(gap_s=0.15))
    assert [text.split(".")[0] for _, text in shown(console, 102.0)] == ["LINK LOST"], "nothing is known beyond it"
    fed(console, 102.0, 102.1)
    console.take_answer(102.1, answer | {"time_ns": round(102.1 * S), "remote_stale": ""})
    assert shown(console, 102.1) == []


def test_a_link_that_goes_while_nobody_is_engaged_is_no_alarm() -> None:
    console = Console()
    happen(console, 100.0, "connected")
    happen(console, 100.1, "disconnected", "the remote site is silent")
    assert shown(console, 100.2) == []


def test_a_remote_hand_that_is_back_with_the_link_is_not_lost_until_the_next_figures(console: Console) -> None:
    console.site.take_figures(101.0, {"state": "engaged", "session": 7, "devices": {}})
    happen(console, 101.1, "disconnected", "the remote site is silent")
    console.site.take_figures(102.0, {"state": "disconnected", "session": 0, "devices": {}})
    happen(console, 102.1, "connected")
    assert shown(console, 102.2) == []


@pytest.mark.parametrize(
    ("said", "alarms"),
    [
        ({}, [(Priority.HIGH, "Remote site: emergency stop there. It stands still.")]),
        ({"stop_asked_ns": 102 * S, "stop_devices": ["telemanipulator"], "stop_after_s": [0.03]}, []),
    ],
)
def test_a_remote_hand_that_a_fault_or_a_stop_holds_is_not_lost(
    console: Console, said: dict[str, Any], alarms: list[tuple[Priority, str]]
) -> None:
    fault = fault_figures(Fault(FaultCode.REMOTE_STOP))
    console.take("operator/figures", 102 * S, figures(state="connected", remote_fault=fault, **said))
    assert shown(console, 102.0) == alarms
    checks = page_state(console, 102.0, lambda _: True, "operator.toml")["devices"]
    assert all(check["ready"] for check in checks)


def test_a_slow_link_is_an_alarm_of_medium_priority(console: Console) -> None:
    console.take("operator/clock", 102 * S, msgpack.packb([200_000_000, 8_000_000, 400_000_000]))
    for n in range(150):
        at_ns = round((102.0 + n * 0.01) * S)
        console.take("operator/touch", at_ns, touch(20_000 + n, at_ns - 10_000_000))
        console.take("operator/rendered", at_ns, rendered())
    assert shown(console, 103.5) == [(Priority.MEDIUM, "Link slow: 210 ± 8 ms. Move slowly.")]


def test_a_plate_over_its_limit_is_one_alarm_and_its_fault_is_none_beside_it(console: Console) -> None:
    console.take("operator/rendered", 102 * S, rendered(plate_c=42.3))
    happen(console, 102.0, "fault", fault=Fault(FaultCode.PLATE_TOO_HOT, "index", value=42.3, limit=42.0))
    over = [(Priority.HIGH, f"{finger}: plate 42.3 °C, over 42.0. Heat is off.") for finger in ("Index", "Middle")]
    assert sorted(shown(console, 102.0)) == over


def test_a_plate_at_its_limit_is_one_to_act_on_soon(console: Console) -> None:
    console.take("operator/rendered", 102 * S, rendered(plate_c=41.9, limited=int(Limit.PLATE_TEMPERATURE)))
    assert (Priority.MEDIUM, "Index: plate at 41.9 °C, held at its limit. Lift the finger.") in shown(console, 102.0)


def test_a_fault_is_shown_until_it_is_cleared(console: Console) -> None:
    happen(console, 102.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "middle", value=1.2, rate_hz=23.0))
    assert shown(console, 102.0) == [(Priority.HIGH, "Middle: force swings 23 Hz, 1.2 N. Force is off.")]
    happen(console, 102.1, "cleared")
    assert shown(console, 102.1) == [(Priority.HIGH, "Fault is over. Acknowledge (K).")]


def stop(console: Console, at_s: float, now_s: float, **after_s: float | None) -> None:
    """Take the site's answer about a stop that was requested at `at_s`."""
    names = {"index": "index tacttip", "arm": "remote hand", "exoskeleton": "exoskeleton"}
    devices = [names[name] for name in after_s]
    said = {"state": "fault", "fault": Fault(FaultCode.OPERATOR_STOP), "session": 7}
    console.take_answer(
        now_s, said | {"stop_asked_ns": round(at_s * S), "stop_devices": devices, "stop_after_s": [*after_s.values()]}
    )


def test_an_overtaken_answer_of_the_site_is_not_taken(console: Console) -> None:
    stop(console, 101.0, 101.9, index=0.01)
    happen(console, 102.0, "cleared")
    fault = {"state": "fault", "fault": Fault(FaultCode.OPERATOR_STOP), "stop_asked_ns": 101 * S}
    console.take_answer(102.1, {**fault, "time_ns": round(101.99 * S)})
    assert (console.site.fault, console.site.stop_asked_s) == (None, None)
    console.take_answer(102.2, {**fault, "time_ns": round(102.19 * S)})
    assert console.site.stop_asked_s == 101.0


def test_a_stop_that_is_confirmed_is_no_alarm(console: Console) -> None:
    stop(console, 102.0, 102.05, index=None, exoskeleton=0.01)
    assert shown(console, 102.05) == [], "the devices still have time"
    stop(console, 102.0, 102.4, index=0.06, exoskeleton=0.01)
    assert shown(console, 102.4) == []


def test_a_stop_that_is_not_confirmed_names_who_has_not_and_cannot_be_silenced(console: Console) -> None:
    stop(console, 101.6, 102.0, index=None, arm=None, exoskeleton=0.01)
    said = "STOP NOT CONFIRMED: Index, remote hand. Use the hardware switch."
    assert shown(console, 102.0) == [(Priority.HIGH, said)]
    assert not console.alarms.quiet(102.0, "stop", 60.0)
    stop(console, 101.6, 102.1, index=0.45, arm=0.47, exoskeleton=0.01)
    assert [alarm.ident for alarm in console.alarms.listed if alarm.waits] == []
    shown(console, 102.1)
    assert console.alarms.clear(102.2, "me") == 1


def test_the_remote_hand_has_a_round_trip_longer(console: Console) -> None:
    stop(console, 101.68, 102.0, arm=None)
    assert shown(console, 102.0) == [], "0.32 s, and the link takes 20 ms each way"
    stop(console, 101.65, 102.0, arm=None)
    assert len(shown(console, 102.0)) == 1


@pytest.mark.parametrize(
    ("around", "expected"),
    [
        (Surroundings(disk_used=0.91), [(Priority.LOW, "Disk 91 % full. Make room soon.")]),
        (
            Surroundings(recording_failed=True),
            [(Priority.MEDIUM, "Console's own record stopped. Findings are kept here.")],
        ),
        (
            Surroundings(recording_failed=True, disk_used=1.0),
            [DISK_FULL, (Priority.LOW, "Disk 100 % full. Make room soon.")],
        ),
        (Surroundings(sound="refused"), [(Priority.LOW, "Sound is off. Watch the alarm line.")]),
        (Surroundings(page_slow=True), [(Priority.LOW, "Console slow. Close other programs.")]),
    ],
)
def test_the_consoles_surroundings_are_alarms(
    console: Console, around: Surroundings, expected: list[tuple[Priority, str]]
) -> None:
    console.around = around
    assert shown(console, 102.0) == expected


def bus(**exoskeleton: object) -> dict[str, Any]:
    """Figures in which the exoskeleton's CAN controller says something."""
    said = {"missing": "", "controller": "error-active", "controller_errors": {}} | exoskeleton
    return {"devices": {"exoskeleton": said, "index tacttip": {"missing": ""}, "middle tacttip": {"missing": ""}}}


ENDED = "the process that writes it has ended"
BEHIND = "442 of 500 ticks a second; it works 32% of the time and waits for a processor 23%"


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (bus(controller="error-passive"), [(Priority.LOW, "Exoskeleton: CAN bus error-passive. Check its cable.")]),
        ({"recording_failed": "[Errno 28] No space left on device", "disk_full": True}, [DISK_FULL]),
        ({"recording_failed": ENDED}, [NOT_RECORDED]),
        ({"remote_recording": ENDED}, [REMOTE_NOT_RECORDED]),
        ({"remote_recording": ENDED, "recording_failed": ENDED}, [NOT_RECORDED, REMOTE_NOT_RECORDED]),
        ({"remote_recording": 7}, [REMOTE_NOT_RECORDED]),
        ({"remote_recording": ["x"]}, [REMOTE_NOT_RECORDED]),
        ({"remote_recording": {"a": 1}}, [REMOTE_NOT_RECORDED]),
        ({"remote_recording": None}, []),
        (
            {"behind": BEHIND, "rate_hz": 442.4, "wanted_hz": 500.0},
            [(Priority.LOW, "Site slow: 442 of 500 ticks a second. Close other programs.")],
        ),
    ],
)
def test_what_a_sites_figures_say_is_an_alarm_until_they_say_otherwise(
    console: Console, said: dict[str, Any], expected: list[tuple[Priority, str]]
) -> None:
    console.take("operator/figures", 102 * S, figures(**said))
    assert sorted(shown(console, 102.0)) == expected
    console.take("operator/figures", round(102.2 * S), figures(**bus()))
    shown(console, 102.3)
    fed(console, 105.0, 106.0)
    assert shown(console, 106.0) == []


def test_a_bus_error_is_shown_for_a_while_after_its_count_grew(console: Console) -> None:
    console.take("operator/figures", 102 * S, figures(**bus(controller_errors={"no acknowledge": 3})))
    assert shown(console, 102.0) == [], "these were counted before the console looked"
    console.take("operator/figures", 102 * S, figures(**bus(controller_errors={"no acknowledge": 4})))
    assert shown(console, 102.0) == [(Priority.LOW, "Exoskeleton: CAN bus no acknowledge. Check its cable.")]
    for second in range(103, 114):
        console.take("operator/rendered", second * S, rendered())
        console.take("operator/figures", second * S, figures(**bus(controller_errors={"no acknowledge": 4})))
    assert shown(console, 113.0) == []


def test_a_recording_is_neither_silent_nor_slow(console: Console) -> None:
    console.live = False
    console.around = replace(console.around, page_slow=True, disk_used=1.0)
    assert shown(console, 200.0) == []
