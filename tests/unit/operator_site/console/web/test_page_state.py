"""The state on the page: silence wins over a stop, a stop over engaging, a silent link over engaged."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_figures
from common.fingers import FINGER_Y_M
from common.limits import GAP_S
from common.wire.packets import LinkState
from operator_site.console.alarms.alarm_rules import Surroundings
from operator_site.console.map.lump_areas import Searched
from operator_site.console.model import Console
from operator_site.console.state.site_now import SILENT_S
from operator_site.console.web.page_state import page_state
from operator_site.coupling.coupling import Coupling
from remote_site.thermal.thermal_result import SURE
from tests.unit.operator_site.console.fed import INDEX, TOUCHING, S, figures, happen, rendered, touch
from tests.unit.operator_site.console.page_messages import read_frame
from tests.unit.operator_site.console.touch_rows import sample

AT_S = 102.0


def engaged(gap_s: float | None = 0.004) -> Console:
    """Engaged; the site was last heard at AT_S."""
    console = Console()
    for what in ("connected", "engaged"):
        happen(console, 100.0, what)
    at_ns = round(AT_S * S)
    console.take("operator/figures", at_ns, figures())
    console.take("operator/touch", at_ns, touch(1, at_ns - 20_000_000))
    console.take("operator/rendered", at_ns, rendered(gap_s=gap_s))
    return console


@pytest.mark.parametrize("live", [True, False])
def test_the_check_list_of_a_recording_judges_nothing_of_the_console_that_plays_it(live: bool) -> None:
    console = Console(live=live)
    happen(console, 100.0, "connected")
    console.take("operator/figures", round(AT_S * S), figures(remote_consent={"consented": ["touch"]}))
    names = {check["name"] for check in page_state(console, AT_S, lambda _: True, "operator.toml")["checks"]}
    assert names >= {"operator site", "calibration", "link"}
    assert ({"disk", "sound", "consent"} & names) == ({"disk", "sound", "consent"} if live else set())


@pytest.mark.parametrize(
    ("sound", "ready", "text"), [("", False, "Not heard yet."), ("heard", True, ""), ("refused", True, "off")]
)
def test_the_check_list_does_not_call_a_refused_sound_ready(sound: str, ready: bool, text: str) -> None:
    console = Console()
    console.around = Surroundings(sound=sound)
    found = page_state(console, AT_S, lambda _: True, "operator.toml")["checks"]
    (check,) = (check for check in found if check["name"] == "sound")
    assert (check["ready"], check["text"]) == (ready, text)


def words(console: Console, now_s: float) -> tuple[str, LinkState]:
    """The state's word, and the state that a picture is drawn with."""
    console.step(now_s)
    state: dict[str, Any] = page_state(console, now_s, lambda _: True, "operator.toml")
    return state["session"]["state"], read_frame(console.picture(now_s, 1, None)).flags.state


def test_lumps_and_next_place_of_the_search_are_on_the_map_until_another_map_begins() -> None:
    console = engaged()
    corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    shown = {
        "x_mm": 0.3,
        "y_mm": 0.3,
        "probability": 0.95,
        "stiffness_ratio": 1.4,
        "at_edge": True,
        "outline_mm": corners,
    }
    console.searched = Searched([{**shown, "area_mm2": 4}], (12.0, 3.5))
    state = page_state(console, AT_S, lambda _: True, "operator.toml")
    assert (state["map"]["lumps"], state["map"]["next_mm"]) == ([shown], (12.0, 3.5))
    console.begin_map()
    begun = page_state(console, AT_S, lambda _: True, "operator.toml")["map"]
    assert (begun["lumps"], begun["next_mm"]) == ([], None)


