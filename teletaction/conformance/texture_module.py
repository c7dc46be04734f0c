"""Duties of the texture sensor's module."""

from common.buses.serial_messages import BadPayload, TextureSamples
from teletaction.conformance.checklist import Checklist, NotApplicable, Outcome
from teletaction.conformance.every_module import device_times_s
from teletaction.conformance.module_talk import ModuleTalk

TEXTURE: Checklist[ModuleTalk] = Checklist("Texture sensor")

SAMPLES = 10
SAMPLE_S = 0.5e-3
_OFF_S = 20e-6


def _counts(talk: ModuleTalk) -> list[int]:
    """Return the number of samples in each report at rest."""
    try:
        reports = talk.reports(talk.at_rest)
        counts = [len(TextureSamples.decode(heard.frame.payload).counts) // 2 for heard in reports]
    except BadPayload:
        raise NotApplicable("reports of a wrong layout") from None
    if len(counts) < 2:
        raise NotApplicable("no reports")
    return counts


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
