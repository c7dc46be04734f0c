"""Checks whether a labelled touch can be used in a calibration."""

from collections.abc import Sequence

import numpy as np

from common.exploration.contact_detector import CONTACT_OFF_N
from remote_site.thermal.thermal_identification import BOUNCE_S, GAP_S, LANDING_S, LOST_S
from remote_site.thermal.touch_start import RecordedTouch, find_touch
from remote_site.traces.trace_files import ThermalTrace

LEAST_DIFFERENCE_K = 1.0
"""Minimum difference between plate and object in a calibration touch, K."""


def touch_of(trace: ThermalTrace) -> RecordedTouch:
    """Return the touch in a trace; raises ValueError where there is no contact."""
    touch = find_touch(trace)
    if touch is None:
        raise ValueError(f"{trace.name}: column force_n: no contact (0.30 N held for 50 ms)")
    return touch


def contact_length_s(touch: RecordedTouch) -> float:
    """Return the time from contact to its end or that of the trace, s; a finger that bounces at first stays."""
    since_s, light_s = 0.0, None
    for since_s, _, force_n in touch.readings():
        if force_n >= CONTACT_OFF_N:
            light_s = None
        else:
            light_s = since_s if light_s is None else light_s
            if since_s - light_s >= (BOUNCE_S if light_s < LANDING_S else LOST_S):
                return light_s
    return since_s


def check_difference(touch: RecordedTouch, object_c: float) -> None:
    """Refuse a touch whose plate is too close to its object.

    Raises:
        ValueError: they differ by less than LEAST_DIFFERENCE_K.
    """
    if abs(touch.start_c - object_c) < LEAST_DIFFERENCE_K:
        raise ValueError(
            f"{touch.trace.name}: plate {touch.start_c:.2f} C and object {object_c:.2f} C are too close to calibrate; "
            "check object_c, or leave this touch out"
        )


def check_gaps(touch: RecordedTouch, until_s: float) -> None:
    """Refuse a touch that lacks readings before `until_s` seconds after contact.

    Raises:
        ValueError: there is none for longer than identification accepts.
    """
    since_s = touch.trace.time_s[touch.first :] - touch.contact_s
    steps_s = np.diff(since_s)
    gaps = np.flatnonzero((steps_s > GAP_S) & (since_s[:-1] < until_s))
    if len(gaps):
        raise ValueError(
            f"{touch.trace.name}: no reading for {steps_s[gaps[0]]:.2f} s, {since_s[gaps[0]]:.2f} s after contact, "
            f"where {GAP_S} s are the most; leave this touch out, or record it again"
        )


def begins_in_contact(name: str) -> str:
    """Return the warning of a trace that begins in contact."""
    return (
        f"{name}: begins in contact, so that neither the start of the touch nor the plate's temperature at contact is "
        "known; record from 0.5 s before contact, or leave this touch out"
    )


def without_reference(touches: Sequence[RecordedTouch]) -> list[str]:
    """Return the names of the traces that have no unheated sensor."""
    return [touch.trace.name for touch in touches if touch.trace.reference_c is None]


def lacks_reference(names: Sequence[str], touches: int, result: str) -> str:
    """Return the warning of traces without an unheated sensor among all touches, and its result."""
    return f"{names[0]}: column reference_c is missing in {len(names)} of {touches} touches, so that {result}"