def test_a_finger_has_the_contrast_with_the_surroundings_on_the_map_and_a_sure_answer_stays() -> None:
    console = engaged()
    x_m, y_m = TOUCHING["x_m"], TOUCHING["y_m"] + FINGER_Y_M[INDEX]
    for number, (quantity, value) in enumerate((("temperature", 22.1), ("stiffness", math.log(400.0))), 1):
        console.tactile_map.take(sample(quantity, number, x_m + 0.02, y_m, value, 0.01**2))
    finger = page_state(console, AT_S, lambda _: True, "operator.toml")["fingers"][INDEX]
    assert finger["against"] == {"temperature": "+2.0 ± 0.3 K", "stiffness": "2.00 ± 0.06 times"}
    assert (finger["decision"], finger["held_s"]) == ("IDENTIFIED", None)
    at_ns = round((AT_S + 0.5) * S)
    console.take("operator/touch", at_ns, touch(2, at_ns, contact=0.0, thermal_status=0.0))
    held = page_state(console, AT_S + 0.5, lambda _: True, "operator.toml")["fingers"][INDEX]
    assert (held["line"], held["held_s"]) == (finger["line"], 0.5)


@given(
    age_s=st.floats(0.0, 3.0) | st.floats(0.0, 1e4),
    gap_s=st.none() | st.floats(0.0, 2.0),
    both=st.booleans(),
    wanted=st.booleans(),
    stopping=st.booleans(),
)
def test_nothing_old_and_nothing_stopped_is_shown_as_engaged_or_engaging(
    age_s: float, gap_s: float | None, both: bool, wanted: bool, stopping: bool
) -> None:
    console = engaged()
    at_ns = round(AT_S * S)
    said = {"wanted": wanted, "stop_asked_ns": at_ns if stopping else None}
    console.take("operator/figures", at_ns, figures(**said))
    console.take("operator/rendered", at_ns, rendered(both, gap_s))
    word, drawn = words(console, AT_S + age_s)
    link_silent = gap_s is not None and gap_s > GAP_S
    if age_s > SILENT_S + 1e-6 or link_silent or stopping:
        assert word not in ("engaged", "engaging")
        assert drawn is not LinkState.ENGAGED
    if not both:
        assert drawn is not LinkState.ENGAGED
    if age_s < SILENT_S - 1e-6 and both and not link_silent and not stopping:
        assert (word, drawn) == ("engaged", LinkState.ENGAGED)


@pytest.mark.parametrize(
    ("gap_s", "age_s", "word", "alarm"),
    [
        (0.004, 0.4, "engaged", ""),
        (0.004, 0.6, "silent", "No data for 0.6 s. Screen is not live."),
        (0.11, 0.01, "lost", "LINK LOST. Outputs are neutral. Wait for the link."),
    ],
)
def test_silence_is_shown_as_soon_as_its_alarm_says_so(gap_s: float, age_s: float, word: str, alarm: str) -> None:
    console = engaged(gap_s)
    drawn = LinkState.DISCONNECTED if alarm else LinkState.ENGAGED
    assert words(console, AT_S + age_s) == (word, drawn)
    assert [one.text for one in console.alarms.listed] == ([alarm] if alarm else [])


def test_answers_of_the_site_are_no_proof_of_what_is_drawn() -> None:
    console = engaged()
    for tenth in range(1, 10):
        now_s = AT_S + 0.1 * tenth
        console.take_answer(now_s, {"state": "engaged", "session": 7, "time_ns": round(now_s * S)})
    assert words(console, now_s) == ("silent", LinkState.DISCONNECTED)
    assert console.alarms.listed[0].text == "No data for 0.9 s. Screen is not live."


def test_a_stop_is_judged_by_answers_where_nothing_else_comes() -> None:
    console = engaged()
    now_s = AT_S + 1.0
    said = {"state": "fault", "fault": Fault(FaultCode.OPERATOR_STOP), "time_ns": round(now_s * S)}
    asked = {"stop_asked_ns": round((now_s - 0.4) * S), "stop_devices": ["exoskeleton"], "stop_after_s": [None]}
    console.take_answer(now_s, said | asked)
    assert words(console, now_s)[0] == "stopped"
    texts = [alarm.text for alarm in console.alarms.listed]
    assert "STOP NOT CONFIRMED: Exoskeleton. Use the hardware switch." in texts


@pytest.mark.parametrize("state", ["connected", "engaged"])
def test_a_stop_cancels_engaging_at_once(state: str) -> None:
    console = engaged()
    console.take("operator/rendered", round(AT_S * S), rendered(engaged=False))
    console.take_answer(AT_S, {"state": state, "wanted": True, "session": 7})
    assert words(console, AT_S)[0] == "engaging"
    console.take_answer(AT_S, {"state": state, "wanted": True, "session": 7, "stop_asked_ns": round(AT_S * S)})
    assert words(console, AT_S)[0] == "stopped"


