"""Duties of the modules without drives: the texture sensor, and the patient's stop switch."""

from typing import TypeVar

from common.buses.serial_messages import BadPayload, PatientSwitchState, TextureSamples
from teletaction.conformance.checklist import Checklist, NotApplicable, Outcome
from teletaction.conformance.every_module import device_times_s
from teletaction.conformance.module_talk import ModuleTalk

TEXTURE: Checklist[ModuleTalk] = Checklist("Texture sensor")
PATIENT_SWITCH: Checklist[ModuleTalk] = Checklist("Patient's stop switch; nobody presses it")

SAMPLES = 10
SAMPLE_S = 0.5e-3
_OFF_S = 20e-6
Report = TypeVar("Report", TextureSamples, PatientSwitchState)


def _reports(talk: ModuleTalk, kind: type[Report], least: int = 1) -> list[Report]:
    """Return the reports at rest.

    Raises:
        NotApplicable: there are fewer than `least`, or one has a wrong layout.
    """
    try:
        reports = [kind.decode(heard.frame.payload) for heard in talk.reports(talk.at_rest)]
    except BadPayload:
        raise NotApplicable("reports of a wrong layout") from None
    if len(reports) < least:
        raise NotApplicable("no reports")
    return reports


def _counts(talk: ModuleTalk) -> list[int]:
    """Return the number of samples in each report at rest."""
    return [len(samples.counts) // 2 for samples in _reports(talk, TextureSamples, 2)]


@TEXTURE.duty("X1", "Ten samples in a message")
def _samples(talk: ModuleTalk) -> Outcome:
    counts = _counts(talk)
    return Outcome(set(counts) == {SAMPLES}, f"{min(counts)} to {max(counts)} samples in {len(counts)} messages")


@TEXTURE.duty(
    "X2", "The time of a message is that of its first sample: 0.5 ms for each sample until the next, within 20 us"
)
def _times(talk: ModuleTalk) -> Outcome:
    counts, reports = _counts(talk), talk.reports(talk.at_rest)
    times_s, numbers = device_times_s(reports), [heard.frame.sequence for heard in reports]
    off_s = [
        abs(times_s[n + 1] - times_s[n] - counts[n] * SAMPLE_S)
        for n in range(len(counts) - 1)
        if numbers[n + 1] == (numbers[n] + 1) & 0xFF
    ]
    worst_s = max(off_s, default=0.0)
    return Outcome(worst_s <= _OFF_S, f"off by {1e6 * worst_s:.0f} us at most")


@PATIENT_SWITCH.duty("P1", "Its contact is closed in every report")
def _closed(talk: ModuleTalk) -> Outcome:
    states = _reports(talk, PatientSwitchState)
    open_ones = sum(not state.closed for state in states)
    return Outcome(open_ones == 0, f"open in {open_ones} of {len(states)} reports")


@PATIENT_SWITCH.duty("P2", "Its pain slider, if it has one, is in every report, and at 0 while nobody moves it")
def _slider(talk: ModuleTalk) -> Outcome:
    sliders = [state.pain_permille for state in _reports(talk, PatientSwitchState)]
    known = [permille for permille in sliders if permille is not None]
    if not known:
        return Outcome(True, "no slider")
    said = f"in {len(known)} of {len(sliders)} reports, at {min(known)} to {max(known)} thousandths"
    return Outcome(len(known) == len(sliders) and not any(known), said)
