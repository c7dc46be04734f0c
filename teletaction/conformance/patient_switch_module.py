"""Duties of the patient's stop switch."""

from common.buses.serial_messages import BadPayload, PatientSwitchState
from teletaction.conformance.checklist import Checklist, NotApplicable, Outcome
from teletaction.conformance.module_talk import ModuleTalk

PATIENT_SWITCH: Checklist[ModuleTalk] = Checklist("Patient's stop switch; nobody presses it")


@PATIENT_SWITCH.duty("P1", "Its contact is closed in every report")
def _closed(talk: ModuleTalk) -> Outcome:
    states = _states(talk)
    open_ones = sum(not state.closed for state in states)
    return Outcome(open_ones == 0, f"open in {open_ones} of {len(states)} reports")


@PATIENT_SWITCH.duty("P2", "Its pain slider, if it has one, is in every report, and at 0 while nobody moves it")
def _slider(talk: ModuleTalk) -> Outcome:
    sliders = [state.pain_permille for state in _states(talk)]
    known = [permille for permille in sliders if permille is not None]
    if not known:
        return Outcome(True, "no slider")
    said = f"in {len(known)} of {len(sliders)} reports, at {min(known)} to {max(known)} thousandths"
    return Outcome(len(known) == len(sliders) and not any(known), said)


def _states(talk: ModuleTalk) -> list[PatientSwitchState]:
    """Return the reports.

    Raises:
        NotApplicable: there are none, or one has a wrong layout.
    """
    try:
        states = [PatientSwitchState.decode(heard.frame.payload) for heard in talk.reports(talk.at_rest)]
    except BadPayload:
        raise NotApplicable("reports of a wrong layout") from None
    if not states:
        raise NotApplicable("no reports")
    return states
