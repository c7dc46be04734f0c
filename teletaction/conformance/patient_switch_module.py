"""Duties of the patient's stop switch."""

from common.buses.serial_messages import BadPayload, PatientSwitchState
from teletaction.conformance.checklist import Checklist, NotApplicable, Outcome
from teletaction.conformance.module_talk import ModuleTalk

PATIENT_SWITCH: Checklist[ModuleTalk] = Checklist("Patient's stop switch; nobody presses it")


@PATIENT_SWITCH.duty("P1", "Its contact is closed in every report")
def _closed(talk: ModuleTalk) -> Outcome:
    try:
        states = [PatientSwitchState.decode(heard.frame.payload) for heard in talk.reports(talk.at_rest)]
    except BadPayload:
        raise NotApplicable("reports of a wrong layout") from None
    if not states:
        raise NotApplicable("no reports")
    open_ones = sum(not state.closed for state in states)
    return Outcome(open_ones == 0, f"open in {open_ones} of {len(states)} reports")
