"""Decides from the patient's stop switch whether the remote fingers must leave the patient, and which fault it is.

Anything but fresh reports of a closed contact counts as a press.
"""

import math
from typing import NamedTuple

from common.faults.fault import Fault, FaultCode
from common.limits import SWITCH_LOST_S, SWITCH_SILENCE_S


class SwitchReading(NamedTuple):
    """What is known of the patient's stop switch at a tick.

    Attributes:
        closed: whether its contact was closed in each report since the last tick, and in the newest one.
        age_s: age of the newest report, s; infinite before the first.
        wrong: what is wrong with its line or its frames; empty when nothing is.
    """

    closed: bool
    age_s: float
    wrong: str


def patient_stop(switch: SwitchReading | None) -> tuple[bool, Fault | None]:
    """Return whether the fingers must leave the patient, and the fault to latch.

    A switch that has not reported yet stops the fingers without a fault, and so does a short silence. A longer silence
    is a fault. Without a switch, nothing is stopped.
    """
    if switch is None:
        return False, None
    if not switch.closed:
        return True, Fault(FaultCode.PATIENT_STOP)
    wrong = switch.wrong
    if not wrong and SWITCH_LOST_S < switch.age_s < math.inf:
        wrong = "is silent"
    if wrong:
        return True, Fault(FaultCode.PATIENT_SWITCH_FAILED, detail=wrong)
    return not 0.0 <= switch.age_s <= SWITCH_SILENCE_S, None