@pytest.mark.parametrize(
    ("fault", "alarm"),
    [
        (Fault(FaultCode.PATIENT_STOP), "Patient stopped. Remote side asks patient, then clears."),
        (
            Fault(FaultCode.PATIENT_SWITCH_FAILED, detail="is silent"),
            "Patient's switch is silent. Remote side mends it.",
        ),
    ],
)
def test_the_patients_stop_is_shown_as_what_it_is_with_the_next_act(fault: Fault, alarm: str) -> None:
    console = engaged()
    stopped = figures(state="connected", remote_fault=fault_figures(fault))
    console.take("operator/figures", round(AT_S * S), stopped)
    console.step(AT_S)
    state = page_state(console, AT_S, lambda _: True, "operator.toml")
    assert [shown["text"] for shown in state["alarms"] if shown["priority"] == "high"] == [alarm]
    assert state["engage"]["refusal"] == "Cannot engage: patient's stop. Remote side clears it."


def test_clutch_scale_and_edges_are_shown_as_the_site_reports_them() -> None:
    console = engaged()
    shown = page_state(console, AT_S, lambda _: True, "operator.toml")["coupling"]
    assert shown == {"open": False, "scale": 1, "edges": []}
    held = (0.0, 0.0, (0.0,) * 5)
    coupling = Coupling(True, 5, *held, 0.65, -0.65, (0.0, 0.0, 0.0, 0.0, -0.0095))
    console.take("operator/coupling", round(AT_S * S), coupling.pack())
    shown = page_state(console, AT_S, lambda _: True, "operator.toml")["coupling"]
    assert shown == {"open": True, "scale": 5, "edges": ["x+", "y-", "low"]}
    console.take(
        "operator/figures", round(AT_S * S), figures(coupling=structs.asdict(Coupling(False, 0, *held, *held)))
    )
    assert console.damaged == 1, "no scale is 0"
    assert page_state(console, AT_S, lambda _: True, "operator.toml")["coupling"] == shown
    figured = figures(coupling=structs.asdict(Coupling(False, 2, *held, *held)))
    console.take("operator/figures", round(AT_S * S), figured)
    shown = page_state(console, AT_S, lambda _: True, "operator.toml")["coupling"]
    assert shown == {"open": False, "scale": 2, "edges": []}, "a console that starts late has it from the figures"
    assert console.damaged == 1


def test_pain_its_age_and_the_force_limit_are_shown_with_the_act_that_ends_it() -> None:
    console = engaged()
    answer: dict[str, Any] = {"state": "engaged", "session": 7, "time_ns": round(AT_S * S)}

    def shown(now_s: float, **patient: object) -> Any:
        console.take_answer(AT_S, answer | patient)
        return page_state(console, now_s, lambda _: True, "operator.toml")["patient"]

    assert shown(AT_S) is None, "no slider"
    asked_ns = round((AT_S - 0.5) * S)
    said = {"pain": 6.04, "patient_limit_n": 2.13, "pain_reports": [0.02, 0.01, 2.6, 7.0], "pain_ns": asked_ns}
    assert shown(AT_S, **said) == {
        "pain": 6.0,
        "age_s": 0.5,
        "limit": "Force limited to 2.1 N by the patient's threshold.",
        "ends": "Remote side asks patient, then: teletaction session restore-force.",
        "reports": [[20.0, 10.0, 2.6, 7.0]],
        "tender": None,
        "agreed": False,
    }
    assert shown(AT_S + 3.0, **said)["pain"] is None, "an old answer is not shown"
    said |= {"pain": None, "patient_limit_n": None, "pain_reports": []}
    assert shown(AT_S, **said) == {
        **{"pain": None, "age_s": 0.5, "limit": None, "ends": None, "reports": []},
        **{"tender": None, "agreed": False},
    }
    answer["session"] = 0
    assert shown(AT_S) is None


def test_the_chart_has_its_line_where_the_remote_site_names_a_material() -> None:
    assert page_state(Console(), 0.0, lambda _: True, "")["decide_at"] == SURE
