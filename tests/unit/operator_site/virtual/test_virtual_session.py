"""The session with a virtual environment, and the operator site in it: states, the desk, the E-stop, a lost hand."""

import math
from itertools import pairwise

import pytest

from common.faults.fault import Fault, FaultCode
from common.limits import FORCE_RAMP_UP_N_S, FORCE_SAFE_S
from common.link.session_state import Refused
from common.wire.packets import LinkState
from operator_site.force.passive_contact import LENT_J, RESTED_J
from operator_site.safety.gated_output import GatedOutput
from operator_site.site import ENGAGE_PATIENCE_S
from tests.unit.operator_site.virtual_touch import INDEX, Working

ALUMINIUM_M = -0.17


def neutral(output: GatedOutput) -> bool:
    return not any(output.force_n + output.motor_rpm + output.peltier_drive)


def test_a_session_engages_only_on_request_with_its_devices_present() -> None:
    working = Working(engage=False)
    assert all(map(neutral, working.press(ALUMINIUM_M)))
    assert working.state is LinkState.CONNECTED
    working.devices.lacking = "exoskeleton: gone"
    working.ask("engage")
    assert all(map(neutral, working.go(0.2)))
    working.devices.lacking = ""
    begins_n = math.sqrt(2.0 * 400.0 * (RESTED_J + LENT_J))
    assert working.go(0.2)[-1].force_n[INDEX] == pytest.approx(begins_n, rel=0.03), "where it came to lie unfelt"
    assert working.state is LinkState.ENGAGED
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0
    assert working.ask("disengage")["state"] == "connected"
    assert neutral(working.go(0.2)[-1])
    assert working.state is LinkState.CONNECTED, "it stays so until it is asked"


def test_an_emergency_stop_latches_until_it_is_cleared_and_reports_the_devices() -> None:
    working = Working()
    working.press(ALUMINIUM_M)
    working.devices.on = {"index tacttip": "motor on"}
    answer = working.ask("estop")
    assert (answer["state"], answer["wanted"]) == ("fault", False)
    assert neutral(working.go(0.2)[-1])
    assert working.ask("status")["estop"] == ""
    working.devices.on = {"index tacttip": ""}
    working.go(0.01)
    assert working.ask("status")["estop"].startswith("stopped, confirmed by every device after")
    with pytest.raises(Refused, match="emergency stop by the operator"):
        working.ask("engage")
    assert all(map(neutral, working.go(1.0)))
    assert working.ask("clear_fault")["state"] == "connected"
    assert all(map(neutral, working.go(0.2)))
    working.ask("engage")
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0
    with pytest.raises(Refused, match="no fault is latched"):
        working.ask("clear_fault")
    working.devices.on = {"exoskeleton": "no report"}
    working.ask("estop")
    working.go(1.0)
    assert working.ask("status")["estop"].endswith("by exoskeleton: no report")


def test_a_fault_that_is_cleared_before_the_next_tick_also_needs_a_new_request() -> None:
    working = Working()
    working.press(ALUMINIUM_M)
    working.devices.cut = [Fault(FaultCode.MODULE_CUT_OUT, "index")]
    working.go(0.002)
    working.devices.cut = []
    assert working.ask("clear_fault")["state"] == "connected"
    assert neutral(working.go(0.2)[-1])
    assert working.state is LinkState.CONNECTED


def test_a_request_to_engage_that_waits_too_long_for_a_device_lapses() -> None:
    working = Working(engage=False)
    working.devices.lacking = "exoskeleton: gone"
    working.go(0.01)
    working.ask("engage")
    working.go(ENGAGE_PATIENCE_S + 0.1)
    assert not working.ask("status")["wanted"]
    working.devices.lacking = ""
    assert all(map(neutral, working.go(0.2)))
    assert working.state is LinkState.CONNECTED
    working.ask("engage")
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0


def test_a_fulfilled_request_does_not_lapse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("operator_site.site.ENGAGE_PATIENCE_S", 0.5)
    working = Working(engage=False)
    working.go(0.01)
    working.ask("engage")
    working.press(ALUMINIUM_M)
    assert working.state is LinkState.ENGAGED


def test_an_unmeasured_hand_touches_nothing() -> None:
    working = Working()
    working.devices.seen = False
    assert all(map(neutral, working.press(ALUMINIUM_M)))
    assert working.client.touch is None
    working.devices.seen = True
    working.press(ALUMINIUM_M)
    working.devices.seen = False
    lost = working.go(0.5)
    assert lost[0].force_n[INDEX] > 1.0
    assert all(neutral(output) for output in lost[round(FORCE_SAFE_S / 0.002) :])
    working.devices.seen = True
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0


def test_drives_that_went_off_by_themselves_begin_from_zero_force() -> None:
    working = Working()
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0
    working.devices.pushes = False
    assert neutral(working.go(0.2)[-1])
    assert working.state is LinkState.ENGAGED
    working.devices.pushes = True
    forces = [0.0, *(output.force_n[INDEX] for output in working.go(0.1))]
    assert forces[-1] > 0.3
    assert max(after - before for before, after in pairwise(forces)) <= FORCE_RAMP_UP_N_S * 0.002 + 1e-9


def test_notes_are_kept_and_wrong_ones_refused() -> None:
    working = Working()
    with pytest.raises(Refused, match="there is no session"):
        working.ask("annotate", text="early")
    working.go(0.01)
    working.ask("annotate", text="cold")
    with pytest.raises(Refused, match="a note needs a text"):
        working.ask("annotate")
    with pytest.raises(Refused, match="only the remote site can do this"):
        working.ask("hello")
    happened = working.client.session.take_happenings()
    assert [(each.what, each.text) for each in happened] == [("note", "cold")]


def test_the_status_file_has_the_figures_of_any_operator_site() -> None:
    working = Working()
    working.press(ALUMINIUM_M)
    figures = working.site.figures()
    assert (figures["state"], figures["fault"], figures["remote_fault"]) == ("engaged", None, None)
    assert figures["received"] == {"touch": 500}
    assert figures["refused"] == {"touch": {}, "damaged": {}}
    working.site.goodbye()


def test_a_site_that_requires_a_console_pauses_without_one() -> None:
    working = Working(required_s=1.0)
    assert working.press(ALUMINIUM_M)[-1].force_n[INDEX] > 1.0
    for _ in range(10):
        working.ask("attend", seen=True)
        assert not neutral(working.go(0.5)[-1]), "somebody watches"
    working.ask("attend", seen=False)
    assert neutral(working.go(1.5)[-1])
    assert working.state is LinkState.CONNECTED
    assert not working.client.want_engaged, "engaging again is asked for"
    reasons = [happening.text for happening in working.client.session.take_happenings()]
    assert reasons == [], "the site has taken them for its recording"
    working.ask("attend", seen=True)
    assert neutral(working.go(0.5)[-1]), "nothing moves by being seen again"
